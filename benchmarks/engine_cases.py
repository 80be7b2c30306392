"""The five motions in which engines are compared, with what is known of each."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from driver import ROOT, WORK
from engine_audits import Strike, energy
from linkage import Linkage, centred, of_model
from workload import Array, workload

from ccgen.generator import Scene, generate, load_scene, loop
from ccgen.runtime import Model, Run, load_model, simulate
from ccgen.runtime.cost.accuracy import refer

sys.path.insert(0, str(ROOT / "docs" / "scripts"))
import accuracy
import strandbeest

TIGHT = 1e-10
"""How well the impact times of the reference must agree with those that other programs found (s)."""


@dataclass(frozen=True)
class Case:
    """A motion: its scene, its end (s), the steps (s) that engines take, loosest first, and how often it is looked at.

    ``quick`` is the end in a quick run. ``impacts`` is how many first impacts are compared, ``rests`` whether the
    motion ends at rest on the floor, which is then all that is known exactly of its end.
    """

    name: str
    title: str
    scene: Callable[[], Scene]
    until: float
    quick: float
    steps: tuple[float, ...]
    samples: int
    impacts: int = 0
    restitution: float | None = None
    rests: bool = False


@dataclass
class Setting:
    """A case made ready: ccgen's model, the linkage for engines; of the reference at the end the poses (n, 3) of mass
    centres and the energy (J), how far it is known, and impacts."""

    case: Case
    until: float
    model: Model
    linkage: Linkage
    centres: Array
    end: Array
    energy: float
    doubt: float
    impacts: list[Strike] = field(default_factory=list)

    def states(self, run: Run) -> Array:
        """States (t, n, 6) at the rows of a run of ccgen."""
        poses, speeds = self.model.poses(run.q), self.model.velocities(run.q, run.u)
        return centred(poses, speeds, self.centres)


def strikes_of(run: Any) -> list[Strike]:
    """Impacts of a run of a ring, one for every corner that is pushed; corner k is joint_k."""
    pushed = ((i.t, point, p) for i in run.impacts for (point, _), p in zip(i.contacts, i.impulses, strict=True))
    return [Strike(float(t), int(point.rpartition("_")[2])) for t, point, impulse in pushed if impulse > 0.0]


def tossed(name: str, **tables: Any) -> Scene:
    """The ring W(6) of workload.py in motion."""
    first = workload(6, 1)
    poses, speeds = first.poses[0], first.velocities[0]
    start: dict[str, Any] = {
        "angles": poses[:, 2].tolist(),
        "angular_velocities": speeds[:, 2].tolist(),
        "velocity": speeds[0, :2].tolist(),
    }
    start |= tables.pop("start", {"position": poses[0, :2].tolist()})
    return loop(6, gravity=True, name=name, start=start, **tables)


def dropped() -> Scene:
    """W(6) half a metre above a smooth floor."""
    return tossed("engines-drop", start={"height": 0.5}, ground=[{"restitution": 0.7}])


def walking() -> Scene:
    """The walking machine of docs/scripts/strandbeest.py with one crank and two legs, without its pumps, afloat.

    Its lengths are Jansen's numbers in metres, as when the tables of docs/accuracy.md were measured."""
    path = WORK / "engines-machine.toml"
    text = strandbeest.text([0.0], pumps=False, per_metre=1.0)
    path.write_text(text.replace('name = "strandbeest"', 'name = "engines-machine"', 1))
    return load_scene(path)


CASES = (
    Case(
        "hexagon",
        "Falling hexagon, six impacts, e = 0.5, 1 s",
        lambda: load_scene(ROOT / "scenes" / "falling-hexagon.toml"),
        1.0,
        1.0,
        (1e-2, 1e-3, 1e-4, 1e-5),
        10**6,
        impacts=7,
        restitution=0.5,
    ),
    Case(
        "drop",
        "Drop to rest, e = 0.7, 5 s",
        dropped,
        5.0,
        5.0,
        (1e-2, 1e-3, 1e-4),
        10**6,
        impacts=3,
        restitution=0.7,
        rests=True,
    ),
    Case("ring", "Ring W(6) in flight, 10 s", lambda: tossed("engines-ring"), 10.0, 2.0, (1e-2, 1e-3, 1e-4), 1000),
    Case(
        "four-bar",
        "Four-bar, 1,000 s",
        lambda: load_scene(ROOT / "scenes" / "four-bar.toml"),
        1000.0,
        10.0,
        (1e-2, 4e-3, 1e-3),
        1000,
    ),
    Case("machine", "Walking machine in flight, 2 s", walking, 2.0, 0.5, (1e-2, 1e-3, 1e-4), 1000),
)


def prepare(case: Case, quick: bool = False) -> Setting:
    """Generate the case in doubles and in wide numbers, and compute its reference.

    Raises ``ValueError`` where there is none, or where its impacts are not those that are known.
    """
    WORK.mkdir(parents=True, exist_ok=True)
    scene = case.scene()
    until = case.quick if quick else case.until
    model = load_model(generate(scene, out=WORK / "models"))
    bounces = case.restitution is not None
    linkage = of_model(model, scene, corners=bounces, restitution=case.restitution or 0.0)
    centres = np.array([link.com.values() for link in scene.mechanism.links], dtype=float)
    setting = Setting(case, until, model, linkage, centres, np.zeros((0, 3)), 0.0, 0.0)
    if case.rests:
        run = simulate(model, until=until, rtol=1e-12)
        setting.impacts = strikes_of(run)[: case.impacts]
        setting.energy = float(energy(linkage, setting.states(run)[-1]))
        return setting
    wide = load_model(generate(scene, out=WORK / "models", precision="wide"))
    reference = refer(wide, until)
    q, u = reference.run.q[-1], reference.run.u[-1]
    last = centred(wide.poses(q).astype(float), wide.velocities(q, u).astype(float), centres)
    setting.end, setting.energy = last[:, :3], float(energy(linkage, last))
    setting.doubt = reference.doubt
    if bounces:
        setting.impacts = strikes_of(reference.run)[: case.impacts]
        times = sorted({strike.time for strike in setting.impacts})
        off = max(abs(a - b) for a, b in zip(times, accuracy.TIMES, strict=True))
        if off > TIGHT:
            raise ValueError(f"{case.name}: impacts of the reference are off the known ones by {off:.1e} s")
    return setting
