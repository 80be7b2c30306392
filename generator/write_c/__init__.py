"""The C of a model, in every type of numbers, and its binding to Python."""
