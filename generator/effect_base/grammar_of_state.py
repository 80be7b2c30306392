"""Expressions of the time and of where a mechanism is: ``"angle(hip) + 2*rate(ankle)"``. Events and loads have them.

What comes out is a normal form, a text with numbers in place of names of ``[let]``, texts in place of what is asked,
``law('lift')`` in place of a law's name, and ``min`` and ``max`` of two: whoever reads it need not check it again.
"""

from __future__ import annotations

import ast
import copy
import math
import re
import zlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import reduce

from ..mechanism.joints import Joint
from ..mechanism.mechanism import Mechanism
from .arithmetic import (
    DEEPEST,
    EVERY,
    FUNCTIONS,
    HIGHEST,
    KINKED,
    MOST_NAMED,
    RESERVED,
    ExpressionError,
    Names,
    NameWithoutValue,
    parsed,
    value_of,
    wrong_exponent,
)
from .points import find_point
from .table import NameKind

QUANTITIES: Mapping[str, Sequence[NameKind]] = {
    "angle": ("joint",),
    "direction": ("link",),
    "slide": ("joint",),
    "x": ("point",),
    "y": ("point",),
    "distance": ("point", "point"),
}
"""What may be asked of the state, and of what."""
RATE = "rate"
"""How fast such a quantity changes: ``rate(angle(hip))``."""
VELOCITIES = {"vx": "x", "vy": "y"}
"""Rates of a point's coordinates by names of their own."""
LAW = "law"
"""What stands before a law's name in the normal form."""
CLIPS = ("clip", "clamp")
"""Names of what keeps its first argument between the two others."""
FORCES = (
    *("acceleration", "angular_acceleration", "ax", "ay", "force", "torque", "moment", "effort", "reaction", "power"),
    *("normal_force", "friction", "impulse"),
)
"""What somebody may ask for that follows from the loads."""
TOLD = ("fx", "fy")
"""Forces by the names of outputs."""
MEANT = {
    **dict.fromkeys(("angle", "phi", "theta", "direction"), ("angle", "")),
    **dict.fromkeys(("rate", "omega", "w", "angular_velocity", "speed", "velocity"), ("rate", "")),
    **dict.fromkeys(("slide", "position", "s"), ("slide", "")),
    **dict.fromkeys(("slide_rate", "sliding_velocity"), ("slide", "rate")),
}
"""Quantities as outputs and other programs name them behind a point, by what is asked here, and whether its rate."""
JUMPS = ("sign", "sgn", "signum", "step", "heaviside", "floor", "ceil", "round", "mod", "fmod", "int")
"""Functions that others have and that jump."""
WORDS = frozenset((*QUANTITIES, RATE, *VELOCITIES, *KINKED, *CLIPS, *FORCES, *JUMPS))
"""What is called like a function here and in no expression of time."""

SAMPLES = (0.31, -0.47, 0.0083, -0.0021, 5.3, -7.9)
"""Times and states, of no meaning, on both sides of zero, at which a divisor is tried that may be zero always."""
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div)


@dataclass(frozen=True)
class Scope:
    """What an expression may name: numbers by their ``names``, what the ``mechanism`` has, ``laws``, each with names of
    parameters that others may not name, and of a law its ``own`` parameters and ``curves``, its functions of one
    variable. In one of a load (``loads``) nothing may jump."""

    names: Names
    mechanism: Mechanism
    laws: Mapping[str, Collection[str]] = field(default_factory=dict)
    own: Collection[str] | None = None
    curves: Collection[str] = ()
    loads: bool = False


def asks_state(text: str, laws: Collection[str]) -> list[str]:
    """The words of a text, each once, that no expression of time has: quantities of the state, functions with kinks,
    and names of ``laws``. None where the text cannot be read."""
    try:
        nodes = [*ast.walk(parsed(text))]
    except ExpressionError:
        return []
    called = [node.func for node in nodes if isinstance(node, ast.Call)]
    found = [node.id for node in called if isinstance(node, ast.Name) and node.id in WORDS]
    found += [node.id for node in nodes if isinstance(node, ast.Name) and node.id in laws and node not in called]
    return [*dict.fromkeys(found)]


