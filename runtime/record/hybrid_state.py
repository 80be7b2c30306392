"""Where a run has come to, whole: what it goes on from by the same bits."""

from __future__ import annotations

import io
import lzma
import os
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..files import read_path, write_whole
from .frozen import freeze

UNREADABLE = (
    ArithmeticError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    lzma.LZMAError,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)
"""What numpy and its packer raise for a file that is damaged, or is another."""

ZIPPED = b"PK\x03\x04"
"""How an .npz file begins."""

NUMBERS, WORDS = ("rtol", "atol", "step"), ("method", "drift", "on_gain")
"""The settings of a run that goes on by the same bits."""


@dataclass(frozen=True, eq=False)
class HybridState:
    """The state of a run at ``t`` (s): ``q`` (nq,), ``u`` (nu,), what is held, and all that the run remembers.

    ``simulate(model, state=run.state, until=...)`` goes on from it as if the run had not ended: each bit is that of a
    run to the later end with a stop at ``t``. ``memory`` is the core's own record of it, for the same kind of
    processor; ``parameters`` are the model's values, of which events have ``changed`` those, ``settings`` the method,
    drift, step and tolerances. Values of inputs are no part of it: give them again.
    """

    model: str
    t: float
    q: FloatArray
    u: FloatArray
    parameters: Mapping[str, float] = field(repr=False)
    settings: Mapping[str, Any] = field(repr=False)
    memory: bytes = field(repr=False)
    changed: frozenset[str] = field(default=frozenset(), repr=False)

    def __post_init__(self) -> None:
        freeze(self, "q", "u")

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the state to an .npz file, whole or not at all; :meth:`load` reads it."""
        target = read_path(path, "an .npz file")
        if target.suffix != ".npz":
            raise ValueError(f"path: a state is saved as .npz, found {target.name!r}, expected a name that ends so")
        arrays: dict[str, Any] = {
            "model": np.array(self.model),
            "t": np.array(self.t),
            "q": self.q,
            "u": self.u,
            "parameter_names": np.array(list(self.parameters), dtype=str),
            "parameter_values": np.array(list(self.parameters.values()), dtype=float),
            "changed": np.array(sorted(self.changed), dtype=str),
            "settings": np.array([self.settings[name] for name in NUMBERS]),
            "words": np.array([self.settings[name] for name in WORDS]),
            "memory": np.frombuffer(self.memory, dtype=np.uint8),
        }
        write_whole(target, lambda part: np.savez_compressed(part, **arrays))
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> HybridState:
        """The state that :meth:`save` wrote.

        Raises ``FileNotFoundError`` where there is no such file, and ``ValueError`` for one that holds no state.
        """
        source = read_path(path, "an .npz file")
        if not source.is_file():
            found = "a folder" if source.is_dir() else "no such file"
            raise FileNotFoundError(
                f"{path}: found {found}, expected the .npz file that HybridState.save wrote; correct the path"
            )
        content = source.read_bytes()
        try:
            if not content.startswith(ZIPPED):  # NumPy would take it for a pickle, and advise to load that
                raise ValueError("no .npz file")
            with np.load(io.BytesIO(content), allow_pickle=False) as file:
                numbers = zip(NUMBERS, file["settings"].tolist(), strict=True)
                words = zip(WORDS, file["words"].tolist(), strict=True)
                names, values = file["parameter_names"].tolist(), file["parameter_values"].tolist()
                return cls(
                    model=str(file["model"]),
                    t=file["t"].item(),
                    q=file["q"],
                    u=file["u"],
                    parameters=dict(zip(names, values, strict=True)),
                    settings=dict(numbers) | dict(words),
                    memory=file["memory"].tobytes(),
                    changed=frozenset(file["changed"].tolist() if "changed" in file else ()),
                )
        except UNREADABLE as error:
            raise ValueError(f"{path}: found no state of a run, expected what HybridState.save wrote") from error
