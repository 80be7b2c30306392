"""How a run is made: what is checked before, the compiled run, and the record of what it found."""
