"""What hard cases call to note the figures that they reach."""

from __future__ import annotations

from collections.abc import Callable

Reach = Callable[[str, float, float], None]
"""Notes what has been reached, the figure and its bound."""
