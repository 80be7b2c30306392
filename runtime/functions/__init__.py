"""Runs as functions of numbers: their values and derivatives, as optimisers and other packages ask for them."""
