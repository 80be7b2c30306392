"""Springs and dampers, as they are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .rope import Rope


@dataclass(frozen=True)
class Strut(Rope):
    """A spring or a damper between two points (2, 2), in m, of the frames of its two `links`; -1 is the ground."""

    kind: Literal["spring", "damper"]
