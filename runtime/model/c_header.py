"""A model's values and start as a header, for programs in C that simulate it without Python."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from .geometry import Geometry
from .kinks import kinks_until
from .start import start
from .time_scales import ends_of_pieces

WIDTH = 6
"""Numbers in a line."""

TEXT = """/* {name}: values and start, for programs that include ccgen.h. Written by ccgen from its model. */
#ifndef {guard}
#define {guard}

#include "ccgen.h"

extern const struct ccgen_model ccgen_model_{package};

/* links: {links}
 * contacts: {contacts}
 * events by their numbers: {events}
 * q: {q_names}
 * u: {u_names} */
enum {{ {package}_n = {n}, {package}_contacts = {count} }};
static const double {package}_q[] = {{
{q}
}};
static const double {package}_u[] = {{
{u}
}};
static const double {package}_parameters[] = {{
{parameters}
}};
static const double {package}_stops[] = {{
{stops}
}};
static const unsigned char {package}_lengths[] = {{ {lengths} }};
static const unsigned char {package}_angular[] = {{ {angular} }};
static const struct ccgen_settings {package}_settings = {{
    .parameters = {package}_parameters,
    .length = {length},
    .time = {time},
    .duration = {duration},
    .lengths = {package}_lengths,
    .angular = {package}_angular,
    .law = "{law}",
    .acceleration_scale = {scale},
    .rtol = {rtol},
    .atol = {atol},
    .stops = {package}_stops,
    .stop_count = {stop_count},
}};

#endif
"""


def c_header(model: Geometry) -> str:
    """The header's text: parameters, start, and settings of a simulation as the model has them now.

    Raises ``ValueError`` for a model in other numbers than doubles, and for one that lies in no folder.
    """
    if model.precision != "double" or model.folder is None:
        raise ValueError(
            f"{model.name}: found a model in {model.precision} numbers, expected one in doubles, in a folder"
        )
    q, u = start(model)
    package = package_in_code(model.folder)
    until = model.data["run"]["until"]
    kinks = kinks_until(model, until)
    instants = sorted({*kinks, *ends_of_pieces(model, kinks, until)})
    kernels = model.kernels
    stops = [int(ground in model.stops) for _, ground in model.contacts]
    return TEXT.format(
        name=model.name,
        package=package,
        guard=f"CCGEN_{package.upper()}_H",
        links=", ".join(model.links),
        contacts=", ".join(f"{point} on {ground}" for point, ground in model.contacts) or "none",
        q_names=", ".join(model.q_names),
        u_names=", ".join(model.u_names),
        n=len(model.q_names),
        count=len(model.contacts),
        events=_events(model),
        q=_numbers(q),
        u=_numbers(u),
        parameters=_lines([f"{value!r}, /* {path} */" for path, value in model.settable.items()] or ["0"], 1),
        angular=", ".join(map(str, stops or [0])),
        length=repr(model.length),
        time=repr(model.time or 0.0),
        duration=repr(float(model.data["run"]["until"])),
        lengths=", ".join(str(int(kind != "angle")) for kind, _ in model.data["coordinates"]),
        law=model.data["law"],
        scale=repr(model.usual if kernels.refined else 0.0),
        rtol=repr(model.data["run"]["rtol"]),
        atol=repr(model.data["run"]["atol"] or 0.0),
        stops=_numbers(instants or [0.0]),
        stop_count=len(instants),
    )


def check_beside(target: Path, package: Path | None) -> None:
    """Raise ``ValueError`` for a place in a model's package, which is for ccgen's own files alone."""
    if package is not None and package in (target.resolve(), *target.resolve().parents):
        raise ValueError(
            f"{target}: found a place in the model's package, which ccgen would refuse to generate again with it, "
            f"expected one elsewhere; write it beside the package, as {package.name}{target.suffix}"
        )


def package_in_code(folder: Path) -> str:
    """The package's name in the code of the model, whatever its folder is called now."""
    source = (folder / "model.c").read_text()
    found = re.search(r"^const struct ccgen_model CCGEN_CALLED\(ccgen_model, (\w+)\) = ", source, re.M)
    if found is None:
        raise ValueError(f"{folder / 'model.c'}: found no descriptor of a model; generate the model again")
    return found[1]


def _events(model: Geometry) -> str:
    """Names of the events, and behind them what joints let go and take hold, by their numbers."""
    names = [event["name"] for event in model.data.get("events", ())]
    for change in (model.data.get("switching") or {}).get("changes", ()):
        names.append(f"{change['joint']} {'lets go' if change['kind'] == 'release' else 'takes hold'}")
    return ", ".join(f"{number} {name}" for number, name in enumerate(names)) or "none"


def _numbers(values: Iterable[float]) -> str:
    return _lines([f"{float(value)!r}," for value in values], WIDTH)


def _lines(texts: list[str], width: int) -> str:
    return "\n".join("    " + " ".join(texts[i : i + width]) for i in range(0, len(texts), width))
