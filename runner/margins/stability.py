"""The margins of a graph's loops, and whether they are what the graph asks for."""

import math
from collections.abc import Iterator
from fractions import Fraction

from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.graph import Graph
from proofmass.graphs.loops import REQUIREMENTS, Loop
from proofmass.runner.engine.plan import plan
from proofmass.runner.engine.planned import Plan
from proofmass.runner.margins.linearise import loops_of, node_of, one_loop, open_loop, tick_at
from proofmass.runner.margins.margins import Margins, decibels, margins_of


def margins(graph: Graph, loop: str = "", *, at: str | float | Fraction = 0.0) -> Margins:
    """The margins of one loop: by its name, by an output at which it is opened, or the only one that there is.

    The graph is linearised at the time `at`, or where its loops have "settled". Raises `ModelError` where the loop
    cannot be told or linearised.
    """
    planned = plan(graph)
    found = all_margins(graph, planned, loop, at)
    if len(found) > 1:
        expected, hint = "the name of one", f'margins(graph, "{next(iter(found))}")'
        message, got = "the graph has several loops", ", ".join(found)
        raise ModelError(
            [planned.graph.placed(Problem(message=message, key="loops", got=got, expected=expected, hint=hint))]
        )
    return next(iter(found.values()))


def all_margins(graph: Graph, planned: Plan, loop: str = "", at: str | float | Fraction = 0.0) -> dict[str, Margins]:
    """The margins of every loop by name, or of the one that is wanted."""
    tick = tick_at(planned, at)
    if loop:
        name, node = one_loop(planned, graph, loop)
        nodes = {name: node}
    else:
        nodes = {name: node_of(planned, graph, made.open_at) for name, made in loops_of(planned).items()}
    return {name: margins_of(open_loop(planned, node, tick), name, ".".join(node)) for name, node in nodes.items()}


def missed(planned: Plan, found: dict[str, Margins]) -> list[Problem]:
    """A problem for each margin that is not what its loop asks for."""
    loops = {name: planned.graph.loops[name] for name in found if name in planned.graph.loops}
    problems = [problem for name, loop in loops.items() for problem in _missed(name, loop, found[name])]
    return [planned.graph.placed(problem) for problem in problems]


def _missed(name: str, loop: Loop, got: Margins) -> Iterator[Problem]:
    for key, wanted in loop.requirements.items():
        value, unit = attained(got, key), REQUIREMENTS[key]
        peak = key == "sensitivity_peak"
        if got.stable and (value <= wanted if peak else value >= wanted):
            continue
        pole = abs(got.poles[0])
        yield Problem(
            message=f"the {key.replace('_', ' ')} of the loop is not kept" if got.stable else "the loop is unstable",
            key=f"loops.{name}.{key}",
            got=f"{value:.4g} {unit}" if got.stable else f"a closed-loop pole of size {pole:.6g}",
            expected=f"at {'most' if peak else 'least'} {wanted:g} {unit}",
            hint=f"proofmass margins shows what limits it; it is opened at {got.open_at}",
            path=("loops", name, key),
        )
        if not got.stable:
            return


def attained(got: Margins, key: str) -> float:
    """A margin of a stable loop by the name and in the unit of its requirement; without limit it is infinite."""
    if key == "gain_margin":
        limits = [got.gain_margin, got.gain_reduction]
        return min((abs(decibels(limit) or 0.0) for limit in limits if limit is not None), default=math.inf)
    if key == "sensitivity_peak":
        return decibels(got.sensitivity_peak) or 0.0
    value = got.phase_margin if key == "phase_margin" else got.delay_margin
    return math.inf if value is None else math.degrees(value) if key == "phase_margin" else value
