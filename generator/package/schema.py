"""The schema of a package's ``model.json``: every key, its type, shape, unit and domain, and what it means.

This is where the data is described. ``runtime/loading/model.schema.json``, by which the runtime checks what it loads,
and the table in docs/model.md are written from here by ``docs/scripts/model_schema.py``.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from ..effect_base.contact import Law, OnGain

Coordinate = str | float
"""A number that is a parameter, by its path, or that is structurally zero."""

Place = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
Index = Annotated[int, Field(ge=-1)]
Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
Positive = Annotated[float, Field(gt=0.0)]


def entry(meaning: str, shape: str = "", unit: str = "", default: Any = ...) -> Any:
    """A key: what it means, the shape of an array by the sizes of ``model.h``, and the unit of its numbers. One that
    has a ``default`` is left out of the data where it is that."""
    said: dict[str, Any] = {key: value for key, value in (("shape", shape), ("unit", unit)) if value}
    return Field(default, description=meaning, json_schema_extra=said)


class Data(BaseModel):
    """A table of the data: all of its keys are there but those that have a default, and no other."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class DomainData(Data):
    """What a parameter may be; ``null`` where there is no bound."""

    minimum: float | None = entry("the least value", unit="as the value")
    above: float | None = entry("what the value must be larger than", unit="as the value")
    maximum: float | None = entry("the largest value", unit="as the value")
    whole: bool = Field(default=False, description="whether it is a whole number; left out where not")


class ParameterData(Data):
    """A number of the mechanism that stays symbolic."""

    path: str = entry('its name in the scene, as "link_0.mass"')
    value: float = entry("its value when the model is loaded", unit="SI")
    domain: DomainData = entry("what it may be set to, as the effect that declares it says")


class OfStateData(Data):
    """A law, or something of a load, that is an expression of time and state."""

    name: str = entry("the law's name, or what the load's number would be called as a parameter")
    text: str = entry("the expression, as a person reads it")
    load: bool = entry("whether it is of a load")
    laws: list[str] = entry("the laws that it names itself")
    asks: list[str] = entry("what it asks of the state itself, as angle(hip) and rate(slide(rail))")
    outputs: list[str] = entry("the outputs that tell it, or what the load comes to by it")


class LineData(Data):
    """The line of a joint that slides."""

    links: Annotated[list[Index], Field(min_length=2, max_length=2)] = entry("the two links that it joins", "[2]")
    points: Annotated[list[Place], Field(min_length=2, max_length=2)] = entry(
        "a point of each link, in its frame", "[2][2]", "m"
    )
    axis: Coordinate = entry("the angle of the line in the first link's frame", unit="rad")
    angle: Coordinate | None = entry("the angle of the second link against the first; null where it turns", unit="rad")


class DriveData(Data):
    """A joint whose motion is prescribed."""

    joint: str = entry("the joint's name")
    position: float | None = entry("where it is at t = 0; null where that is open", unit="rad or m")
    speed: Coordinate = entry("its speed at t = 0", unit="rad/s or m/s")
    slides: bool = entry("whether it slides along a line")


class IntegratorData(Data):
    """An integral over time that an effect asks for: the rate of a link that no scene has."""

    name: str = entry("its name")
    link: Index = entry("that link")
    joint: str = entry("the joint on which it hangs")


class PlaneData(Data):
    """A half-plane that can be touched."""

    name: str = entry("the ground's name")
    point: Place = entry("a point of its surface", "[2]", "m")
    normal: Place = entry("the direction out of it, of any length but zero", "[2]")
    on: list[str] = Field(
        default=[], description="gates of which one is 1 where it is there; left out where it always is"
    )


class DiscData(Data):
    """A disc or an edge by which a link touches."""

    link: Index = entry("its link; -1: the ground")
    point: Place = entry("its centre, or one end, in the link's frame", "[2]", "m")
    end: Place | None = entry("the other end of an edge; null for a disc", "[2]", "m")
    radius: Coordinate | list[str] = entry("its radius, or half of an edge's thickness; of a list the sum", unit="m")
    around: list[tuple[float, float]] = Field(
        default=[], description="of a profile, its corners about the centre; left out where it is a disc or an edge"
    )
    on: list[str] = Field(
        default=[], description="gates of which one is 1 where it is there; left out where it always is"
    )


