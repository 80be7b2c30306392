"""What no argument is, for each argument of what a user calls: refused with what was found and expected, or taken."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import pytest

import ccgen.runtime
from ccgen.runtime import simulate

from ..support.odd_arguments import ODD, complaint, odd_calls
from ..support.tiers import hard
from ..support.workshop import Workshop

OF_MODEL = (
    *("acceleration", "multipliers", "reactions", "contact_forces", "impact", "point", "point_velocity"),
    *(
        "point_acceleration",
        "point_jacobian",
        "energy",
        "poses",
        "velocities",
        "gaps",
        "closure",
        "assemble",
        "project",
    ),
    *("joint_angles", "with_parameters", "mass_matrix", "derivatives", "acceleration_jacobian", "motions", "slides"),
)
OF_RUN = (
    "at",
    "point",
    "values",
    "contact_forces",
    "reactions",
    "accelerations",
    "joint_angles",
    "model_at",
    "jacobian",
    "plot",
    "save",
)
OF_RUNTIME = (
    *("simulate", "driving_torque", "momentum", "static_equilibrium", "reach", "follow", "inverse_dynamics"),
    *("linearise", "load_model", "load_run", "methods"),
)
CASES = [
    *(f"model.{name}" if name in ("point", "impact") else hard(f"model.{name}") for name in OF_MODEL),
    *(f"run.{name}" if name in ("point", "values") else hard(f"run.{name}") for name in OF_RUN),
    *(hard(f"runtime.{name}") if name == "reach" else f"runtime.{name}" for name in OF_RUNTIME),
]


@pytest.mark.parametrize("case", CASES)
def test_odd_arguments_are_taken_or_refused(
    case: str, workshop: Workshop, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ccgen.generator import loop

    monkeypatch.chdir(tmp_path)
    model = workshop.model(
        loop(4, gravity=True, start={"height": 1.0}, ground=[{"restitution": 0.5}]), derivatives=True
    )
    q, u = model.start()
    known: dict[str, Any] = {"model": model, "q": q, "u": u, "t": 0.1, "u_dot": u, "name": "joint_0"}
    known |= {"joint": "joint_0", "joints": ["joint_0"], "rate": 1.0, "contacts": model.contacts[:1]}
    known |= {"of": "energy", "wrt": ["u0"], "outputs": ["q"], "path": "nowhere"}
    owners = {"model": model, "run": simulate(model, until=0.2), "runtime": ccgen.runtime}
    owner, _, name = case.partition(".")
    call = getattr(owners[owner], name)
    required = [one for one in inspect.signature(call).parameters.values() if one.default is inspect.Parameter.empty]
    given = {one.name: known.get(one.name) for one in required if one.kind is one.POSITIONAL_OR_KEYWORD}
    given |= {"until": 0.02} if name == "simulate" else {}
    tried, wrong = 0, []
    for argument, odd, arguments in odd_calls(call, given):
        tried += 1
        if argument == "outputs" and callable(arguments[argument]):
            continue  # a function of the user's own, which is called
        if found := complaint(call, arguments, argument):
            wrong.append((argument, odd, found))
    if name == "values":
        for odd, value in ODD.items():
            if found := complaint(owners["run"].values, (value,), "names"):
                wrong.append(("names", odd, found))
    assert tried >= len(ODD) and not wrong
