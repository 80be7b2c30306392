"""Values that may be meant otherwise are remarked on; angles and speeds whose digits or energy are gone are refused."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccgen.generator.effects import REGISTRY
from ccgen.generator.scene import SceneError, chain, read_tables
from ccgen.generator.scene import angles as written
from ccgen.generator.scene.angles import angle_keys
from ccgen.generator.scene.schema import FourBarsTable, JointTable, LinkTable, LoopTable, StartTable
from ccgen.runtime import Model, simulate
from ccgen.runtime.model import tolerances

from ..support.command_line import ccgen
from ..support.workshop import Workshop

ARM: dict[str, Any] = {
    "ground_link": {"points": {"O": [0, 0]}},
    "link": [
        {"name": name, "mass": 1, "inertia": 0.1, "com": [0.5, 0], "points": {"A": [0, 0], "B": [1, 0]}}
        for name in ("upper", "fore")
    ],
    "joint": [
        {"name": "shoulder", "between": ["ground.O", "upper.A"]},
        {"name": "elbow", "between": ["upper.B", "fore.A"]},
    ],
}


def thick(thickness: Any) -> list[dict[str, Any]]:
    """A plate a metre long, and a rod with a disc of 0.2 m."""
    steel = {"density": 7850, "thickness": thickness}
    upper = {"A": [0, 0], "B": [1, 0], "C": [0.5, 0.1]}
    discs = [{"mass": 1, "radius": 0.1, "centre": "A"}, {**steel, "radius": 0.1, "centre": "B"}]
    fore = {"name": "fore", "disc": discs, "points": {"A": [0, 0], "B": [1, 0]}}
    return [{"name": "upper", "plate": steel, "points": upper}, fore]


REMARKS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "angles by name": (
        {"start": {"angles": {"upper": 90, "fore": 1.5}}},
        ['start.angles.upper: 90 is taken as rad, 14.3 turns; write "90 deg" for degrees'],
    ),
    "a list of angles": (
        {"start": {"angles": [0.1, -20]}},
        ['start.angles[1]: -20 is taken as rad, 3.18 turns; write "-20 deg" for degrees'],
    ),
    "a pose": (
        {"start": {"poses": {"upper": [0, 0, 45]}}},
        ['start.poses.upper[2]: 45 is taken as rad, 7.16 turns; write "45 deg" for degrees'],
    ),
    "limits": (
        {"stop": [{"joint": "elbow", "lowest": -10, "highest": "170 deg", "restitution": 0}]},
        ['stop[0].lowest: -10 is taken as rad, 1.59 turns; write "-10 deg" for degrees'],
    ),
    "where a joint lets go": (
        {"release": [{"joint": "elbow", "when": {"angle": "shoulder", "above": 135}}]},
        ['release[0].when.above: 135 is taken as rad, 21.5 turns; write "135 deg" for degrees'],
    ),
    "at which height it lets go": ({"release": [{"joint": "elbow", "when": {"height": "fore.B", "below": -30}}]}, []),
    "rest": (
        {"torsion": [{"joint": "elbow", "stiffness": 1, "angle": 30.0}]},
        ['torsion[0].angle: 30 is taken as rad, 4.77 turns; write "30 deg" for degrees'],
    ),
    "a motor": (
        {"motor": [{"joint": "elbow", "stiffness": 1, "angle": 30}]},
        ['motor[0].angle: 30 is taken as rad, 4.77 turns; write "30 deg" for degrees'],
    ),
    "with units, or within a turn": (
        {"start": {"angles": ["90 deg", 6.28]}, "motor": [{"joint": "elbow", "stiffness": 1, "angle": "400 deg"}]},
        [],
    ),
    "gravity upwards": (
        {"gravity": {"g": -9.81}},
        [
            "gravity.g: -9.81 is taken as given, so that things fall along [0, 1], against its direction [0, -1]; "
            "write 9.81 if not"
        ],
    ),
    "gravity along a slope": (
        {"gravity": {"g": -2, "direction": [3, -4]}},
        [
            "gravity.g: -2 is taken as given, so that things fall along [-0.6, 0.8], against its direction "
            "[0.6, -0.8]; write 2 if not"
        ],
    ),
    "a thickness of 5 that is meant in mm": (
        {"link": thick(5)},
        [
            "link[0].plate.thickness: 5 is taken as m, more than the 1 m that the body measures in the plane, and its "
            'mass is so many times as large; write "5 mm" for millimetres, or "5 m"',
            "link[1].disc[1].thickness: 5 is taken as m, more than the 0.2 m that the body measures in the plane, and "
            'its mass is so many times as large; write "5 mm" for millimetres, or "5 m"',
        ],
    ),
    "a thickness that says its unit, or is small": ({"link": [*thick("5 m")[:1], *thick(0.1)[1:]]}, []),
    "gravity": ({"gravity": {"g": 9.81, "direction": [0, 1]}}, []),
}


@pytest.mark.parametrize("case", REMARKS)
def test_what_was_understood_is_told(case: str) -> None:
    """The scene is as written, and says how it is read."""
    extra, remarks = REMARKS[case]
    scene = read_tables(ARM | extra, "arm", "arm")
    assert list(scene.remarks) == [f"arm: {remark}" for remark in remarks]
    if case == "angles by name":
        assert scene.start.sketch.angles == (90.0, 1.5)


def test_remarks_change_no_model() -> None:
    """Radians beyond a turn with and without their unit are one scene."""
    bare, unit = (chain(2, True, start={"angles": [angle, 0]}) for angle in (90, "90 rad"))
    assert bare.remarks and not unit.remarks
    assert bare == unit and bare.canonical() == unit.canonical()


def test_every_angle_of_a_scene_is_judged() -> None:
    """Keys that are read as angles are those that remarks look at, and lengths of the same name are not."""

    tables = (StartTable, JointTable, LinkTable, LoopTable, FourBarsTable, *(entry.table for entry in REGISTRY))
    for table in tables:
        fields = table.model_fields.items()
        found = {
            key
            for key, field in fields
            if re.search(r"(Measured|InTime)\(rad\)", repr((field.annotation, field.metadata)))
        }
        assert found | ({"poses"} & set(table.model_fields)) == set(angle_keys(table)), table
    by_name = {entry.key: angle_keys(entry.table) for entry in REGISTRY}
    assert "play" in by_name["torsion"] and "play" not in by_name["spring"]


def test_the_command_line_prints_remarks(tmp_path: Path) -> None:
    (tmp_path / "up.toml").write_text("[chain]\nlinks = 1\nhinged = true\n[gravity]\ng = -9.81\n[start]\ntilt = 90\n")
    done = ccgen("show", "up.toml", at=tmp_path)
    told = done.stderr.splitlines()
    assert done.returncode == 0
    assert any(line.startswith("up.toml:5: gravity.g: -9.81 is taken as given") for line in told)
    assert any(line.startswith("up.toml:7: start.tilt: 90 is taken as rad, 14.3 turns") for line in told)
    quiet = ccgen("show", "up.toml", "-q", at=tmp_path).stderr.splitlines()
    assert quiet == [line for line in told if line.startswith("up.toml:")]


# -- digits that are gone -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def arm(workshop: Workshop) -> Model:
    model: Model = workshop.model(read_tables(ARM | {"gravity": {}}, "arm", "arm"))
    return model


def test_one_limit_for_scenes_and_states() -> None:
    """Beyond it the last place of an angle is larger than joints of a state may miss at a length of a metre."""
    assert written.KNOWN == tolerances.ANGLE_KNOWN == tolerances.JOINT_MISS
    assert np.spacing(2.0 * written.LARGEST) > written.KNOWN >= 0.5 * np.spacing(0.5 * written.LARGEST)


@pytest.mark.parametrize("angle", [1e12, -1e12, "1e14 deg", 1e300])
@pytest.mark.parametrize("key", ["angles[0]", "angles.fore", "tilt"])
def test_scenes_refuse_angles_without_digits(angle: float | str, key: str) -> None:
    start = {"angles[0]": {"angles": [angle, 0]}, "angles.fore": {"angles": {"fore": angle}}, "tilt": {"tilt": angle}}
    with pytest.raises(SceneError) as caught:
        read_tables(ARM | {"start": start[key]}, "arm", "arm")
    (fault,) = caught.value.faults
    assert fault.key == f"start.{key}"
    assert "expected at most 4.5e+09 rad, beyond which no digits are left" in fault.message


@pytest.mark.parametrize("angle", [1e12, -1e12, 1e300])
def test_states_refuse_angles_without_digits(arm: Model, angle: float) -> None:
    q, u = arm.start()
    far = q + np.array([0.0, angle])
    for call in (arm.acceleration, arm.reactions, arm.energy, arm.project):
        with pytest.raises(ValueError, match=r"q: found theta_1 = .* rad, expected at most 4\.5e\+09 rad"):
            call(far, u)
        with pytest.raises(ValueError, match="theta_1"):
            call(np.array([q, far]), np.array([u, u]))
    for call in (arm.poses, arm.gaps):
        with pytest.raises(ValueError, match="theta_1"):
            call(far)
    with pytest.raises(ValueError, match="theta_1"):
        simulate(arm, far, u, until=0.1)


def test_many_turns_are_a_state(arm: Model) -> None:
    """A thousand turns away the motion is the same, to what the angle is known to."""
    q, u = arm.start()
    away = q + 2000.0 * math.pi
    near, far = (simulate(arm, start, u, until=1.0, rtol=1e-11) for start in (q, away))
    assert np.abs(far.q[-1] - near.q[-1] - 2000.0 * math.pi).max() <= 1e-10


@pytest.mark.parametrize("speed", [1e155, -1e200, 1e308])
def test_starts_without_a_finite_energy_are_refused(arm: Model, speed: float) -> None:
    q, _ = arm.start()
    with pytest.raises(ValueError, match=r"u0: found a start with a kinetic energy of inf J, expected a finite number"):
        simulate(arm, q, np.array([speed, speed]), until=1.0)
    with pytest.raises(SceneError, match=r"start: found velocities of up to .* expected a kinetic energy that is"):
        read_tables(ARM | {"start": {"angular_velocities": [speed, speed]}}, "arm", "arm")
