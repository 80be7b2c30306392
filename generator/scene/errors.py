"""Faults of a scene: what was found, where, what was expected, what to do."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from unicodedata import category

_UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Categories of control and format signs, halves of signs, and separators of lines."""

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
        return escaped(": ".join(part for part in (place, self.key, self.message) if part))


def escaped(text: str) -> str:
    """The text on one line, with signs that would move a terminal's cursor or hide written as in Python, ``\\x1b``."""
    return "".join(repr(sign)[1:-1] if category(sign) in _UNSEEN else sign for sign in text)


MOST_TOLD = 50
"""Faults that are told one by one: more than a person mends before reading again."""


class SceneError(Exception):
    """A scene that cannot be used; ``faults`` holds everything wrong with it, in the order of the file. The message has
    the first fifty of them, and how many more there are, or that there are more than have been looked for."""

    def __init__(self, faults: tuple[Fault, ...], *, all_found: bool = True) -> None:
        told, more = [str(fault) for fault in faults[:MOST_TOLD]], len(faults) - MOST_TOLD
        if more > 0 or not all_found:
            count = f"{more} more" if all_found else "more"
            told.append(f"{escaped(faults[0].file)}: and {count}; mend these first")
        super().__init__("\n".join(told))
        self.faults = faults


class Report:
    """Collects the faults of one scene. ``lines`` says in which line of ``file`` each key stands."""

    def __init__(self, file: str, lines: Mapping[Path, int] | None = None) -> None:
        self.file = file
        self.written: Mapping[Path, Path] = {}
        """Where a value is written that is read at another path: the tables of parts, which stand in several places."""
        self.renamed: dict[str, str] = {}
        """Names of placed parts as the parts have them: what differs by these alone is told once, as it is first."""
        self._lines = lines or {}
        self._faults: dict[Fault, tuple[Path, str]] = {}
        self._told: dict[Fault, Fault] = {}
        self._places: dict[Path, None] = {}
        self._remarks: list[Fault] = []

    def add(self, path: Path, message: str, also: Iterable[Path] = ()) -> None:
        """Note a fault at ``path``, or at the closest table that the file has; one sentence tells of what is wrong at
        the places ``also``."""
        fault = self._fault(path, message)
        if self._told.setdefault(self._as_in_parts(fault), fault) == fault:
            self._faults[fault] = path, message
        self._places |= dict.fromkeys((path, *also))

    def remark(self, path: Path, message: str) -> None:
        """Note how the value at ``path`` is understood, where something else may be meant."""
        self._remarks.append(self._fault(path, message))

    @property
    def found(self) -> tuple[tuple[Path, str], ...]:
        """All faults so far, each with its path."""
        return tuple(self._faults.values())

    @property
    def places(self) -> tuple[Path, ...]:
        """All places that are wrong."""
        return tuple(self._places)

    @property
    def remarks(self) -> tuple[str, ...]:
        """All remarks so far, in the order of the file."""
        return tuple(map(str, sorted(dict.fromkeys(self._remarks), key=lambda remark: remark.line or 0)))

    def below(self, path: Path) -> Callable[[Path, str], None]:
        """``add`` for keys inside the table at ``path``."""
        return lambda key, message: self.add(path + key, message)

    def stop_if_any(self) -> None:
        """Raise ``SceneError`` with all faults so far, if there are any."""
        if self._faults:
            raise SceneError(tuple(sorted(self._faults, key=lambda fault: fault.line or 0)))

    def _fault(self, path: Path, message: str) -> Fault:
        for length in range(len(path), 0, -1):
            if path[:length] in self.written:
                path = self.written[path[:length]] + path[length:]
                break
        return Fault(self.file, self._line(path), key_text(path), message)

    def _as_in_parts(self, fault: Fault) -> Fault:
        if not self.renamed:
            return fault

        def first(name: str) -> str:
            while name in self.renamed:
                name = self.renamed[name]
            return name

        return replace(fault, message=re.sub(r"\w+", lambda word: first(word[0]), fault.message))

    def _line(self, path: Path) -> int | None:
        for length in range(len(path), -1, -1):
            if path[:length] in self._lines:
                return self._lines[path[:length]]
        return 1 if self._lines else None


def key_text(path: Path) -> str:
    """The path as a person writes it: ``ground[0].restitution``, with an empty key in quotes."""
    text = ""
    for part in path:
        key = f"[{part}]" if isinstance(part, int) else part or '""'
        text += f".{key}" if text and isinstance(part, str) else key
    return text
