"""Parameters of a model from measurements of its motion, and from a curve that a point is to draw."""
