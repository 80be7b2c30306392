"""Many runs of one model, side by side: their numbers, how they are made, and what is observed of them."""
