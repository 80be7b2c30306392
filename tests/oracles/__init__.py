"""Independent references: nothing in here imports ccgen."""
