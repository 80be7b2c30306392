"""What ``ccgen show`` prints, the expanded closed form, and that generated C has no warnings."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from ccgen.generator import Scene, chain, generate, load_scene, loop, pinned
from ccgen.generator.derive.expanded import LIMIT, ExpandedForm
from ccgen.generator.documents.latex import symbol_tex
from ccgen.generator.documents.show import show_text
from ccgen.generator.equations.names import State
from ccgen.generator.pipeline import listing
from ccgen.generator.program.reading import read_listing
from ccgen.generator.scene import read_tables

from ..oracles import graphs
from ..support.closed_forms import LINKS, closed_form
from ..support.effect_examples import EXAMPLES, MESHES, SCENE
from ..support.folders import ROOT
from ..support.tiers import all_hard_but
from ..support.workshop import Workshop

FILES = ROOT / "scenes"

RING_ON_TWO_GROUNDS = """
name = "ring"
[loop]
links = 4
length = [1.0, 0.8, 0.9, 0.7]
mass = [1.0, 2.0, 0.5, 1.5]
com = [[0.4, 0.1], [0.3, 0.0], [0.5, -0.1], [0.2, 0.2]]
[start]
height = 1.0
[gravity]
g = 9.81
[[ground]]
normal = [0.6, 0.8]
point = [0.1, -5.0]
restitution = 0.5
[[ground]]
point = [0, -5]
restitution = 0.25
contacts = ["joint_1", "link_2.B"]
"""


SCENES: dict[str, Callable[[], Scene]] = {
    "loop": lambda: loop(4),
    "pinned": lambda: pinned(2, gravity=True),
    "chain": lambda: chain(1),
    "hinged": lambda: chain(2, hinged=True, gravity=True),
    "long": lambda: loop(24, gravity=True),
    "four-bar": lambda: load_scene(FILES / "four-bar.toml"),
    "hexagon": lambda: load_scene(FILES / "falling-hexagon.toml"),
    "every effect": lambda: read_tables(tomllib.loads(SCENE + "".join(EXAMPLES.values())), "every", "every_effect"),
    "every load": lambda: read_tables(
        tomllib.loads(
            LINKS["hinged"] + "".join(text for key, text in EXAMPLES.items() if key not in ("drive", *MESHES))
        ),
        "loads",
        "every_load",
    ),
    "shared runs": lambda: read_tables(
        tomllib.loads(graphs.mechanism("shared", graphs.theta([12, 12, 9])).toml()), "shared", "shared"
    ),
}


# -- the closed form -----------------------------------------------------------------------------------------------


def test_the_double_pendulum_is_that_of_the_textbooks() -> None:
    form = closed_form(chain(2, hinged=True, gravity=True))
    m1, m2, i1, i2, c1, c2, l1, g = sp.symbols("m_0 m_1 I_0 I_1 c_0_x c_1_x l_0 g")
    t1, t2, w1, w2 = sp.symbols("theta_0 theta_1 w_0 w_1")
    coupling = m2 * l1 * c2 * sp.cos(t1 - t2)
    mass = sp.Matrix([[i1 + m1 * c1**2 + m2 * l1**2, coupling], [coupling, i2 + m2 * c2**2]])
    rest = sp.Matrix(
        [
            m2 * l1 * c2 * sp.sin(t1 - t2) * w2**2 + (m1 * c1 + m2 * l1) * g * sp.cos(t1),
            -m2 * l1 * c2 * sp.sin(t1 - t2) * w1**2 + m2 * c2 * g * sp.cos(t2),
        ]
    )
    assert form.state.u == (w1, w2)
    assert sp.simplify(sp.Matrix(form.M) - mass) == sp.zeros(2, 2)
    assert sp.simplify(sp.Matrix(form.h) - rest) == sp.zeros(2, 1)
    assert form.A.shape == (0, 2)
    assert form.N.shape == (0, 2)


def test_the_double_pendulum_is_written_as_a_person_would() -> None:
    text = show_text(chain(2, hinged=True, gravity=True), False, True)
    for line in (
        "M u_dot + h = 0",
        "M[w_0, w_0] = I_0 + m_0*c_0_x**2 + m_1*l_0**2\n",
        "M[w_0, w_1] = c_1_x*l_0*m_1*cos(theta_0 - theta_1)\n",
        "M[w_1, w_1] = I_1 + m_1*c_1_x**2\n",
        "h[w_0] = g*(c_0_x*m_0 + l_0*m_1)*cos(theta_0) + c_1_x*l_0*m_1*sin(theta_0 - theta_1)*w_1**2\n",
    ):
        assert line in text
    assert "lambda" not in text
    assert "impact: M" not in text


def test_rows_of_the_closed_form_are_those_of_the_kernels(workshop: Workshop) -> None:
    """A u, N u and Nᵀ P of the closed form against the kernels of the listing."""
    scene = workshop.scene(RING_ON_TWO_GROUNDS)
    form, read = closed_form(scene), read_listing(listing(scene))
    assert form.contacts == (*((f"joint_{k}", "ground_0") for k in range(4)), *(_second_ground()))
    data = {sp.Symbol(name): value for name, value in read.parameters.items()}
    for a in form.definitions:
        data[a.symbol] = float(a.expression.subs(data))
    rng = np.random.default_rng(3)
    for _ in range(5):
        q, u, pushes = rng.uniform(-2, 2, 6), rng.uniform(-2, 2, 6), rng.uniform(0, 1, len(form.contacts))
        state = data | dict(zip([*form.state.q, *form.state.u], [*q, *u], strict=True))
        rows, normals = (np.array(m.subs(state), dtype=float) for m in (form.A, form.N))
        assert rows @ u == pytest.approx(read.evaluate("closure_rate", {"q": q, "u": u})["rate"], abs=1e-13)
        assert rows.ravel() == pytest.approx(read.evaluate("closure_jacobian", {"q": q})["A"], abs=1e-13)
        assert normals @ u == pytest.approx(read.evaluate("gap_rates", {"q": q, "u": u})["rate"], abs=1e-13)
        found = read.evaluate("contact_impulse", {"q": q, "P": pushes})["f"]
        assert normals.T @ pushes == pytest.approx(found, abs=1e-13)


def _second_ground() -> tuple[tuple[str, str], ...]:
    return (("joint_1", "ground_1"), ("link_2.B", "ground_1"))


def test_the_closed_form_with_loops_and_grounds_is_complete(workshop: Workshop) -> None:
    text = show_text(workshop.scene(RING_ON_TWO_GROUNDS), False, True)
    for part in (
        "[flight: M u_dot + h = A^T lambda, A u_dot + dA/dt u = 0]",
        "lambda: lambda_2_x, lambda_2_y",
        "A[lambda_2_x, w_0] = l_0*sin(theta_0)",
        "(dA/dt u)[lambda_2_y] = ",
        "[impact: M (u_plus - u_minus) = A^T Lambda + N^T P, A u_plus = 0, 0 <= P, 0 <= N u_plus + e N u_minus",
        "nu_0_x = n_0_x/length_n_0",
        "N[joint_1 on ground_1, vy_0] = nu_1_y",
    ):
        assert part in text


@pytest.mark.parametrize("latex", [False, True])
def test_many_links_are_not_expanded(latex: bool) -> None:
    with pytest.raises(ValueError, match=rf"found {LIMIT + 1} links, expected at most {LIMIT} .* leave out --expand"):
        show_text(loop(LIMIT + 1), latex, True)
    assert show_text(loop(LIMIT), latex, True)


def test_a_closed_form_checks_itself() -> None:
    w = sp.Symbol("w_0")
    state, empty, one = State((sp.Symbol("theta_0"),), (w,)), sp.ImmutableMatrix(0, 1, []), sp.ImmutableMatrix([[1]])
    nothing = sp.ImmutableMatrix(0, 1, [])
    form = ExpandedForm(state, (), (), one, one, empty, nothing, empty)
    assert form.definitions == ()
    with pytest.raises(ValueError, match="h has shape"):
        ExpandedForm(state, (), (), one, sp.ImmutableMatrix([[1, 2]]), empty, nothing, empty)
    two = State((), (w, sp.Symbol("w_1")))
    skew, none = sp.ImmutableMatrix([[1, 2], [3, 4]]), sp.ImmutableMatrix(0, 2, [])
    with pytest.raises(ValueError, match="not symmetric"):
        ExpandedForm(two, (), (), skew, sp.ImmutableMatrix([1, 2]), none, nothing, none)


# -- text ----------------------------------------------------------------------------------------------------------


def test_the_text_says_what_the_mechanism_is() -> None:
    scene = load_scene(FILES / "falling-hexagon.toml")
    text = show_text(scene, False, False)
    summary, _, equations = text.partition("\n\n")
    words = " ".join(summary.split())
    for part in (
        "model falling-hexagon",
        "links 6: link_0, link_1, link_2, link_3, link_4, link_5",
        "joint_0 (link_5.B = link_0.A)",
        "root link_0, floating",
        "loops cut at joint_3: link_2 - link_1 - link_0 - link_5 - link_4 - link_3",
        "degrees of freedom 6 = 8 quasi-velocities - rank 2 of the 2 closure rows at the start",
        "coordinates q x_0 = link_0.x, y_0 = link_0.y, theta_0 = link_0.angle",
        "quasi-velocities u vx_0, vy_0, w_0",
        "gravity: gravity.g = 9.81",
        "ground_0.restitution = 0.5",
        "joint_3 on ground_0",
    ):
        assert part in words
    for kernel in ("acceleration", "impulse", "energy", "gaps"):
        assert re.search(rf"\b{kernel}: \d+ operations \(", words)
    assert equations + "\n" == listing(scene)


def test_what_a_scene_lacks_is_said_or_left_out() -> None:
    words = " ".join(show_text(chain(2), False, False).partition("\n\n")[0].split())
    assert "loops none" in words
    assert "degrees of freedom 4, no closure" in words
    assert "effects none" in words
    assert "contacts" not in words
    assert "root ground" in " ".join(show_text(pinned(3), False, False).split())


def test_degrees_of_freedom_count_the_rank_of_the_closure(workshop: Workshop) -> None:
    """A parallelogram with a third crank has four closure rows, of which one is redundant."""
    cranks = "".join(
        f'[[link]]\nname = "crank_{k}"\nmass = 1.0\ninertia = 0.1\ncom = [0.5, 0.0]\n'
        "points = { A = [0, 0], B = [1, 0] }\n"
        for k in range(3)
    )
    joints = "".join(
        f'[[joint]]\nbetween = ["ground.O{k}", "crank_{k}.A"]\n[[joint]]\nbetween = ["crank_{k}.B", "beam.P{k}"]\n'
        for k in range(3)
    )
    points = "O0 = [0, 0], O1 = [1, 0], O2 = [2, 0]"
    scene = workshop.scene(
        f'name = "parallel"\n[ground_link]\npoints = {{ {points} }}\n{cranks}'
        '[[link]]\nname = "beam"\nmass = 1.0\ninertia = 0.1\ncom = [1.0, 0.0]\n'
        f"points = {{ {points.replace('O', 'P')} }}\n{joints}"
        '[start]\nangles = { crank_0 = "60 deg", crank_1 = "60 deg", crank_2 = "60 deg", beam = 0.0 }\n'
    )
    text = show_text(scene, False, False)
    assert "1 = 4 quasi-velocities - rank 3 of the 4 closure rows at the start" in text
    assert text.count("cut at ") == 2


# -- LaTeX ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "tex"),
    [
        ("theta_3", r"\theta_{3}"),
        ("Phi_3_xx", r"\Phi_{3,xx}"),
        ("lambda_4_x", r"\lambda_{4,x}"),
        ("given_lambda_4_x", r"\lambda_{4,x}"),
        ("Lambda_4_x", r"\Lambda_{4,x}"),
        ("w_0", r"\omega_{0}"),
        ("w2_0", r"\omega_{0}^{2}"),
        ("vx_2", "v_{2,x}"),
        ("vx_2_dot", r"\dot{v}_{2,x}"),
        ("w_11_dot", r"\dot{\omega}_{11}"),
        ("F_w_3", r"F_{\omega_{3}}"),
        ("F_vy_3", "F_{v_{3,y}}"),
        ("dw_1", r"\Delta\omega_{1}"),
        ("c_1", r"\mathrm{c}_{1}"),
        ("c_1_x", "c_{1,x}"),
        ("mx_1", r"\bar\mu_{1,x}"),
        ("l_1_tip_x", r"l_{1,\mathrm{tip},x}"),
        ("length_n_0", r"\lvert n_{0}\rvert"),
        ("g", "g"),
    ],
)
def test_symbols_in_latex(name: str, tex: str) -> None:
    assert symbol_tex(name) == tex


def _marks(name: str) -> list[pytest.MarkDecorator]:
    """Two long mechanisms, and all loads or effects at once, are hard."""
    if name in ("long", "shared runs", "every load", "every effect"):
        return [pytest.mark.hard]
    return [] if name in ("loop", "pinned", "chain", "hinged") else [pytest.mark.slow]


DOCUMENTS = [
    pytest.param(name, expanded, marks=_marks(name))
    for name in SCENES
    for expanded in (False, True)
    if not (expanded and name in ("long", "hexagon", "shared runs", "every effect"))
]


@pytest.mark.sample(4)
@pytest.mark.parametrize(("name", "expanded"), DOCUMENTS)
def test_latex_is_balanced(name: str, expanded: bool) -> None:
    text = show_text(SCENES[name](), True, expanded)
    assert text.startswith(r"\documentclass")
    assert text.endswith(r"\end{document}")
    bare = re.sub(r"\\[\\{}_&%#$]", "", text)
    depth = 0
    for sign in bare:
        depth += (sign == "{") - (sign == "}")
        assert depth >= 0
    assert depth == 0
    assert bare.count("$") % 2 == 0
    assert bare.count(r"\left") == bare.count(r"\right")
    open_: list[str] = []
    for verb, environment in re.findall(r"\\(begin|end)\{(\w+\*?)\}", text):
        if verb == "begin":
            open_.append(environment)
        else:
            assert open_.pop() == environment
    assert not open_


def test_latex_has_every_part_of_the_derivation() -> None:
    text = show_text(load_scene(FILES / "falling-hexagon.toml"), True, False)
    for part in (
        r"\item[degrees of freedom] 6 = 8",
        r"\subsection*{Kinematics of link 3 (link\_3)}",
        r"S_{3} &= ",
        r"\partial V/\partial \alpha_{3} = 0 &= ",
        r"\partial V/\partial \lambda_{3,x} = 0 &= ",
        r"\dot{\omega}_{5} &= \alpha_{5}",
        r"M\dot u + h = A^{\mathsf T}\lambda",
        r"\mathrm{residual}_{1} &= ",
        r"\mathrm{gap}_{5} &= ",
        r"\perp N u^{+}",
    ):
        assert part in text


def test_latex_without_loops_or_grounds_has_none() -> None:
    text = show_text(chain(2), True, True)
    assert r"\lambda" not in text
    assert "Impact" not in text
    assert r"M\dot u + h = 0" in text


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize(("name", "expanded"), DOCUMENTS)
def test_latex_compiles(name: str, expanded: bool, tmp_path: Path) -> None:
    (tmp_path / "shown.tex").write_text(show_text(SCENES[name](), True, expanded), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "shown.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[-2000:]


# -- generated C ---------------------------------------------------------------------------------------------------


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
@pytest.mark.parametrize("name", all_hard_but("hexagon", of=SCENES))
def test_generated_c_has_no_warnings(name: str, tmp_path: Path) -> None:
    folder = generate(SCENES[name](), out=tmp_path / "build")
    command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-c", "model.c"]
    done = subprocess.run(
        [*command, "-o", str(tmp_path / "model.o")], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


PRESS = """
name = "press"
[ground_link]
points = { O = [0, 0] }
[[link]]
name = "crank"
rod = { mass = 0.5 }
points = { A = [0, 0], B = [0.1, 0] }
[[link]]
name = "conrod"
rod = { mass = 1.0 }
points = { A = [0, 0], B = [0.3, 0] }
[[link]]
name = "slider"
mass = 2.0
inertia = 0.01
com = [0, 0]
points = { C = [0, 0] }
[[joint]]
between = ["ground.O", "crank.A"]
[[joint]]
between = ["crank.B", "conrod.A"]
[[joint]]
between = ["conrod.B", "slider.C"]
[[joint]]
type = "prismatic"
between = ["ground.O", "slider.C"]
axis = [1, 0]
[[ground]]
point = [0.38, 0]
normal = [-1, 0]
restitution = 0.3
contacts = ["slider.C"]
[start]
angles = { crank = "90 deg" }
[gravity]
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no cc")
def test_what_impulses_of_contacts_do_not_need_is_not_written(tmp_path: Path) -> None:
    """A slider strikes along its line: part of what solves for the closure is multiplied by zeros only."""
    (tmp_path / "press.toml").write_text(PRESS, encoding="utf-8")
    folder = generate(load_scene(tmp_path / "press.toml"), out=tmp_path / "build")
    command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-c", "model.c", "-o", "/dev/null"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_summary_says_what_each_effect_adds() -> None:
    summary = show_text(load_scene(FILES / "falling-hexagon.toml"), False, False).partition("\n\n")[0]
    table = [line.split() for line in summary.partition("added by effects")[2].splitlines()]
    assert table[0] == ["effect", "adds", "to", "sums", "products", "quotients", "sines", "functions"]
    assert ["gravity", "acceleration", "1", "0", "0", "0", "0"] in table
    assert ["ground_0", "events", "21", "50", "0", "15", "0"] in table
    assert "added by effects" not in show_text(chain(2), False, False)
    tex = show_text(load_scene(FILES / "falling-hexagon.toml"), True, False)
    assert r"ground\_0 & events & 21 & 50 & 0 & 15 & 0 \\" in tex


