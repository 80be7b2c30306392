"""The closed form of a scene's equations, and small scenes that are written out in it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy as sp

from ccgen.generator import Scene
from ccgen.generator.derive.expanded import ExpandedForm, expand
from ccgen.generator.equations.equations import Assignment
from ccgen.generator.mechanism.topology import span

LINKS: dict[str, str] = {
    "hinged": 'name = "x"\n[chain]\nlinks = 3\nhinged = true\nlength = [1.0, 0.8, 1.3]\ncom = [0.4, 0.2]\n'
    "[start]\nangles = [-0.9, 0.4, 1.1]\n",
    "loop": 'name = "x"\n[loop]\nlinks = 4\nlength = [1.0, 0.8, 1.3, 1.1]\n',
    "pinned": 'name = "x"\n[pinned]\nlinks = 3\nlength = [1.0, 0.8, 1.3]\n',
}


def put_in(data: dict[Any, Any], named: Iterable[Assignment]) -> None:
    """Add to the numbers of symbols those of named expressions, in which the numbers stand. Symbol by symbol: ``subs``
    looks for each of a hundred of them in turn."""
    data.update({symbol: sp.sympify(value) for symbol, value in data.items()})
    for one in named:
        data[one.symbol] = sp.Float(float(one.expression.xreplace(data)))


def closed_form(scene: Scene) -> ExpandedForm:
    return expand(scene.mechanism, span(scene.mechanism), scene.effects)
