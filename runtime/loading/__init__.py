"""From a generated package on disk to a model: whether it is whole, runs here, and what of it is loaded."""
