"""A graph as a linear sampled system: between two wires, or around a loop that is opened at a wire."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.flatten import inside
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.graphs.model.loops import SETTLED, Loop
from proofmass.graphs.model.names import Missing, find_output
from proofmass.graphs.model.rates import read_duration
from proofmass.runner.analysis.linearisation.analog_loop import analog_group, analog_map
from proofmass.runner.analysis.linearisation.coarse import coarse_blocks
from proofmass.runner.analysis.linearisation.find_loops import LoopGroup, find_loops
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.map_changes import variation
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.orbit import map_at
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.periodic import PERIODIC, PeriodicPoint, Point, periodic_point
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

if TYPE_CHECKING:
    import control

_NAMED = 12  # outputs in a message


def linearise(
    graph: GraphSource,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    *,
    loop: str = "",
    at: str | float | Fraction = 0.0,
    minimal: bool = False,
) -> "control.StateSpace":
    """Return the linearised sampled system of a graph as a `control.StateSpace`, exact for signals held between ticks.

    `inputs` are outputs of blocks, such as "acceleration.output"; inputs of the system are added to their values.
    `outputs` are the observed signals. With `loop`, the name of a loop or an output at which to open one, the system
    is the open loop L of negative feedback instead: 1 + L = 0 at the closed-loop poles. `dt` is the least time after
    which all blocks between tick together; a wire that ticks more often in it has one entry for each of its ticks.

    The operating point is the graph's state at time `at`, after a run from tick 0, or where its loops have "settled",
    or "periodic": an orbit that comes back, as that of a carrier, found by Newton's method.
    Quantisers count as gain one, limits as their slope at the operating point. States that do not lie between inputs
    and outputs are left out. With `minimal`, so are modes that do not decay and that no input reaches or no output
    shows: an integrator after a difference, the phase of an oscillation. The remaining states are then not those of
    blocks.

    Raises `ModelError` that names the block that cannot be linearised.

    `graph` may have several rates. Inputs and outputs are in the units of their ports.

    >>> from proofmass import linearise, read_graph
    >>> system = linearise(read_graph("library:closed_loop_accelerometer"), loop="main")
    >>> system.nstates, system.ninputs, system.dt
    (5, 1, 2e-05)
    """
    planned = plan(graph)
    if loop:
        _, node = one_loop(planned, loop)
        return to_control(open_loop(planned, node, tick_at(planned, at)).map, negated=True, minimal=minimal)
    wires = [[node_of(planned, signal) for signal in signals] for signals in (inputs, outputs)]
    return to_control(map_at(planned, *wires, tick=tick_at(planned, at)).between(), minimal=minimal)


def to_control(period_map: PeriodMap, negated: bool = False, minimal: bool = False) -> "control.StateSpace":
    """Return the map as a StateSpace. Names have colons, since python-control allows no dots: `dac:voltage`."""
    need("control")
    # start-up time: control takes 0.9 s
    import control

    states, inputs, outputs = (
        [name.replace(".", ":") for name in period_map.names(ends)]
        for ends in (period_map.states, period_map.inputs, period_map.outputs)
    )

    a, b, c, d = period_map.parts()
    if minimal and period_map.period:
        lasting = Lasting(a)
        if not lasting.passes(b, c):
            a, b, c = lasting.without(a, b, c)
            states = states if len(a) == period_map.order else []
    sign = -1.0 if negated else 1.0
    return control.StateSpace(
        a,
        b,
        sign * c,
        sign * d,
        period_map.period,
        states=states or None,
        inputs=inputs,
        outputs=[f"{name} back" for name in outputs] if negated else outputs,
        remove_useless_states=False,
    )


def open_loop(planned: Plan, node: Endpoint, tick: Point = 0, by_parameters: bool = False) -> OpenLoop:
    """Return the loop through an output, opened there; in continuous time if it lies among continuous blocks."""
    group = analog_group(planned, node)
    if group is not None:
        if isinstance(tick, PeriodicPoint):
            raise ModelError([planned.graph.placed(_not_periodic(node))])
        analog = analog_map(planned, group, node, tick).between()
        if not any(part.any() for part in (analog.parts()[1], analog.parts()[3])):
            raise ModelError([planned.graph.placed(_not_within(planned, group, node))])
        return OpenLoop(analog, continuous=True)
    whole = map_at(planned, [node], [node], cut=True, by_parameters=by_parameters, tick=tick)
    system = of_wires(whole, planned.period, coarse_blocks(planned, node))
    if not any(part.any() for part in (system.map.parts()[1], system.map.parts()[3])):
        signal = ".".join(node)
        problem = Problem(
            message=f"what goes in at {signal} does not come back",
            key=signal,
            expected="a loop in which every block passes small changes on",
            hint="a limit may be reached there, or a signal only compared; try another time with --at",
            path=("blocks", node[0]),
        )
        raise ModelError([planned.graph.placed(problem)])
    return system


def of_wires(whole: PeriodMap, tick: float, notes: Sequence[str] = ()) -> OpenLoop:
    """Return the sampled loop of a map that is cut at one or more wires, and by how much its closed loop changes.

    `tick` is the time of a base tick in seconds.
    """
    between = whole.between()
    between = replace(between, later=(), notes=(*between.notes, *notes))
    ticks = round(between.period / tick)
    if not whole.later or any(later.states != whole.states for later in whole.later):
        return OpenLoop(between, ticks=ticks)
    kept = [whole.states.index(state) for state in between.states]
    closed, *after = (
        np.real(OpenLoop(one).closed()) for one in (between, *(later.kept(kept) for later in whole.later))
    )
    return OpenLoop(between, variation=variation(closed, after), ticks=ticks)


def loops_of(planned: Plan) -> dict[str, Loop]:
    """Return the loops of a graph: those that it names, else all in its wires; raises `ModelError` if these cross."""
    if planned.graph.loops:
        return dict(planned.graph.loops)
    groups = find_loops(planned)
    problems = [_crossing(part) for part in groups if not part.open_at]
    if not groups:
        hint = "margins need a loop: wire the output of a controller back to what it controls"
        problems = [Problem(message="the graph has no loop", key="wires", hint=hint, path=("wires",))]
    if problems:
        raise ModelError([planned.graph.placed(problem) for problem in problems])
    return {part.open_at[0]: Loop(open_at=part.open_at[0]) for part in groups}


def one_loop(planned: Plan, name: str) -> tuple[str, Endpoint]:
    """Name and output of the loop of a name, or opened at an output."""
    loops = planned.graph.loops
    if name in loops:
        return name, node_of(planned, loops[name].open_at)
    if "." in name:
        return name, node_of(planned, name)
    hint = did_you_mean(name, loops, "the loops") if loops else "name an output instead, as in dac.voltage"
    problem = Problem(message="there is no such loop", key="loops", got=name, hint=hint, path=("loops",))
    raise ModelError([planned.graph.placed(problem)])


def node_of(planned: Plan, signal: str) -> Endpoint:
    """Block and port of an output that is one number; raises `ModelError`."""
    flat = inside(planned.graph.root, signal)
    found = find_output(planned.graph, flat)
    if isinstance(found, Missing):
        raise ModelError([Problem(message=found.message, key=signal, hint=found.hint)])
    if found[1].shape or found[1].dtype is bool:
        message = "not an output that is one number"
        raise ModelError([Problem(message=message, key=signal, hint="choose an output of type float or int")])
    return split(flat)


def tick_at(planned: Plan, at: str | float | Fraction) -> Point:
    """The base tick of a time, or of the rest of the loops, or an orbit that closes."""
    if at in (SETTLED, PERIODIC):
        if _Latest.plan is not planned or _Latest.at != at:
            point = settled_tick(planned.without_noise) if at == SETTLED else periodic_point(planned)
            _Latest.plan, _Latest.at, _Latest.point = planned, at, point
        return _Latest.point
    try:
        return int(read_duration(at) * planned.schedule.base_rate)
    except Refusal as error:
        raise ModelError(
            [
                Problem(
                    message=str(error),
                    key="at",
                    got=str(at),
                    hint=f'write a time, as "20 ms", "{PERIODIC}" or "{SETTLED}"',
                )
            ]
        ) from None


class _Latest:
    """The last point that was looked for, since each loop and each output of a plan asks for it."""

    plan: Plan | None = None
    at: str | float | Fraction = ""
    point: Point = 0


def _crossing(found: LoopGroup) -> Problem:
    """Loops that share wires: which one is meant must be said."""
    first, more = found.ports[0], len(found.ports) - _NAMED
    some = ", ".join([*found.ports[:_NAMED], *([f"and {more} more"] if more > 0 else [])])
    return Problem(
        message="loops share wires here, and no wire opens them all",
        key="loops",
        got=some,
        expected="one output for each loop to analyse; the other loops stay closed",
        hint=f'add [loops.NAME] with open_at = "{first}", or say --loop {first}',
        path=("wires",),
    )


def _not_periodic(node: Endpoint) -> Problem:
    signal = ".".join(node)
    return Problem(
        message=f"a loop among continuous blocks is opened at {signal}: about a periodic orbit it has no margins",
        key=signal,
        expected="an output that is sampled or held",
        hint="open the loop at a discrete block, or name a time with --at",
        path=("blocks", node[0]),
    )


def _not_within(planned: Plan, group: Group, node: Endpoint) -> Problem:
    """Between continuous blocks signals are not held: no sampled loop can be cut there."""
    signal = ".".join(node)
    wires = planned.schedule.drivers.items()
    readers = [f"{name}.{entry}" for (name, entry), source in wires if source == node and name in group.members]
    cuts = [cut for part in find_loops(planned) if signal in part.ports for cut in part.open_at]
    return Problem(
        message=f"no loop among continuous blocks goes through {signal}, and between them nothing is sampled",
        key=signal,
        got=", ".join(sorted(readers)),
        expected="an output whose values are sampled or held",
        hint=f"open the loop at {' or '.join(cuts[:3])}" if cuts else "open the loop at a discrete block",
        path=("blocks", node[0]),
    )
