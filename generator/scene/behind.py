"""Faults that stand behind others: those of a table that has a wrong value, those of a start whose links have one.

A scene with faults is read again with a stand-in for every wrong value, and once more with other stand-ins. What is
found wrong in both readings, and in the same words, does not hang on the stand-ins, and so on no value that is wrong.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping
from typing import Any

from ..effect_base.table import Table, innermost, kind_of_key, part_of
from ..mechanism.mechanism import Mechanism
from .errors import MOST_TOLD, Path, Report
from .meant import kinds_of, meant_key, required_keys
from .stand_ins import Names, names, stand_in

Read = Callable[[Mapping[str, Any], Report, Collection[Path], bool], Mechanism | None]
"""Reads tables, some places of which have been changed, and notes their faults; the mechanism that it comes to. Whether
the start is to be made consistent too comes last: that can take long."""

_READINGS = 2
_ROUNDS = 6
"""In one reading: each round puts stand-ins for what the one before it has found."""
_TRIES = 3
"""Stand-ins for one place, of which some may not go with what stands beside them."""
_REMOVED = object()


def tell_behind(
    tables: Mapping[str, Any],
    mechanism: Mechanism | None,
    report: Report,
    models: Mapping[str, type[Table]],
    read: Read,
) -> None:
    """Add to the faults of ``report`` those that stand behind them; ``mechanism``: what is known of it with them.

    Not where there are as many as are told already."""
    if len(report.found) >= MOST_TOLD:
        return
    known = names(tables, mechanism)
    found = [_Reading(index, tables, known, models, read).run(report.places, report.file) for index in range(_READINGS)]
    for path, message in found[0]:
        if all((path, message) in other for other in found[1:]):
            report.add(path, message)


class _Reading:
    """One reading of tables with faults; ``index`` says which stand-ins."""

    def __init__(
        self, index: int, tables: Mapping[str, Any], known: Names, models: Mapping[str, type[Table]], read: Read
    ) -> None:
        self.index, self.models, self.read = index, models, read
        self.tables, self.known = tables, known
        self.order: dict[Path, int] = {}
        self.tries: Counter[Path] = Counter()
        self.mended: dict[Path, list[Path]] = {}
        self.changed: dict[Path, None] = {}

    def run(self, wrong: Collection[Path], file: str) -> dict[tuple[Path, str], None]:
        """What is found wrong besides these places."""
        found: dict[tuple[Path, str], None] = {}
        waiting = dict.fromkeys(wrong)
        for _ in range(_ROUNDS):
            waiting = {path: None for path in waiting if self._can_mend(path)}
            mended = [path for path in waiting if self._mend(path)]
            if not mended:
                break
            waiting = {path: None for path in waiting if path not in mended}
            waiting |= dict.fromkeys(self._read_again(file, found, whole=False))
        if self.mended:
            self._read_again(file, found, whole=True)
        return found

    def _read_again(self, file: str, found: dict[tuple[Path, str], None], whole: bool) -> tuple[Path, ...]:
        """Add what is wrong now to what has been found; all places that are."""
        report = Report(file)
        mechanism = self.read(self.tables, report, self.changed, whole)
        self.known = names(self.tables, mechanism)
        found |= dict.fromkeys(fault for fault in report.found if not self._is_told(fault[0]))
        return report.places

    def _can_mend(self, path: Path) -> bool:
        return len(path) > _depth(path) and path[0] in self.models and self.tries[path] < _TRIES

    def _is_told(self, path: Path) -> bool:
        """Whether something in the same value has been told of already."""
        return any(
            path[: len(mended)] == mended[: len(path)] for mended in self.mended.get(path[: _depth(path) + 1], ())
        )

    def _mend(self, path: Path) -> bool:
        """Whether there is something else to read at ``path``; then it stands there."""
        depth, model = _depth(path), self.models[str(path[0])]
        raw = part_of(self.tables, path[:depth])
        owner, place = innermost(model, path[depth:], raw)
        key = str(place[0])
        if kind_of_key(owner, key) is None:
            self._leave_out(path, key, owner)
        else:
            order = self.order.setdefault(path, len(self.order))
            number = self.index + _READINGS * order + (_READINGS + 1) * self.tries[path]
            value = stand_in(model, path[depth:], raw, number, self.known)
            if value is None:
                return False
            self._put(path, value)
        self.tries[path] += 1
        self.mended.setdefault(path[: depth + 1], []).append(path)
        return True

    def _leave_out(self, path: Path, key: str, model: type[Table]) -> None:
        """Take out an unknown key; its value goes to the key that is meant, where one is like it.

        A key that shows that another table is meant stays: nothing else of such a table is judged.
        """
        if key in model.INSTEAD:
            return
        owner: Any = self.tables
        for part in path[:-1]:
            owner = owner[part]
        meant = meant_key(key, owner[key], kinds_of(model), owner, required_keys(model))
        if meant is not None and key not in model.MISPLACED:
            self._put((*path[:-1], meant), owner[key])
        self.tables = _put(self.tables, path, _REMOVED)

    def _put(self, path: Path, value: object) -> None:
        self.tables = _put(self.tables, path, value)
        self.changed[path] = None


def _put(node: Any, path: Path, value: object) -> Any:
    """A copy of tables and lists with another value at ``path``, as far as there is such a place."""
    here, below = path[0], path[1:]
    if isinstance(node, Mapping):
        copy: Any = dict(node)
    elif isinstance(node, list) and isinstance(here, int) and here < len(node):
        copy = list(node)
    else:
        return node
    if below:
        inner = copy[here] if isinstance(node, list) else copy.get(here, {})
        copy[here] = _put(inner, below, value)
    elif value is _REMOVED:
        copy.pop(here, None)
    else:
        copy[here] = value
    return copy


def _depth(path: Path) -> int:
    """How much of a path says which table is meant."""
    return 2 if len(path) > 1 and isinstance(path[1], int) else 1
