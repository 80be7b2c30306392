"""What a simulated motion leaves: its rows, impacts and phases, kept, looked up between rows, and as tables."""
