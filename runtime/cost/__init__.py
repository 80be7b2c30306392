"""What accuracy costs in time, and what parts of a model do."""
