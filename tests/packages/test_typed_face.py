"""What type checkers and editors know of ``import ccgen``, as it is installed: mypy and jedi, which run none of it."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import ccgen
from ccgen.generator.scene import TABLES

from ..support.effect_examples import EXAMPLES
from ..support.folders import ROOT, SCENES

TOP = """\
from pathlib import Path

import numpy as np

import ccgen
from ccgen.runtime import load_model, simulate

model = load_model("build/arm")
q, u = model.start()
"""
RUN, MODEL, MECHANISM = "ccgen.runtime.run.Run", "ccgen.runtime.model.model.Model", "ccgen.generator.builder.Mechanism"
TYPES = {
    'ccgen.simulate("x.toml")': RUN,
    'ccgen.simulate(Path("x.toml"), until=1.0, inputs={"m": 1.0})': RUN,
    "ccgen.simulate(ccgen.loop(6), [0.0, 1.0])": RUN,
    'ccgen.simulate(ccgen.Mechanism("x"), (0, 1), None, 2.0)': RUN,
    "ccgen.simulate(model, state=None)": RUN,
    "simulate(model)": RUN,
    'ccgen.simulate("x.toml", q0=[[0.0], [1.0]])': f"list[{RUN}]",
    'ccgen.simulate("x.toml", [(0.0, 1), (1.0, 0)], u, method="radau")': f"list[{RUN}]",
    "simulate(model, [[0.0], [1.0]], keep_interrupted=True)": f"list[{RUN}]",
    "simulate(model, q, u)": "Any",
    "simulate(model, np.zeros((3, 2)))": "Any",
    'ccgen.load("x.toml")': MODEL,
    "ccgen.runtime.load_model(ccgen.generator.generate(ccgen.loop(4)))": MODEL,
    "ccgen.__version__": "str",
    'ccgen.simulate("x.toml").model': MODEL,
    'ccgen.simulate("x.toml").model_at(0.5)': MODEL,
    'ccgen.Mechanism("x").link("a", rod={"mass": 1}).joint(between=("a.A", "ground.O")).run(until="3 s")': MECHANISM,
    'ccgen.Mechanism("x").part(ccgen.Mechanism("leg"), ports=["hip"]).gravity(g=np.float64(9.81))': MECHANISM,
}
FAULTS = {
    'ccgen.simulate("x.toml", utnil=1.0)': "[call-overload]",
    "ccgen.simulate(3)": 'No overload variant of "simulate"',
    "ccgen.simulat(model)": 'Module has no attribute "simulat"',
    'ccgen.simulate("x.toml").impact': '"Run" has no attribute "impact"',
    'ccgen.Mechanism("x").sprng(stiffness=1.0)': '"Mechanism" has no attribute "sprng"',
    'ccgen.Mechanism("x").spring(stifness=1.0)': 'Unexpected keyword argument "stifness"',
    'ccgen.Mechanism("x").joint(type="wedl")': 'Argument "type" to "joint"',
    'ccgen.Mechanism("x").run(until=[1.0])': 'Argument "until" to "run"',
}


def mypy(folder: Path, text: str) -> dict[int, str]:
    """What mypy, one of any version, says of each line of a program in a folder outside of the checkout."""
    (folder / "program.py").write_text(text, encoding="utf-8")
    command = (sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--hide-error-context", "program.py")
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert not done.stderr, done.stderr
    found: dict[int, str] = {}
    for number, said in re.findall(r"^program\.py:(\d+): (.*)$", done.stdout, re.MULTILINE):
        found[int(number)] = f"{found.get(int(number), '')}{said}\n"
    return found


def built(scene: dict[str, Any]) -> str:
    """The program that builds a scene call by call, in one line."""
    calls = [
        f".{key}({', '.join(f'{name}={value!r}' for name, value in table.items())})"
        for key, tables in scene.items()
        if key != "name"
        for table in (tables if isinstance(tables, list) else [tables])
    ]
    return f"ccgen.Mechanism({scene.get('name')!r}){''.join(calls)}"


def test_mypy_knows_what_is_given_and_what_is_wrong(tmp_path: Path) -> None:
    """Types of results, mistyped names; and nothing is wrong with all effects and scenes that there are."""
    pytest.importorskip("mypy", reason="mypy is not installed")
    scenes = [tomllib.loads(text) for text in EXAMPLES.values()]
    scenes += [tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(SCENES.glob("*.toml"))]
    right = [built(scene) for scene in scenes]
    lines = [*(f"reveal_type({code})" for code in TYPES), *FAULTS, *right]
    first = len(TOP.splitlines()) + 1
    said = mypy(tmp_path, TOP + "\n".join(lines) + "\n")
    found = {code: said.pop(first + k, "").replace("builtins.", "") for k, code in enumerate([*TYPES, *FAULTS])}
    assert {code: found[code] for code in TYPES} == {
        code: f'note: Revealed type is "{kind}"\n' for code, kind in TYPES.items()
    }
    missed = {
        code: found[code]
        for code, fault in FAULTS.items()
        if not re.search(f"error: .*{re.escape(fault)}", found[code])
    }
    assert missed == {}
    assert said == {} and len(right) > 50


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """jedi, as an editor asks it about a file that lies outside of the checkout."""
    jedi = pytest.importorskip("jedi", reason="jedi is not installed")
    folder = tmp_path_factory.mktemp("editor")
    jedi.settings.cache_directory = str(folder / "cache")
    python = jedi.create_environment(sys.executable, safe=False)

    def script(code: str) -> Any:
        return jedi.Script(code, path=folder / "program.py", environment=python, project=jedi.Project(folder))

    return script


@pytest.mark.slow
def test_an_editor_completes_the_public_names(editor: Any) -> None:
    names = {one.name for one in editor("import ccgen\nccgen.").complete()}
    assert {*ccgen.__all__, "generator", "runtime"} - names == set()
    (simulate, *_) = editor("import ccgen\nccgen.simulate(").get_signatures()
    assert [one.name for one in simulate.params][:4] == ["source", "q0", "u0", "until"]
    run = {one.name for one in editor('import ccgen\nccgen.simulate("x.toml").').complete()}
    assert {"t", "q", "impacts", "save_player", "model"} <= run
    names = {one.name for one in editor("from ccgen.runtime import ").complete()}
    assert {"simulate", "load_model", "identify"} <= names


@pytest.mark.slow
def test_an_editor_completes_a_mechanism(editor: Any) -> None:
    """Every table is a method, with what its keys are, also behind another one."""
    for before in ('ccgen.Mechanism("x")', 'ccgen.Mechanism("x").link("a").gravity()'):
        found = {one.name: one for one in editor(f"import ccgen\n{before}.").complete()}
        assert {*TABLES, "scene", "build", "to_toml"} <= set(found)
    for name in ("link", "joint", "spring"):
        (signature,) = found[name].get_signatures()
        assert [one.name for one in signature.params] == list(TABLES[name].keys), name
        said = " ".join(found[name].docstring().split())
        assert f"Add [[{name}]]." in said
        assert all(f"{key}: {what}" in said for key, what in TABLES[name].keys.items())
    assert 'Literal["both", "pull", "push"]' in found["spring"].docstring()


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("table_methods", ROOT / "docs" / "scripts" / "table_methods.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_stored_methods_are_those_of_the_tables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Else run docs/scripts/table_methods.py --write; ``--check`` says so."""
    told = script()
    assert told.PLACE.read_text(encoding="utf-8") == told.stub()
    monkeypatch.setattr(sys, "argv", ["table_methods.py", "--check"])
    told.main()
    monkeypatch.setattr(told, "PLACE", tmp_path / "table_methods.pyi")
    told.PLACE.write_text(told.stub().replace("stiffness", "stifness"), encoding="utf-8")
    with pytest.raises(SystemExit, match=r"is not that of the tables; run docs/scripts/table_methods\.py --write"):
        told.main()
    monkeypatch.setattr(sys, "argv", ["table_methods.py", "--write"])
    told.main()
    assert told.PLACE.read_text(encoding="utf-8") == told.stub()


