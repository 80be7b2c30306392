"""Effects that a scene can name, one module each. To add one, write its module and add its entry below."""

from . import gravity, ground
from .effect import Contact, Effect, Entry, Level, Surroundings

REGISTRY: tuple[Entry, ...] = (
    gravity.ENTRY,
    ground.ENTRY,
)

__all__ = ["REGISTRY", "Contact", "Effect", "Entry", "Level", "Surroundings"]