class RopeData(Data):
    """A rope."""

    name: str = entry("its name")
    links: Annotated[list[Index], Field(min_length=2)] = entry(
        "the links of its points, in order; -1: the ground", "[...]"
    )
    points: Annotated[list[Place], Field(min_length=2)] = entry("where these are in the links' frames", "[...][2]", "m")
    on: list[str] = Field(
        default=[], description="gates of which one is 1 where it is there; left out where it always is"
    )


PartKind = Literal[
    "spring",
    "damper",
    "torsion",
    "motor",
    "linear motor",
    "brake",
    "linear brake",
    "force",
    "torque",
    "stop",
    "linear stop",
    "gear",
    "rack",
    "belt",
]


class PartData(Data):
    """What is drawn where an effect acts."""

    kind: PartKind = entry("what it is")
    name: str = entry("the effect's name; of a stop with two limits twice")
    links: Annotated[list[Index], Field(min_length=2, max_length=3)] = entry(
        "the links of its points: both ends, both wheels, of a belt the carrier; of a rack pinion, bar and the link "
        "of the line; of a force or a torque its link twice; -1: the ground",
        "[...]",
    )
    points: Annotated[list[Place], Field(min_length=2, max_length=3)] = entry(
        "where these are in the links' frames", "[...][2]", "m"
    )
    numbers: list[Coordinate] = entry(
        "of a linear motor or brake the angle of the line in the first link, of a stop the joint's angle, where it "
        "slides the length, the line's angle and the sign of what is beyond, of gears and "
        "belts the radii, of a belt 1 where it is crossed, of a rack radius, the line's angle and -1 where it is "
        "reversed, of a force x and y (1 or 0 where it changes with time), then 1 where it does, then 1 where its axes "
        "turn with the link, of a torque its value, 1 where that changes with time",
        unit="m, rad, N, N m",
    )
    on: list[str] = Field(
        default=[], description="gates of which one is 1 where it is there; left out where it always is"
    )


class StartData(Data):
    """Where a run begins."""

    poses: list[Triple] = entry("x, y and angle of each link's frame", "[links][3]", "m, rad")
    velocities: list[Triple] = entry("their rates", "[links][3]", "m/s, rad/s")
    kept_places: list[int] = entry(
        "coordinates that stay as they are where loops are closed with other values of parameters", default=[]
    )
    kept_rates: list[int] = entry("coordinates whose rates stay so", default=[])
    kept_drives: list[int] = entry("drives, by number, whose joints stay where they are then", default=[])
    sketch: list[float] = entry(
        "what the start is the nearest to with other values of parameters, by weighted squares of changes of "
        "coordinates; empty: to itself, by the same squares",
        "[coordinates]",
        "rad, m",
        default=[],
    )
    weights: list[float] = entry(
        "of the squares of these changes, and of those of rates", "[coordinates]", "1, 1/m²", default=[]
    )
    smallest_rates: bool = entry(
        "whether rates that are not kept are the smallest with other values of parameters; else they change least",
        default=True,
    )


class RunData(Data):
    """How a run goes unless told otherwise."""

    until: Positive = entry("when it ends", unit="s")
    rtol: Positive = entry("the relative tolerance of a step")
    atol: Positive | None = entry("the absolute tolerance of a step; null: as the relative one")
    on_gain: OnGain = entry("what becomes of an impact that would gain energy: less restitution, or the run stops")


class EndsData(Data):
    """A joint that lets go or takes hold."""

    gate: str = entry("the parameter that is 1 while it holds and 0 while it is open")
    latches: list[str] = entry("names of the values that effects at it hold", default=[])
    kind: Literal["revolute", "prismatic", "pin-in-slot", "weld"] = entry("what it is")
    links: Annotated[list[Index], Field(min_length=2, max_length=2)] = entry("the two links; -1: the ground", "[2]")
    points: Annotated[list[Place], Field(min_length=2, max_length=2)] = entry(
        "the point of each, in its frame", "[2][2]", "m"
    )
    names: Annotated[list[str], Field(min_length=2, max_length=2)] = entry("the two points' names", "[2]")
    axis: float = entry("the angle of its line in the first link's frame", unit="rad")
    angle: float = entry("the angle of the second link against the first that it holds", unit="rad")


class WatchData(Data):
    """What is watched for a joint to let go or take hold."""

    kind: Literal["angle", "direction", "slide", "height", "distance"] = entry("the quantity")
    names: list[str] = entry("of which joint, link or points", "[...]")
    sign: int = entry("1: it rises through the limit; -1: it falls")
    limit: float = entry("the limit", unit="rad or m")