def test_every_table_is_a_method_with_its_keys() -> None:
    """Read from the file by itself, which is for those who do not run Python."""
    tree = ast.parse((ROOT / "generator" / "table_methods.pyi").read_text(encoding="utf-8"))
    (methods,) = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    found = {node.name: node for node in methods.body if isinstance(node, ast.FunctionDef)}
    assert list(found) == list(TABLES)
    for name, kind in TABLES.items():
        keys = [one.arg for one in (*found[name].args.args[1:], *found[name].args.kwonlyargs)]
        assert sorted(keys) == sorted(kind.keys), name
        assert (found[name].args.kwarg is None) == bool(kind.keys)


def test_simulate_has_the_same_arguments_everywhere() -> None:
    """Of a source, of a model, as type checkers read them, and as they are passed on."""

    def known(function: ast.FunctionDef) -> list[str]:
        """Its arguments but the first two, with their types and defaults."""
        own = function.args
        defaults = [*own.defaults, *own.kw_defaults][-len(own.args) - len(own.kwonlyargs) + 2 :]
        there = zip((*own.args[2:], *own.kwonlyargs), defaults, strict=True)
        return [f"{ast.unparse(one)} = {default and ast.unparse(default)}" for one, default in there]

    found: dict[str, list[ast.FunctionDef]] = {}
    for file in ("front/__init__.py", "runtime/simulate.py"):
        tree = ast.walk(ast.parse((ROOT / file).read_text(encoding="utf-8")))
        found[file] = [one for one in tree if isinstance(one, ast.FunctionDef) and one.name == "simulate"]
    whole = [one for functions in found.values() for one in functions]
    assert len(whole) == 8 and len({tuple(known(one)) for one in whole}) == 1 and len(known(whole[0])) == 14
    for functions in found.values():
        backs = sorted(ast.unparse(one.returns) for one in functions if one.returns)
        assert backs == ["Any", "Run", "Run | Any", "list[Run]"]


def test_simulate_passes_every_argument_on(monkeypatch: pytest.MonkeyPatch) -> None:
    from ccgen import runtime

    given: list[Any] = []
    names = list(inspect.signature(runtime.simulate).parameters)[1:]
    numbers = {name: object() for name in names}
    wanted = inspect.signature(runtime.simulate)
    monkeypatch.setattr(ccgen, "load", lambda source: f"model of {source}")
    monkeypatch.setattr(runtime, "simulate", lambda *of, **named: given.append(wanted.bind(*of, **named).arguments))
    ccgen.simulate("arm.toml", **numbers)  # type: ignore[call-overload]
    assert given == [{"model": "model of arm.toml", **numbers}]
