"""What can be wrong with numbers that are put into equations."""

from __future__ import annotations


class FoldError(ValueError):
    """Values of a scene leave an equation without a finite number; the message names the quantity."""
