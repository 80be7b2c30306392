"""Scenes from where users have them: a TOML file, a dict, or a shorthand in a program or on the command line."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from difflib import get_close_matches
from os import PathLike
from pathlib import Path as File
from typing import Any, NamedTuple

from .errors import Fault, Path, SceneError
from .limits import MOST_BYTES, too_large
from .locate import locate
from .near_files import as_there
from .not_toml import not_toml
from .read import Tables, read_tables
from .scene import Scene
from .toml_text import plain

Gravity = bool | float | Tables


def load_scene(path: str | PathLike[str] | Tables, *, let: Mapping[str, float] | None = None) -> Scene:
    """The scene in the TOML file ``path``, or of the tables that such a file would give, as nested dicts and lists.

    Tuples and arrays of NumPy may stand for lists, and a key with the value ``None`` is left out. The scene of tables
    without a ``name`` is called ``scene``. ``let`` are numbers (SI units) for names of its ``[let]``, in place of those
    that stand there. Raises ``SceneError`` with everything that is wrong with it, ``ValueError`` where ``let`` has a
    name that the scene's ``[let]`` has not, and ``TypeError`` where ``path`` or ``let`` is neither.
    """
    if let is not None and not isinstance(let, Mapping):
        raise TypeError(f'let: found {let!r}, expected numbers by names of [let] as a dict, as {{"length": 0.7}}')
    found = _found(path)
    return _read(found, plain(let or {}))


def load_with_settings(path: str | PathLike[str], settings: Mapping[str, float]) -> Scene:
    """The same of a file, with those of ``settings`` that are of names of its ``[let]``; others are of parameters.

    What has a unit is read as it was written, so that it is told where it does not measure what the scene takes it for.
    """
    found = _found(path)
    names = found.tables.get("let")
    known = names if isinstance(names, Mapping) else {}
    return _read(found, {name: getattr(value, "text", value) for name, value in settings.items() if name in known})


class _Found(NamedTuple):
    """Tables as they were given, the file and the name that faults and the scene have, and where keys stand."""

    tables: Tables
    file: str
    name: str
    lines: Mapping[Path, int] | None = None


def _found(path: str | PathLike[str] | Tables) -> _Found:
    if isinstance(path, Mapping):
        name = path.get("name")
        return _Found(plain(path), name if isinstance(name, str) else "scene", "scene")
    if not isinstance(path, str | PathLike):
        raise TypeError(f"path: found {path!r}, expected the name of a scene file (TOML), or its tables as a dict")
    file = str(path)
    try:
        content = _content(File(path))
        if content is None:
            message = (
                f"found more than {MOST_BYTES} bytes, expected a scene file (TOML) of at most that; name another file"
            )
            raise _unreadable(file, None, message)
        text = content.decode("utf-8-sig")
        if large := too_large(text):
            raise _unreadable(file, *large)
        tables = tomllib.loads(text)
    except FileNotFoundError as error:
        there = f"a scene file (TOML){as_there(path, '.toml')}"
        raise _unreadable(file, None, f"{error.strerror}; expected {there}; correct the name") from error
    except OSError as error:
        raise _unreadable(file, None, f"{error.strerror}; expected a scene file (TOML)") from error
    except UnicodeDecodeError as error:
        raise _unreadable(file, None, "found bytes that are not UTF-8, expected a text file (TOML)") from error
    except tomllib.TOMLDecodeError as error:
        faults, all_found = not_toml(text, file, error)
        raise SceneError(faults, all_found=all_found) from error
    return _Found(tables, file, File(path).stem, locate(text))


def _read(found: _Found, let: Mapping[str, float]) -> Scene:
    """The scene of the tables, with other values of names of ``[let]``."""
    given = found.tables.get("let", {})
    if not let or not isinstance(given, Mapping):
        return read_tables(*found)
    if unknown := [name for name in let if name not in given]:
        known = (
            f"names of [let] in {found.file}: {', '.join(given)}" if given else f"none, for {found.file} has no [let]"
        )
        close = get_close_matches(unknown[0], given, 1)
        advice = f'write "{close[0]}"' if close else "leave it out"
        raise ValueError(f"let: found {', '.join(map(repr, unknown))}, expected {known}; {advice}")
    return read_tables({**found.tables, "let": {**given, **let}}, *found[1:])


def _content(file: File) -> bytes | None:
    """What a file holds, or ``None`` of one that is larger than a scene may be: it may have no end, as a device."""
    with file.open("rb") as opened:
        content = opened.read(MOST_BYTES + 1)
    return content if len(content) <= MOST_BYTES else None


def loop(links: int, gravity: Gravity = False, **tables: Any) -> Scene:
    """A floating loop of equal rods, 1 m and 1 kg each, as a regular polygon.

    ``gravity`` is ``True`` for g = 9.81 m/s², or g, or the table of a scene file.

    ``tables`` are those of a scene file, as in ``loop(6, start={"tilt": "10 deg"}, loop={"length": 0.7})``.
    Raises ``SceneError`` as for a file.
    """
    return _standard("loop", {"links": links}, f"loop{links}", gravity, tables)


def chain(links: int, hinged: bool = False, gravity: Gravity = False, **tables: Any) -> Scene:
    """An open chain of equal rods along the x axis, free or with its first end on the ground; otherwise as ``loop``."""
    own = {"links": links, "hinged": hinged}
    return _standard("chain", own, f"{'hinged' if hinged else 'chain'}{links}", gravity, tables)


def pinned(links: int, gravity: Gravity = False, **tables: Any) -> Scene:
    """A chain of equal rods with both ends on the ground, hanging as a regular polygon; otherwise as ``loop``."""
    return _standard("pinned", {"links": links}, f"pinned{links}", gravity, tables)


def _standard(form: str, own: dict[str, Any], name: str, gravity: Gravity, tables: dict[str, Any]) -> Scene:
    document: dict[str, Any] = {**tables, form: {**own, **tables.get(form, {})}}
    if gravity is not False:
        document["gravity"] = {} if gravity is True else gravity if isinstance(gravity, Mapping) else {"g": gravity}
    return read_tables(plain(document), name, name)


def _unreadable(file: str, line: int | None, message: str) -> SceneError:
    return SceneError((Fault(file, line, "", message),))
