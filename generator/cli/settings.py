"""``--set PATH=VALUE``: values of parameters and of the start for one command, in SI units or as scenes write them
(``"2 kg"``)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..effect_base.arithmetic import ExpressionError
from ..effect_base.written_numbers import check_dimension
from .detail import Detail
from .plan_numbers import read_any
from .refusal import Faults, fail, refusing, value_of
from .scene_file import SEEN, read, tell_closing

if TYPE_CHECKING:
    from ccgen.runtime import Model
    from ccgen.runtime.model.parameters import Parameters

    from ..scene import Scene

OF_RUNS = ("until", "rtol", "method", "step")
"""Options of runs that some take for parameters."""
NO_NUMBER = (
    "found a number that is 0 in the scene and so left out of the equations, expected a parameter; write another "
    "number for it in the scene, which may be small"
)


def read_settings(given: Sequence[str], faults: Faults) -> dict[str, float]:
    """Values by the paths of parameters, of the options that say one; what is wrong with the others is noted."""
    found = dict[str, float]()
    for text in given:
        path, sign, number = (part.strip() for part in text.partition("="))
        expected = (
            'expected PATH=NUMBER in SI units, or with a unit in quotes, such as crank.mass=2 or crank.mass="2 kg"'
        )
        if not sign or not path or not number:
            faults.add(f'--set: found "{text}", {expected}')
        elif path in found:
            faults.add(f"--set {path}: found twice, expected once; leave one out")
        else:
            try:
                found[path] = _number(number)
            except ExpressionError as error:
                faults.add(f'--set: found "{text}", {expected}; {error}')
    return found


def _number(text: str) -> float:
    """A number as a shell hands it over, or as it stands in a scene, in quotes."""
    if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'":
        text = text[1:-1]
    plain = value_of(text)
    return plain if isinstance(plain, float) else read_any(text)


def read_set(path: Path, settings: Mapping[str, float], faults: Faults, *, fold: bool = False) -> Scene | None:
    """The scene in a file, names of its ``[let]`` having the values that ``settings`` give them. What is wrong with it,
    or with the other settings, is noted, before anything is compiled."""
    scene = faults.of(read, path, settings)
    if scene:
        faults.of(_check_settings, settings, scene, fold, all_read=not faults.about("--set"))
    return scene


def _check_settings(settings: Mapping[str, float], scene: Scene, fold: bool, *, all_read: bool) -> None:
    """Stop with exit code 2 where models of a scene have no such parameters, they cannot have these values, or, if they
    are ``all_read``, there is no start with them."""
    settings = _besides_let(settings, scene)
    if not settings:
        return
    faults, numbers, begins = Faults(), dict[str, float](), _of_start(scene)
    for path, value in settings.items():
        if wrong := _wrong_unit(path, value, scene):
            faults.add(wrong)
        elif path not in begins:
            numbers[path] = value
    faults.of(_check_numbers, numbers, parameters_of(scene, fold), scene)
    faults.stop_if_any()
    if all_read:
        scene_with(settings, scene)


def _check_numbers(numbers: Mapping[str, float], parameters: Parameters, scene: Scene) -> None:
    """Stop with exit code 2 where there are no such parameters, or they cannot be these."""
    try:
        parameters.update({path: float(value) for path, value in numbers.items()})
    except (KeyError, ValueError) as error:
        told = {f"{path}: ": _meant(path, value, scene) for path, value in numbers.items()}
        lines = (
            next((path + said for path, said in told.items() if said and line.startswith(path)), line)
            for line in str(error).splitlines()
        )
        fail("\n".join(f"--set {line}" for line in lines))


def parameters_of(scene: Scene, fold: bool = False) -> Parameters:
    """The parameters of models of a scene, which are known before there is one."""
    from ccgen.runtime.model.parameters import Parameters

    from ..mechanism.implied import implied
    from ..package.parameter_data import data_over_time, laws_of_loads, parameter_data, resting_data

    declared = parameter_data(scene.parameters())
    resting = resting_data(scene.mechanism, implied(scene.mechanism, scene.driven))
    folded = scene.name if fold and declared else ""
    gates = [gate.path for gate in scene.gates if gate]
    loads = laws_of_loads(scene.effects)
    return Parameters(declared, {}, lambda: None, folded, resting, data_over_time(scene.effects), gates, loads)


def check_parameter(path: str, scene: Scene, option: str) -> None:
    """Stop with exit code 2 where models of a scene have no parameter that an option names."""
    try:
        parameters_of(scene)[path]
    except KeyError as error:
        said = _no_parameter(path, scene)
        fail(f"{option}: {path}: {said}" if said else f"{option}: {error}")


def _no_parameter(path: str, scene: Scene) -> str:
    """What is named in place of a parameter, where it is known; its value is not asked for."""
    if path in OF_RUNS:
        return "found a setting of runs, expected a parameter; name one"
    if path.startswith("start."):
        return "found a value of the start, expected a parameter; name one"
    return NO_NUMBER if path in _zeros(scene) else ""


def with_settings(model: Model, settings: Mapping[str, float], scene: Scene, detail: Detail = Detail.USUAL) -> Model:
    """The model of a scene with these values, which :func:`read_set` has looked at, and which starts where the scene
    does with them; exit code 2 where its equations have no finite constants then.

    What was worked out from a value that is another now, and stays, is told on standard error."""
    settings = _besides_let(settings, scene)
    if not settings:
        return model
    begins = _of_start(scene)
    with refusing(ValueError):
        changed = model.with_parameters({path: float(x) for path, x in settings.items() if path not in begins})
    for remark in _angles(settings, scene):
        typer.echo(remark, err=True)
    if detail is not Detail.NOTHING:
        for remark in _stays(model, settings, scene):
            typer.echo(f"{scene.name}: {remark}", err=True)
    meant = scene_with(settings, scene)
    if detail is not Detail.NOTHING and _moved(scene, meant):
        tell_closing(meant, detail, "with these values ")
    before, settled = _values(scene), _values(meant)
    follow = {path: value for path, value in settled.items() if path not in settings and value != before[path]}
    with refusing(ValueError):
        return changed.with_parameters(follow).with_start(meant.start.poses, meant.start.velocities)


def _besides_let(settings: Mapping[str, float], scene: Scene) -> Mapping[str, float]:
    """The settings that are of no name of ``[let]``, with which the scene has been read already."""
    if all("." in path for path in settings):
        return settings
    names = scene.to_dict().get("let", {})
    return {path: value for path, value in settings.items() if path not in names}


def _meant(path: str, value: float, scene: Scene) -> str:
    """What is wrong with a path that is no parameter, where it is known: an option of runs, or a number that the
    equations are without because it is 0 in the scene."""
    if path in OF_RUNS:
        return f"found a setting of runs, expected a parameter; write --{path} {getattr(value, 'text', f'{value:g}')}"
    if path.startswith("start."):
        given = ", ".join(_of_start(scene)) or "none"
        return f"found a value that [start] does not give, expected one that it gives: {given}; write it in the scene"
    return f"{NO_NUMBER}, and set that" if path in _zeros(scene) else ""


def _of_start(scene: Scene) -> Mapping[str, str]:
    """What may be set of a start, and what that measures."""
    from ..scene.with_values import start_values

    return start_values(scene)


def _units_of(scene: Scene, path: str) -> tuple[str, ...]:
    """The units one of which a parameter, or a value of the start, has; none where there is no such."""
    from ..scene.measures import units_of

    unit = _of_start(scene).get(path) if path.startswith("start.") else None
    return units_of(scene, path) if unit is None else (unit,)


def _zeros(scene: Scene) -> set[str]:
    """The paths that numbers of links would have which are 0 in the scene, and so are no parameters."""
    from ..mechanism.links import Point

    mechanism, found = scene.mechanism, set[str]()

    def note(path: str, point: Point) -> None:
        found.update(f"{path}.{axis}" for axis in "xy" if getattr(point, axis) is None)

    for link in mechanism.links:
        note(f"{link.name}.com", link.com)
        for name, point in link.points.items():
            note(f"{link.name}.points.{name}", point)
        found.update(f"{link.name}.{key}" for key in ("mass", "inertia") if getattr(link, key) is None)
    for name, point in mechanism.ground_points.items():
        note(f"ground.points.{name}", point)
    return found


def _angles(settings: Mapping[str, float], scene: Scene) -> list[str]:
    """Angles without a unit of which degrees may be meant."""
    from ..scene.angles import taken_as_rad

    found = {path: getattr(value, "text", value) for path, value in settings.items()}
    angles = [path for path in settings if _units_of(scene, path) == ("rad",) and math.isfinite(settings[path])]
    told = ((path, taken_as_rad(settings[path], found[path])) for path in angles)
    return [f"--set {path}: {remark}" for path, remark in told if remark]


def scene_with(settings: Mapping[str, float], scene: Scene) -> Scene:
    """The scene with these values, assembled anew; exit code 2, and what is wrong, where it has no start with them."""
    from ..scene.errors import SceneError
    from ..scene.with_values import with_values

    settings = _besides_let(settings, scene)
    try:
        return with_values(scene, {path: float(value) for path, value in settings.items()})
    except SceneError as error:
        fail("\n".join(f"--set: with these values {line}" for line in str(error).splitlines()))


def _moved(one: Scene, other: Scene) -> bool:
    """Whether the starts of two scenes are differently far from what was asked for."""
    off = [(start.assembled_by, start.slid_by, start.missed_by) for start in (one.start, other.start)]
    return any(abs(a - b) > SEEN for a, b in zip(*off, strict=True))


def _values(scene: Scene) -> dict[str, float]:
    """Of all parameters, by their paths."""
    return {one.path: one.value for one in scene.parameters()}


def _wrong_unit(path: str, value: float, scene: Scene) -> str:
    """That a value measures something else than its parameter, if it does."""
    units = _units_of(scene, path)
    try:
        if units:
            check_dimension(value, units)
    except ExpressionError as error:
        return f'--set {path}: found "{getattr(value, "text", value)}", expected {" or ".join(units)}; {error}'
    return ""


def _stays(model: Model, settings: Mapping[str, float], scene: Scene) -> list[str]:
    """What the scene works out of masses and lengths is worked out once, so that other ones leave it as it is."""
    told = []
    for name in scene.worked_out:
        mass, inertia = f"{name}.mass", f"{name}.inertia"
        own = [path for path in settings if path.startswith((f"{name}.points.", f"{name}.com."))]
        if inertia in settings or inertia not in model.parameters:
            continue
        value = model.parameters[inertia]
        if mass in settings:
            grown = value * settings[mass] / model.parameters[mass]
            told.append(
                f"{mass} is set, {inertia} stays {value:.6g} kg m², which was worked out for "
                f"{model.parameters[mass]:.6g} kg; --set {inertia}={grown:.6g} lets it grow with the mass"
            )
        elif own:
            what = (
                f"{', '.join(own)} is set, {inertia} stays {value:.6g} kg m², as all that was worked out from lengths"
            )
            told.append(f"{what}; set it too, or change the scene")
    return told