def normal_form(text: str, scope: Scope) -> str:
    """The expression, checked, in normal form.

    Raises ``ExpressionError`` with a sentence, ``NameWithoutValue`` where what is wrong is told elsewhere.
    """
    reader = _Reader(scope)
    tree = reader.read(parsed(text), 0)
    if not reader.moves and not scope.loads:
        raise ExpressionError(f"it has neither t nor a quantity that moves; {_help()}")
    _check_divisors(tree)
    return ast.unparse(tree)


def number_or_form(text: str, scope: Scope) -> float | str:
    """The same of a value that may be a number that stays."""
    reader = _Reader(scope)
    tree = reader.read(parsed(text), 0)
    if reader.moves:
        _check_divisors(tree)
        return ast.unparse(tree)
    try:
        value = value_of(tree, 0.0)
    except (ArithmeticError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ExpressionError("it has no finite value; change it")
    return value


def laws_in(form: str) -> list[str]:
    """The laws that a normal form names, each once."""
    calls = (node for node in ast.walk(ast.parse(form, mode="eval")) if isinstance(node, ast.Call))
    return [*dict.fromkeys(call.args[0].value for call in calls if call.func.id == LAW)]  # type: ignore[attr-defined]


def asked_in(form: str) -> list[str]:
    """What a normal form asks of the state, each once, as a person writes it: ``angle(hip)``, ``rate(slide(rail))``."""
    found: list[str] = []

    def look(node: ast.AST) -> None:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in (*QUANTITIES, RATE):
            found.append(plain(ast.unparse(node)))
            return
        for inner in ast.iter_child_nodes(node):
            look(inner)

    look(ast.parse(form, mode="eval"))
    return [*dict.fromkeys(found)]


def seems_of_state(text: str, names: Names, laws: Collection[str]) -> bool:
    """Whether a text that :func:`asks_state` nothing is best told what is wrong with it as one of the state: it calls a
    law or what follows from the loads, names a part of something, or where there are laws what is not known."""
    try:
        nodes = [*ast.walk(parsed(text))]
    except ExpressionError:
        return False
    called = {node.func.id for node in nodes if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    named = {node.id for node in nodes if isinstance(node, ast.Name)} - called
    parts = any(isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) for node in nodes)
    return parts or bool(called & {*laws, *TOLD}) or bool(laws and named - {*names, *RESERVED})


def free_in(text: str) -> set[str] | None:
    """The names in a text; ``None`` where it cannot be read."""
    try:
        return {node.id for node in ast.walk(parsed(text)) if isinstance(node, ast.Name)}
    except ExpressionError:
        return None


def plain(form: str) -> str:
    """A normal form as a person reads it."""
    return re.sub(rf"\b{LAW}\('(\w+)'\)", r"\1", form).replace("'", "")


def _help() -> str:
    told = [f"{name}({', '.join(of)})" for name, of in QUANTITIES.items()]
    return f"the quantities are t, {', '.join(told)} and rate(...) of one of them"


class _AtSome(ast.NodeTransformer):
    """An expression with numbers in place of what is asked of the state, other ones for each ``sample``."""

    def __init__(self, sample: float) -> None:
        self.sample = sample

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if isinstance(node.func, ast.Name) and node.func.id not in EVERY:
            return self._number(node)
        return ast.Call(node.func, [self.visit(one) for one in node.args], [])

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return node if node.id in ("t", "pi") else self._number(node)

    def _number(self, node: ast.expr) -> ast.Constant:
        return ast.Constant(self.sample * (1.0 + zlib.crc32(ast.unparse(node).encode()) / 2**32))


def _check_divisors(tree: ast.expr) -> None:
    """Raise ``ExpressionError`` where something is divided by what is zero whatever the state is."""
    for sample in SAMPLES:
        try:
            value_of(_AtSome(sample).visit(copy.deepcopy(tree)), sample)
        except ZeroDivisionError:
            continue
        except (ArithmeticError, ValueError):
            pass
        return
    raise ExpressionError("it divides by what is always zero; correct it")


class _Reader:
    """Reads one expression; ``moves``: whether something in it does; ``of_state``: whether something of the state."""

    def __init__(self, scope: Scope) -> None:
        self.scope, self.names, self.mechanism = scope, scope.names, scope.mechanism
        self.moves = self.of_state = False

    def read(self, node: ast.expr, depth: int) -> ast.expr:
        if depth > DEEPEST:
            raise ExpressionError(f"it is nested deeper than {DEEPEST}; write a simpler one")
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return node
            case ast.Name(id=name):
                return self._name(name)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd() as op, operand=operand):
                return ast.UnaryOp(op, self.read(operand, depth + 1))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
                return self._call(name, args, depth)
            case ast.BinOp(left=base, op=ast.Pow(), right=exponent):
                return ast.BinOp(self.read(base, depth + 1), ast.Pow(), self._exponent(base, exponent, depth + 1))
            case ast.BinOp(op=ast.BitXor()):
                raise ExpressionError(f"{_excerpt(node)} has a ^, which is no power here; write ** for ^")
            case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _OPERATORS):
                return ast.BinOp(self.read(left, depth + 1), op, self.read(right, depth + 1))
        raise ExpressionError(f"{_excerpt(node)} is no arithmetic; {self._instead(node)}")

    def _instead(self, node: ast.expr) -> str:
        """What to write for what is no arithmetic."""
        if self.scope.loads and isinstance(node, ast.Compare | ast.BoolOp | ast.IfExp):
            return "write min(...), max(...) or clip(...), or an [[event]] that sets a parameter"
        if isinstance(node, ast.Attribute):
            return self._meant(node)
        if isinstance(node, ast.Compare):
            return "it comes to zero where both sides are equal: write their difference"
        return f"use + - * / **, numbers and functions, and {_help()}"

    def _meant(self, node: ast.Attribute) -> str:
        """What to write for a quantity behind a point, ``rod.angle``, or for a point without one, ``rod.tip``."""
        owner, word = ast.unparse(node.value), node.attr
        links = [link.name for link in self.mechanism.links[: self.mechanism.own_links]]
        if owner in self.scope.laws:
            return self._of_law(owner, word)
        if word in ("x", "y", "vx", "vy") and find_point(owner, self.mechanism)[0] is not None:
            return f"write {word}({owner})"
        if find_point(f"{owner}.{word}", self.mechanism)[0] is not None:
            return f"write x({owner}.{word}) or y({owner}.{word})"
        joint, (asked, rated) = self._joints().get(owner), MEANT.get(word, ("", ""))
        if joint and asked:
            if asked == "rate" and not (joint.turns and joint.slides):
                return f"write rate({owner})"
            quantity = "slide" if asked == "slide" or not joint.turns else "angle"
            return f"write rate({quantity}({owner}))" if rated or asked == "rate" else f"write {quantity}({owner})"
        if owner in links and asked in ("angle", "rate"):
            return f"write rate(direction({owner}))" if asked == "rate" else f"write direction({owner})"
        return f"what is asked stands before its parentheses; {_help()}"

    def _of_law(self, law: str, word: str) -> str:
        """What to write for something of a law."""
        if word in self.scope.laws[law]:
            return f"{word} is a parameter of the law {law}, and stands in its value alone; write that with it there"
        return f"write {law} for what the law gives"

    def _name(self, name: str) -> ast.expr:
        if name == "t":
            self.moves = True
        if name in ("t", "pi"):
            return ast.Name(name, ast.Load())
        own = self.scope.own or ()
        if name in own:
            self.moves = True
            return ast.Name(name, ast.Load())
        if name in self.scope.laws:
            self.moves = self.of_state = True
            return _called(LAW, [ast.Constant(name)])
        if name in (*QUANTITIES, RATE, *VELOCITIES, *FUNCTIONS, *KINKED, *CLIPS, *self.scope.curves):
            raise ExpressionError(f"{name} needs an argument in parentheses; {_help()}")
        if name not in self.names:
            laws = self.scope.laws
            of = [law for law, parameters in laws.items() if name in parameters]
            known = (*self.names, *own, *laws)
            near = get_close_matches(name, known, 1)
            advice = f'write "{near[0]}"' if near else "give it a value in [let], or ask for a quantity of it"
            if of and not near:
                advice = (
                    f"it is a parameter of the law {' and '.join(of)}, and stands in its value alone: write that with"
                )
                advice += " it there, or a [[law]] with one of its own"
            told = "" if self.scope.own is None else f"its parameters are {', '.join(own) or 'none'}; "
            told += f"the laws are {_listed([*laws])}; " if laws and self.scope.own is None else ""
            raise ExpressionError(f"{name} is not known here; {told}{_help()}; {advice}")
        value = self.names[name]
        if value is None:
            raise NameWithoutValue
        number = ast.Constant(abs(float(value)))
        return ast.UnaryOp(ast.USub(), number) if math.copysign(1.0, value) < 0.0 else number

    def _call(self, name: str, args: Sequence[ast.expr], depth: int) -> ast.expr:
        if name in QUANTITIES:
            return self._quantity(name, args)
        if name == RATE:
            return self._rate(args)
        if name in VELOCITIES:
            return _called(RATE, [self._quantity(VELOCITIES[name], args, name)])
        if name in (*KINKED, *CLIPS):
            return self._kinked(name, args, depth)
        if name not in (*FUNCTIONS, *self.scope.curves):
            raise ExpressionError(self._unknown(name))
        wanted = 2 if name == "atan2" else 1
        if len(args) != wanted:
            raise ExpressionError(f"{name}(...) takes {'two arguments' if wanted == 2 else 'one argument'}; correct it")
        before, self.of_state = self.of_state, False
        found = _called(name, [self.read(argument, depth + 1) for argument in args])
        if name in self.scope.curves and not _varies(found.args[0]):
            raise ExpressionError(f"{name}(...) is of a number that stays; write what it is there")
        if name == "atan2" and self.of_state and self.scope.loads:
            raise ExpressionError(
                "atan2(...) of the state jumps by a turn, which no load may; write angle(...) or direction(...), which "
                "count turns, or atan(...)"
            )
        self.of_state |= before
        return found

    def _unknown(self, name: str) -> str:
        """What to say of a function that is not known."""
        if name in self.scope.laws:
            return f"{name} is a law, which is not called; write {name} alone"
        if not self.scope.loads and name in (*FORCES, *TOLD):
            return (
                f"{name}(...) follows from the accelerations, which events do not know; write positions and rates, or "
                "let a joint go at a force by a [[release]]"
            )
        if not self.scope.loads and name in JUMPS:
            return (
                f"{name}(...) jumps, and events come where something passes zero without a jump; write what stands in "
                "it alone, less the number at which it jumps"
            )
        if self.scope.loads and name in (*FORCES, *TOLD):
            return (
                f"{name}(...) follows from the accelerations, and these from all loads, so that the load would hang on "
                "itself; write positions and rates, or the law of that force"
            )
        if self.scope.loads and name in JUMPS:
            return (
                f"{name}(...) jumps, which no load may; write tanh(x/w) with a small width w, or an [[event]] that "
                "sets a parameter"
            )
        known = (*QUANTITIES, RATE, *VELOCITIES, *FUNCTIONS, *KINKED, *CLIPS, *self.scope.curves)
        near = get_close_matches(name, known, 1)
        advice = f"; write {near[0]}(...)" if near else ""
        functions = ", ".join((*FUNCTIONS, *KINKED, CLIPS[0], *self.scope.curves))
        return f"{name}(...) is not known here; {_help()}, functions {functions}{advice}"

    def _kinked(self, name: str, args: Sequence[ast.expr], depth: int) -> ast.expr:
        """The least or the greatest of several, or what is kept between two."""
        found = [self.read(argument, depth + 1) for argument in args]
        if name in KINKED:
            if len(found) < 2:
                raise ExpressionError(f"{name}(...) is of two or more; correct it")
            return reduce(lambda one, other: _called(name, [one, other]), found)
        if len(found) != 3:
            raise ExpressionError(f"{name}(...) takes three arguments, as {name}(x, -1, 1); correct it")
        value, least, most = found
        if not (_varies(least) or _varies(most)) and not value_of(least, 0.0) < value_of(most, 0.0):
            raise ExpressionError(f"{name}(...) has a least that is not below the most; correct it")
        return _called("min", [_called("max", [value, least]), most])

    def _rate(self, args: Sequence[ast.expr]) -> ast.expr:
        joints = self._joints()
        match args:
            case [ast.Call(func=ast.Name(id=inner), args=inside, keywords=[])] if inner in QUANTITIES:
                return _called(RATE, [self._quantity(inner, inside)])
            case [ast.Name(id=name) | ast.Constant(value=str() as name)] if name in joints:
                joint = joints[name]
                if joint.turns and joint.slides:
                    raise ExpressionError(f"{name} turns and slides; write rate(angle({name})) or rate(slide({name}))")
                return _called(RATE, [self._quantity("slide" if joint.slides else "angle", args)])
            case [ast.Name(id=name)] if name in self.scope.laws:
                raise ExpressionError(
                    f"rate({name}) can have accelerations in it, which follow from the loads; write it of the "
                    "quantities that the law has"
                )
        raise ExpressionError(f"rate(...) is of one quantity alone, as rate(angle(...)); {_help()}")

    def _quantity(self, name: str, args: Sequence[ast.expr], written: str = "") -> ast.expr:
        self.moves = self.of_state = True
        kinds = QUANTITIES[name]
        if len(args) != len(kinds):
            wanted = " and ".join(f"a {kind}" for kind in kinds)
            raise ExpressionError(f"{written or name}(...) is of {wanted}; {_help()}")
        found = [self._named(name, kind, argument) for kind, argument in zip(kinds, args, strict=True)]
        return _called(name, [ast.Constant(one) for one in found])

    def _named(self, quantity: str, kind: str, node: ast.expr) -> str:
        """What a name stands for: ``hip``, ``foot.tip``, or in quotes where it reads as something else."""
        match node:
            case ast.Name(id=name) | ast.Constant(value=str() as name):
                given = name
            case ast.Attribute(value=ast.Name(id=owner), attr=point):
                given = f"{owner}.{point}"
            case _:
                raise ExpressionError(f"{quantity}(...) is of a {kind}, and has {_excerpt(node)}; name a {kind}")
        mechanism, joints = self.mechanism, self._joints()
        links = [link.name for link in mechanism.links[: mechanism.own_links]]
        wrong = ""
        if kind == "joint" and given not in joints:
            wrong = f"is no joint; the joints are {', '.join(joints) or 'none'}"
            if given in links and quantity == "angle":
                wrong += f"; write direction({given}) for the angle of that link"
        elif quantity == "angle" and not joints[given].turns:
            wrong = "does not turn; its links keep their angle"
        elif quantity == "slide" and not joints[given].slides:
            wrong = "does not slide; it only turns"
        elif kind == "link" and given not in links:
            wrong = f"is no link that moves; the links are {', '.join(links)}"
            if given in joints and joints[given].turns:
                wrong += f"; write angle({given}) for the angle at that joint"
        elif kind == "point" and find_point(given, mechanism)[0] is None:
            wrong = f"is no point; {find_point(given, mechanism)[1]}"
            if near := _points_like(given, mechanism):
                wrong += f"; write {' or '.join(near)}"
        if wrong:
            raise ExpressionError(f"{given} in {quantity}(...) {wrong}")
        return given

    def _joints(self) -> dict[str, Joint]:
        """Joints that a scene names."""
        every = (*self.mechanism.joints, *self.mechanism.open)
        return {joint.name: joint for joint in every if joint.name not in self.mechanism.hidden_joints}

    def _exponent(self, base: ast.expr, node: ast.expr, depth: int) -> ast.expr:
        own = _Reader(self.scope)
        tree = own.read(node, depth)
        try:
            value = math.nan if own.moves else value_of(tree, 0.0)
        except (ArithmeticError, ValueError):
            value = math.nan
        if not value.is_integer() or abs(value) > HIGHEST:
            raise ExpressionError(wrong_exponent(base, node, value))
        return tree


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more


def _points_like(given: str, mechanism: Mechanism) -> list[str]:
    """Points of links that are called so, or that a link called so has, as ``link.point``."""
    links = mechanism.links[: mechanism.own_links]
    return [f"{link.name}.{point}" for link in links for point in link.points if given in (point, link.name)]


def _varies(tree: ast.expr) -> bool:
    """Whether an expression is anything but numbers and functions of these."""
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return bool(names - {"pi", *FUNCTIONS, *KINKED})


def _called(name: str, args: list[ast.expr]) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), args, [])


def _excerpt(node: ast.expr) -> str:
    text = ast.unparse(node)
    return text if len(text) < 40 else f"{text[:36]}..."
