"""Everything that is written to disk: listing, C, binding, package data; compiling and caching."""
