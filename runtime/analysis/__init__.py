"""Questions to a model that need no run: torques of a wanted motion or of a crank, and where it rests."""