class ChangeData(Data):
    """When a joint lets go or takes hold."""

    kind: Literal["release", "hold"] = entry("which of the two")
    joint: str = entry("the joint")
    at: float | None = entry("at this time", unit="s")
    watch: WatchData | None = entry("where something passes a limit")
    force: float | None = entry("at this force in it", unit="N")
    impulse: float | None = entry("at this impulse in it", unit="N s")
    within: float | None = entry("how far its points may be apart; null: a millionth of the length", unit="m")


class SwitchingData(Data):
    """Joints that let go and take hold."""

    ends: dict[str, EndsData] = entry("the joints that change, by name")
    changes: list[ChangeData] = entry("when they do")


class EventData(Data):
    """Instants of a run that the scene asks for."""

    name: str = entry("its name")
    when: str = entry(
        "what comes to zero there: an expression of t, and of joints, links and points by name", unit="SI"
    )
    direction: Literal["rising", "falling", "either"] = entry("in which direction")
    stop: int = entry("the number of times after which the run ends; 0: it goes on")
    set: dict[str, float | str] = entry("values of parameters from then on, numbers or expressions", unit="SI")
    on: list[str] = entry("effects that act from then on")
    off: list[str] = entry("effects that do not")


class WhilesData(Data):
    """A contact that is there while one of ``whiles`` is so: parameters, each with whether it is 1 or 0 then."""

    contact: int = entry("its number")
    whiles: list[dict[str, bool]] = entry("the parameters, by their paths")


class GateData(Data):
    """An effect that events switch on and off."""

    effect: str = entry("its name")
    parameter: str = entry("the parameter that is 1 while it acts and 0 while it is off")
    latches: list[str] = entry("names of the values that it holds")


class ModelData(Data):
    """What the runtime knows of a model besides its compiled code."""

    contract: int = entry("the version of the contract, CCGEN_CONTRACT_VERSION of model.h")
    name: str = entry("the scene's name")
    hash: str = entry("the hash of the scene, which the code has too")
    precision: Literal["float", "double", "wide"] = entry("the numbers that the code computes with")
    links: list[str] = entry("names of the links", "[links]")
    joints: list[str] = entry("names of the joints", "[joints]")
    between: list[Annotated[list[Index], Field(min_length=2, max_length=2)]] = entry(
        "the two links of each joint; -1: the ground", "[joints][2]"
    )
    sides: list[Literal[-1, 1]] = entry(
        "whether the outboard link of each joint in the virtual open chain, on which the code has its force, is its "
        "second (1) or its first (-1)",
        "[joints]",
    )
    cuts: list[str] = entry("the joints at which loops are cut", "[cuts]")
    rows: list[str] = entry('names of the closure rows, as "knee.x"', "[rows]")
    lines: dict[str, LineData] = entry("the line of each joint that slides, by the joint's name")
    coordinates: list[tuple[Literal["x", "y", "angle", "slide"], str | int]] = entry(
        "what each coordinate is: x, y or the angle of a link, by number, or the length along a joint's line, by name",
        "[nq][2]",
    )
    leaders: list[int] = entry("the link whose angle each link's angle follows, itself where it has its own", "[links]")
    root: str = entry('the root of the virtual open chain, or "ground"')
    points: list[str] = entry("names of the points that the code places: joints, then link.point", "[points]")
    welded_points: dict[str, str] = entry(
        "points of welded links as the scene names them, and as points of what they became"
    )
    q_names: list[str] = entry("names of the coordinates", "[nq]")
    u_names: list[str] = entry("names of the quasi-velocities", "[nu]")
    parameters: list[ParameterData] = entry("the parameters, in the order in which the code takes them", "[parameters]")
    folded: bool = entry("whether the values of the parameters are numbers in the code, which then takes none")
    rests_on: dict[str, str] = entry(
        "parameters that must keep their values, each with the joint that is left out because it fits others with them"
    )
    over_time: dict[str, str] = entry(
        "what has a value over time where a number would be a parameter, by the path of that, and the value", default={}
    )
    of_state: list[OfStateData] = Field(
        default=[],
        description="laws and loads that are expressions of the state, laws first, each behind those that it names; "
        "left out where there are none",
    )
    drives: list[DriveData] = entry("the driven joints", "[drives]")
    inputs: list[str] = entry("names of the inputs", "[inputs]")
    accelerations: list[str] = entry("parameters that are the size of a field of accelerations, by their paths")
    instants: list[str] = entry("parameters that are times at which a load has a kink, by their paths")
    timed: bool = entry("whether what effects do changes with time", default=False)
    kinks: list[Annotated[list[float], Field(min_length=2, max_length=2)]] = Field(
        default=[],
        description="other such times (s), each with the time after which it comes again, or 0; absent where none is",
    )
    continuous: bool = Field(
        default=False, description="whether effects have kinks, and none of their loads jumps there; else absent"
    )
    contacts: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = entry(
        "each contact's point and what it touches", "[contacts][2]"
    )
    whiles: list[WhilesData] = Field(
        default=[], description="contacts that are not always there; left out where there are none"
    )
    stops: list[str] = entry("the grounds of those contacts that limit an angle")
    slide_ends: list[str] = entry("the grounds of those that limit the way along a joint's line", default=[])
    grounds: list[PlaneData] = entry("half-planes to be drawn, and from which heights are measured")
    law: Law = entry("the law of impact")
    outlines: list[list[Place]] = entry("each link's named points in its frame", "[links][...][2]", "m")
    drawn: dict[str, list[Place]] = entry(
        "what is drawn of a link, by its name, where that is not all its points; left out where no link says so",
        "[...][2]",
        "m",
        default={},
    )
    discs: list[DiscData] = entry("discs and edges to be drawn")
    ropes: list[RopeData] = Field(default=[], description="ropes to be drawn; left out where there are none")
    parts: list[PartData] = Field(
        default=[], description="what is drawn where effects act; left out where there is nothing"
    )
    outputs: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = entry(
        "what runs tell of effects: names and units", "[outputs][2]"
    )
    output_links: dict[str, str] = entry(
        "of forces and moments among these whose names do not have it, by name, the link that they act on"
    )
    latches: list[str] = entry("names of the values that effects hold, in their order", default=[])
    aids: list[str] = entry(
        "joints that only place links which no joint of the scene holds; left out where there are none", default=[]
    )
    shafts: list[str] = entry("welds of no scene that let go in the place of driven joints", default=[])
    integrators: list[IntegratorData] = entry("integrals over time; left out where there are none", default=[])
    ground_names: list[str] = entry("names of the ground's points")
    ground_points: list[Place] = entry("where they are", "[...][2]", "m")
    start: StartData = entry("where a run begins")
    run: RunData = entry("how a run goes unless told otherwise")
    switching: SwitchingData | None = Field(
        default=None, description="joints that let go and take hold; absent where none does"
    )
    events: list[EventData] = Field(default=[], description="instants that are asked for; absent where none is")
    gates: list[GateData] = Field(default=[], description="effects that events switch; left out where none does")


