"""What effects have in common: what they answer, and how their tables write points, angles, directions and formulas."""
