"""What a person reads of a mechanism: the listing, the equations in LaTeX, and what ``ccgen show`` says."""