def schema_text() -> str:
    """The JSON schema, as it lies beside the runtime's loader."""
    return json.dumps(ModelData.model_json_schema(), indent=1) + "\n"


def table() -> str:
    """The keys as a table for docs/model.md; those of tables inside are ``key.inner``."""
    lines = ["| key | type | shape | unit | meaning |", "|---|---|---|---|---|"]
    schema = ModelData.model_json_schema()
    lines += _rows("", schema, schema["$defs"])
    return "\n".join(lines)


def _rows(before: str, schema: dict[str, Any], tables: dict[str, Any]) -> list[str]:
    lines = []
    for key, said in schema["properties"].items():
        inner = [name for name in tables if f'"#/$defs/{name}"' in json.dumps(said)]
        cells = (f"`{before}{key}`", _type(said), said.get("shape", ""), said.get("unit", ""), said["description"])
        lines.append("| " + " | ".join(cells) + " |")
        many = ".*." if "additionalProperties" in said else "[]." if said.get("type") == "array" else "."
        for name in inner:
            lines += _rows(f"{before}{key}{many}", tables[name], tables)
    return lines


def _type(said: dict[str, Any]) -> str:
    """A type in words, with its domain."""
    if "$ref" in said:
        return "table"
    if "enum" in said:
        return ", ".join(f'"{value}"' for value in said["enum"])
    if "anyOf" in said:
        return " or ".join(map(_type, said["anyOf"]))
    if said.get("type") == "array":
        inside = said.get("items") or said.get("prefixItems", [])
        return "list of " + (_type(inside) if isinstance(inside, dict) else " and ".join(map(_type, inside)))
    if "additionalProperties" in said:
        inside = said["additionalProperties"]
        return f"table of {_type(inside)}" if isinstance(inside, dict) else "table"
    names = {"string": "text", "integer": "whole number", "boolean": "true or false"}
    bounds = "".join(
        f" {sign} {said[key]:g}"
        for key, sign in (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"))
        if key in said
    )
    kind: str = said["type"]
    return names.get(kind, kind) + bounds
