"""Faults of a scene: what was found, where, what was expected, what to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

Path = tuple[str | int, ...]
"""Where a value stands in a scene: ``("ground", 0, "restitution")`` is ``restitution`` of the first ``[[ground]]``."""


@dataclass(frozen=True)
class Fault:
    """One thing wrong with a scene. ``line`` counts from 1; ``None`` where the scene is not a file."""

    file: str
    line: int | None
    key: str
    message: str

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        return ": ".join(part for part in (place, self.key, self.message) if part)


class SceneError(Exception):
    """A scene that cannot be used; ``faults`` holds everything wrong with it, in the order of the file."""

    def __init__(self, faults: tuple[Fault, ...]) -> None:
        super().__init__("\n".join(str(fault) for fault in faults))
        self.faults = faults


class Report:
    """Collects the faults of one scene. ``lines`` says in which line of ``file`` each key stands."""

    def __init__(self, file: str, lines: Mapping[Path, int] | None = None) -> None:
        self.file = file
        self._lines = lines or {}
        self._faults: list[Fault] = []

    def add(self, path: Path, message: str) -> None:
        """Note a fault at ``path``, or at the closest table that the file has."""
        fault = Fault(self.file, self._line(path), key_text(path), message)
        if fault not in self._faults:
            self._faults.append(fault)

    def below(self, path: Path) -> Callable[[Path, str], None]:
        """``add`` for keys inside the table at ``path``."""
        return lambda key, message: self.add(path + key, message)

    def stop_if_any(self) -> None:
        """Raise ``SceneError`` with all faults so far, if there are any."""
        if self._faults:
            raise SceneError(tuple(sorted(self._faults, key=lambda fault: fault.line or 0)))

    def _line(self, path: Path) -> int | None:
        for length in range(len(path), 0, -1):
            if path[:length] in self._lines:
                return self._lines[path[:length]]
        return 1 if self._lines else None


def key_text(path: Path) -> str:
    """The path as a person writes it: ``ground[0].restitution``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text
