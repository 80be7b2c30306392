"""The generated package: what it tells the runtime, which files it consists of, and how it takes its place."""
