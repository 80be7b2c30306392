"""Templates of the generated files; each looks like the file it makes."""
