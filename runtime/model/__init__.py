"""A generated model: its parameters, and the functions of its state. ``Model`` is what its user has in hand."""

from .model import Model

__all__ = ["Model"]
