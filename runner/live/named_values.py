"""Named values of a graph as a page changes them: each has a slider, and parameters follow by the same formulas.

Sums, products, quotients, roots and whole powers have the same bits in a browser as in Python. A
value from which a parameter follows by another function, a rate, a duration, an integer or an entry
of a list needs the command line.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from graphlib import TopologicalSorter
from typing import Any

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.graphs.formulas.formula import Formula
from proofmass.graphs.formulas.tree import Apply, Name, Number, Raised, Tree, fixed
from proofmass.graphs.model.digraph import with_following
from proofmass.graphs.model.flatten import inside, parts, values_of
from proofmass.graphs.model.graph import Endpoint, Graph, split
from proofmass.graphs.model.targets import target_at
from proofmass.runner.live.sliders import FixedParameter, Slider, range_of

_SAME_BITS = frozenset(("+", "-", "*", "/", "negative", "sqrt", "abs", "min", "max"))


@dataclass(frozen=True)
class PageFormula:
    """One formula: its target, a value or parameter by path, and the factor of its unit."""

    target: str
    tree: Any  # plain data
    divisor: float
    needs: frozenset[str]
    exact: bool  # to the bit in a browser

    def as_data(self) -> dict[str, Any]:
        """Return plain data, for the page."""
        return {"target": self.target, "tree": self.tree, "divisor": self.divisor}


@dataclass
class NamedValues:
    """Values that a page can change, those that it cannot, and the formulas in the order of their evaluation."""

    sliders: list[Slider] = field(default_factory=list)
    fixed: list[FixedParameter] = field(default_factory=list)
    numbers: dict[str, float] = field(default_factory=dict)
    steps: list[PageFormula] = field(default_factory=list)

    def as_data(self) -> dict[str, Any]:
        """Return plain data, for the page."""
        return {"numbers": self.numbers, "steps": [step.as_data() for step in self.steps]}


def named_values(graph: Graph, moving: Mapping[Endpoint, Slider]) -> NamedValues:
    """Return the named values of a graph and its subgraphs; `moving` are the parameters that the loop takes anew."""
    steps = {step.target: step for path, part in parts(graph) for step in _steps(graph, part, path)}
    order = TopologicalSorter({target: step.needs for target, step in steps.items()}).static_order()
    named, values = NamedValues(steps=[steps[target] for target in order if target in steps]), values_of(graph)
    named.numbers = {key: value.number for key, value in values.items()}
    for key in (key for key in values if key not in steps):
        value, place = values[key], split(key)
        followers = with_following([key], lambda of: [t for t, step in steps.items() if of in step.needs]) - {key}
        movable = all(steps[target].exact and (target in values or split(target) in moving) for target in followers)
        about = "Named value" + (f"; {', '.join(sorted(followers))} follow." if followers else ".")
        if followers and movable:
            facts = *place, value.coherent_unit, about, value.number
            ends = range_of(value.number, None, None, 1.0)
            named.sliders.append(Slider(*facts, *ends, named=True, written=value.written))
        else:
            named.fixed.append(FixedParameter(*place, "", about, value.text(), named=True))
    return named


def _steps(root: Graph, graph: Graph, path: str) -> Iterator[PageFormula]:
    """Yield the formulas of a graph; those around it replace values of a subgraph."""
    for name, value in graph.values.items():
        if value.formula is not None:
            yield _step(graph, path, f"{path}{name}", value.formula, 1.0)
    for target, formula in graph.formulas.items():
        place = inside(root, f"{path}{target}") if "." in target else f"{path}{target}"
        try:
            wanted = target_at(graph, target)
        except Refusal:
            wanted = None
        movable = wanted is not None and not wanted.rate and not wanted.whole and "[" not in target
        divisor = float(unit(wanted.unit).factor) if wanted is not None and movable else 1.0
        yield _step(graph, path, place, formula, divisor, movable)


def _step(graph: Graph, path: str, target: str, formula: Formula, divisor: float, movable: bool = True) -> PageFormula:
    needs = {f"{path}{name}" for name in formula.names if name in graph.values}
    exact = movable and _has_same_bits(formula.tree)
    return PageFormula(target, _plain(formula.tree, graph, path), divisor, frozenset(needs), exact)


def _has_same_bits(tree: Tree) -> bool:
    match tree:
        case Apply(operation, arguments):
            return operation in _SAME_BITS and all(map(_has_same_bits, arguments))
        case Raised(base, _):
            return _has_same_bits(base)
        case Name() | Number():
            return True


def _plain(tree: Tree, graph: Graph, path: str) -> Any:
    """Return a tree as plain data: numbers, names of values by their paths, lists of an operation and its arguments."""
    match tree:
        case Number(value, _):
            return value
        case Name(name):
            return f"{path}{name}" if name in graph.values else fixed(name).value
        case Raised(base, exponent):
            return ["raised", exponent, _plain(base, graph, path)]
        case Apply(operation, arguments):
            return [operation, *(_plain(argument, graph, path) for argument in arguments)]
