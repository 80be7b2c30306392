"""``ccgen orbit SCENE``: a periodic motion, its multipliers, and its branch along a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from ..scene.measures import units_of
from .compiled import compiled
from .detail import Detail
from .folders import MODELS, check_folder, check_results, record_results
from .orbit_words import guess_of, read_along, read_pairs, read_section, relabel_of
from .progress import progress
from .refusal import Faults, fail, read_option, refusing
from .settings import check_parameter, read_set, with_settings
from .sweep import read_count, told_of

if TYPE_CHECKING:
    from ccgen.runtime import Branch, Model, Orbit

TABLE, PICTURE = "branch.csv", "branch.png"
"""Files of a branch."""


@dataclass(frozen=True)
class Wanted:
    """What the options of ``ccgen orbit`` say, as they were given."""

    section: str
    guess: Sequence[str]
    relabel: Sequence[str]
    advances: str | None
    crossings: str | None
    until: str | None
    rtol: str | None
    method: str | None
    segments: str | None
    most: str | None
    along: str | None
    double: bool
    settled: str | None
    show: str | None
    out: Path | None


def orbit(scene_file: Path, wanted: Wanted, detail: Detail, settings: Mapping[str, float], faults: Faults) -> None:
    """Find a periodic motion and print it; follow it and write its table and picture where ``--along`` asks for it."""
    section = faults.of(read_section, wanted.section)
    guess = faults.of(read_pairs, wanted.guess, "--guess")
    relabel = faults.of(read_pairs, wanted.relabel, "--relabel")
    crossings = faults.of(read_count, wanted.crossings, "--crossings")
    segments = faults.of(read_count, wanted.segments, "--segments")
    most = faults.of(read_count, wanted.most, "--most")
    settled = faults.of(read_count, wanted.settled, "--settled")
    until, rtol = (
        faults.of(read_option, text, check, unit)
        for text, check, unit in ((wanted.until, _check("until"), "s"), (wanted.rtol, _check("rtol"), ""))
    )
    if wanted.along is None:
        others = {"--double": wanted.double, "--settled": wanted.settled, "--show": wanted.show, "--out": wanted.out}
        for option, given in others.items():
            if given:
                faults.add(f"{option}: found without --along, expected with it only; add --along PARAM=LOW:HIGH")
    scene = read_set(scene_file, settings, faults)
    along = faults.of(read_along, wanted.along, scene) if wanted.along else None
    if scene and along:
        faults.of(check_parameter, along[0], scene, "--along")
    folder = wanted.out
    if scene and along:
        folder = Path("results") / f"{scene.name}-orbit" if folder is None else folder
        faults.of(check_results, folder, [TABLE, PICTURE], "--out" if wanted.out else "results")
    faults.of(check_folder, MODELS, "folder of models")
    faults.stop_if_any()
    assert scene and section is not None and guess is not None and relabel is not None
    model = with_settings(compiled(scene, detail, derivatives=True), settings, scene, detail)
    q, u = guess_of(model, guess)
    options: dict[str, Any] = {
        "section": section,
        "crossings": crossings or 1,
        "until": until,
        "relabel": relabel_of(model, relabel),
        "advances": [name.strip() for name in (wanted.advances or "").split(",") if name.strip()],
        "rtol": rtol,
        "method": wanted.method,
        "segments": segments or 1,
        **({} if most is None else {"most": most}),
    }
    from ccgen.runtime import find_orbit

    with refusing(ValueError):
        found = find_orbit(model, q, u, **options)
    if detail is not Detail.NOTHING:
        _tell(model, found)
    if along is not None:
        assert folder
        _follow(found, along, units_of(scene, along[0]), wanted, settled, folder, detail)


def _check(option: str) -> Any:
    def check(value: object) -> None:
        if not isinstance(value, float) or not 0.0 < value < np.inf:
            raise ValueError(f"{option}: found {value!r}, expected a number above 0")

    return check


def _tell(model: Model, found: Orbit) -> None:
    """Period, stability and multipliers, then the state on the section."""
    from ccgen.runtime.orbits.values import names_of, unit_of

    stable = "stable" if found.stable else "neutral" if found.neutral else "unstable"
    if found.at_rest:
        typer.echo(
            f"{model.name}: {stable} equilibrium, at which nothing moves, compared after {found.period:.9g} s; give a "
            "--guess that moves for a periodic motion"
        )
    else:
        typer.echo(f"{model.name}: {stable} periodic motion; period {found.period:.9g} s")
    typer.echo(f"comes back to {found.missed:.2g} of its size; {found.runs} runs derived")
    typer.echo("multiplier           size")
    for one in found.multipliers:
        number = f"{one.real:z.9g}" + (f" {'+' if one.imag > 0 else '-'} {abs(one.imag):.9g}i" if one.imag else "")
        typer.echo(f"{number:30} {abs(one):.9g}")
    names = names_of(model)
    width = max(12, *map(len, names))
    for name, value in zip(names, np.concatenate([found.q, found.u]), strict=True):
        typer.echo(f"{name:{width}} {value:z16.9g} {unit_of(name)}")


def _follow(
    found: Orbit,
    along: tuple[str, float, float],
    units: Sequence[str],
    wanted: Wanted,
    settled: int | None,
    folder: Path,
    detail: Detail,
) -> None:
    """The branch of a motion along a parameter that has one of the ``units``, with those of twice the period where
    asked, printed and written."""
    from ccgen.runtime import continue_orbit, double_period
    from ccgen.runtime.orbits.branch_table import write_branches
    from ccgen.runtime.orbits.diagram import draw_branches
    from ccgen.runtime.orbits.settled import settled as settle
    from ccgen.runtime.orbits.values import names_of, varied_most

    parameter, low, high = along
    model = found.return_map.model
    if wanted.show is not None and wanted.show not in names_of(model):
        fail(f"--show: found {wanted.show}, expected one of {', '.join(names_of(model))}")
    with refusing(ValueError, OSError, ImportError), progress(detail) as tell:
        tell.stage("follow")
        branches = [continue_orbit(found, parameter, (low, high))]
        ends = [branches[0].ends]
        for flip in [one for one in branches[0].bifurcations if one.kind == "flip" and wanted.double]:
            doubled = double_period(flip)
            upwards = doubled.return_map.model.parameters[parameter] > flip.value
            branches.append(continue_orbit(doubled, parameter, (low, high), way="up" if upwards else "down"))
            lower, upper = branches[-1].ends
            begins = f"at the flip at {flip.value:.12g}, where it begins"
            ends.append((begins, upper) if upwards else (lower, begins))
        if detail is not Detail.NOTHING:
            for branch, both in zip(branches, ends, strict=True):
                _tell_branch(branch, both)
        name = wanted.show or varied_most(branches[0].orbits)
        dots = None
        if settled is not None:
            tell.stage("simulate")
            dots = settle(found, parameter, np.linspace(low, high, settled), name, progress=told_of(tell))
        folder.mkdir(parents=True, exist_ok=True)
        write_branches(branches, folder / TABLE)
        # one that may be in several units, or in none that is known, is said to be in SI units
        unit = None if len(units) != 1 else "" if units[0] == "1" else units[0]
        draw_branches(branches, folder / PICTURE, name=name, settled=dots, unit=unit)
        record_results(folder, [TABLE, PICTURE])
    typer.echo(f"written: {folder / TABLE}, {folder / PICTURE}")


def _tell_branch(branch: Branch, ends: tuple[str, str]) -> None:
    low, high = float(branch.values.min()), float(branch.values.max())
    period = branch.orbits[0].return_map.crossings * branch.orbits[0].return_map.times
    typer.echo(
        f"{branch.parameter} from {low:.9g} to {high:.9g}: {len(branch.values)} motions of {period} crossing"
        f"{'s' if period > 1 else ''}, {int(branch.stable.sum())} of them stable"
    )
    for one in branch.bifurcations:
        contact = "" if one.contact is None else " of {} on {}".format(*one.contact)
        typer.echo(f"  {one.kind}{contact} at {one.value:.12g}")
    for end in ends:
        typer.echo(f"  end: {end}")