DRIVEN = {
    "speed": ('joint = "elbow"\nspeed = 1.5', "drive_0: elbow at speed drive_0.speed = 1.5"),
    "angle": ('joint = "motor"\nangle = "1.6 + sin(t)"', "drive_0: motor at angle 1.6 + sin(t)"),
    "held": ('joint = "motor"\nangle = 1.5', "drive_0: motor at angle 1.5"),
}


@pytest.mark.parametrize("case", DRIVEN)
def test_driven_joints_are_no_freedoms(case: str, workshop: Workshop) -> None:
    table, effect = DRIVEN[case]
    text = (FILES / "four-bar.toml").read_text().replace("angular_velocities", "# angular_velocities")
    scene = workshop.scene(f"{text}\n[[drive]]\n{table}\n")
    words = " ".join(show_text(scene, False, False).partition("\n\n")[0].split())
    assert effect in words
    assert "0 = 3 quasi-velocities - rank 2 of the 2 closure rows at the start - 1 driven joint " in words
    assert "0 by Grübler's count: 3 x 3 links - 2 x 4 joints - 1 driven joint " in words
    cut = re.search(r"loops cut at (\w+):", words)
    assert cut is not None and f"branch {cut[1]} - " in words
    with pytest.raises(ValueError, match=r"found drive_0, expected no \[\[drive\]\].* leave out --expand"):
        show_text(scene, False, True)


def test_a_driven_chain_has_fewer_freedoms(workshop: Workshop) -> None:
    scene = workshop.scene(LINKS["hinged"] + '[[drive]]\njoint = "joint_1"\nspeed = 1.0\n')
    words = " ".join(show_text(scene, False, False).partition("\n\n")[0].split())
    assert "degrees of freedom 2 = 3 quasi-velocities - 1 driven joint, no closure" in words


def test_a_driven_slider_is_told_with_its_position(workshop: Workshop) -> None:
    text = (FILES / "slider-crank.toml").read_text()
    text = re.sub(r"(?m)^(slides|angular_velocities) = .*$", "", text)
    scene = workshop.scene(text + '[[drive]]\njoint = "guide"\nposition = "0.6 + 0.1*sin(3*t)"\n')
    words = " ".join(show_text(scene, False, False).partition("\n\n")[0].split())
    assert "drive_0: guide at position 0.6 + 0.1 * sin(3 * t)" in words
    assert "0 = 3 quasi-velocities - rank 2 of the 2 closure rows at the start - 1 driven joint " in words
