"""The margins of a graph's loops, and whether they are what the graph asks for."""

import math
from collections.abc import Iterator

from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, REQUIREMENTS, Loop
from proofmass.runner.analysis.decisions.one_bit import loop_through_bits
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints, Otherwise
from proofmass.runner.analysis.linearisation.linearise import loop_nodes
from proofmass.runner.analysis.linearisation.map_blocks import coarse_blocks
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import Pole
from proofmass.runner.analysis.margins.margins import Margins, margins_of, with_rounding
from proofmass.runner.analysis.margins.over_phases import OverPhases
from proofmass.runner.analysis.margins.text import BUT_ROUNDING, but_rounding
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

AT_ANOTHER_PHASE = "at another phase of what oscillates"


@named_arguments
def margins(graph: GraphSource, loop: str = "", *, at: At = AUTO) -> Margins:
    """The margins of one loop: by its name, by an output at which it is opened, or the only one that there is.

    The operating point is found, unless `at` names it: a time, "settled" or "periodic".
    Raises `ModelError` where the loop cannot be told or linearised.

    `graph` needs a control loop, and `loop` names one. Gains are factors, phases radians, times
    seconds, frequencies Hz.

    >>> from proofmass import margins, read_graph
    >>> found = margins(read_graph("library:closed_loop_accelerometer"), "main")
    >>> found.verdict, round(found.gain_margin, 2), round(found.phase_margin, 3)
    ('stable', 37.87, 1.586)
    """
    planned = plan(graph)
    loops = all_margins(planned, loop, at)
    if len(loops) > 1:
        expected, hint = "the name of one", f'margins(graph, "{next(iter(loops))}")'
        message, got = "the graph has several loops", ", ".join(loops)
        raise planned.graph.placed(Problem(message=message, key="loops", got=got, expected=expected, hint=hint)).error
    return next(iter(loops.values()))


def all_margins(planned: Plan, loop: str = "", at: At = AUTO) -> dict[str, Margins]:
    """The margins of every loop by name, or of the one that is wanted; raises `ModelError` if one has none."""
    answers = margins_or_reasons(OperatingPoints(planned, at), loop, over=True)
    problems = [problem for answer in answers.values() if isinstance(answer, ModelError) for problem in answer.problems]
    if problems:
        raise ModelError(problems)
    return {name: answer for name, answer in answers.items() if isinstance(answer, Margins)}


def margins_or_reasons(points: OperatingPoints, loop: str = "", over: bool = False) -> dict[str, Margins | ModelError]:
    """Return the margins of every loop by name, or the one wanted; or why a loop has none.

    They have notes on their ranges `over` the phase of an oscillation if so wanted.
    """
    nodes, phases = loop_nodes(points.plan, loop), OverPhases(points)
    answers = dict[str, Margins | ModelError]()
    points.course.loops = tuple(nodes.values())
    for name, node in nodes.items():
        try:
            found = with_rounding(margins_of(open_loop(points, node), name, ".".join(node)))
            answers[name] = phases.noted(found, node) if over else found
        except ModelError as error:
            answers[name] = error
    return answers


def open_loop(points: OperatingPoints, node: Endpoint, by_parameters: bool = False) -> OpenLoop:
    """Return the loop through an output; with the gains of quantisers of one bit in a run if there is no other."""
    return points.loop(node, by_parameters, through_bits(points.plan, node))


def through_bits(plan: Plan, node: Endpoint) -> Otherwise | None:
    """Return what linearises a loop through quantisers of one bit, where there are any."""
    return loop_through_bits if coarse_blocks(plan, node) else None


def missed(planned: Plan, found: dict[str, Margins]) -> list[Problem]:
    """A problem for each margin that is not what its loop asks for."""
    loops = {name: planned.graph.loops[name] for name in found if name in planned.graph.loops}
    problems = [problem for name, loop in loops.items() for problem in _missed(name, loop, found[name])]
    return [planned.graph.placed(problem) for problem in problems]


def _missed(name: str, loop: Loop, margins: Margins) -> Iterator[Problem]:
    for key, limit in loop.requirements.items():
        path = ("loops", name, key)
        if not margins.stable:
            yield Problem(
                message=f"the loop is {margins.verdict}",
                key=f"loops.{name}.{key}",
                got=_slowest(margins.slowest[0], not margins.system.continuous),
                expected="a stable loop",
                hint=_way_back(margins),
                path=path,
            )
            return
        value, unit = margins.attained(key), REQUIREMENTS[key]
        peak = key == "sensitivity_peak"
        if value <= limit if peak else value >= limit:
            continue
        yield Problem(
            message=f"the {key.replace('_', ' ')} of the loop is not kept",
            key=f"loops.{name}.{key}",
            got=f"{value:.4g} {unit}" + _where(margins, key),
            expected=f"at {'most' if peak else 'least'} {limit:g} {unit}",
            hint=f"proofmass margins shows what limits it; it is opened at {margins.open_at}",
            path=path,
        )


def _where(margins: Margins, key: str) -> str:
    """Return where else the worst of a figure is, nothing where it is that of the margins."""
    if margins.attained(key) == margins.value(key):
        return ""
    return ", at another instant ahead" if margins.system.map.others else f", {AT_ANOTHER_PHASE}"


def _slowest(pole: Pole, sampled: bool) -> str:
    """The pole that decides: its size, or its distance from the boundary where the size would not show it."""
    if pole.verdict == "marginal":
        return f"a closed-loop pole on the boundary of stability{BUT_ROUNDING}: {pole.uncertainty:.1g}"
    if not sampled:
        return f"a closed-loop pole at {pole.value:.6g} 1/s"
    if abs(pole.distance) < 1e-5:
        return f"a closed-loop pole {-pole.distance:.3g} outside the unit circle"
    return f"a closed-loop pole of size {abs(pole.value):.6g}"


def _way_back(margins: Margins) -> str:
    """Return how a loop that is not stable could become stable."""
    if not margins.stable_gains:
        none = f"no factor at {margins.open_at} makes it stable{but_rounding(margins)}"
        return f"{none}; proofmass margins shows its poles and crossovers"
    low, high = margins.stable_gains[-1]
    limits = f"above {low:.4g}" if math.isinf(high) else f"between {low:.4g} and {high:.4g}"
    return f"a factor {limits} at {margins.open_at} makes it stable"
