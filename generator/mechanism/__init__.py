"""Links, joints, topology: the mechanism as a graph."""
