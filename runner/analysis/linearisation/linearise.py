"""A graph as a linear sampled system: between wires, or around a loop opened at one."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.flatten import inside
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.graphs.model.loops import AUTO, Loop
from proofmass.graphs.model.names import Missing, find_output
from proofmass.runner.analysis.linearisation.find_loops import LoopGroup, find_loops
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
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
    at: At = AUTO,
    minimal: bool = False,
) -> "control.StateSpace":
    """Return the linearised sampled system of a graph as a `control.StateSpace`, exact for signals
    held between ticks.

    `inputs` are outputs of blocks, such as "acceleration.output"; inputs of the system are added to
    their values. `outputs` are the observed signals. With `loop`, the name of a loop or an output
    at which to open one, the system is the open loop L of negative feedback instead: 1 + L = 0 at
    the closed-loop poles. `dt` is the least time after which all blocks between tick together; a
    wire that ticks more often in it has one entry for each of its ticks.

    The operating point is found, unless `at` names it: the graph's state at a time, after a run
    from tick 0, or where its loops have "settled", or "periodic": an orbit that comes back, as that
    of a carrier, found by Newton's method. Quantisers count as gain one, limits as their slope at
    the operating point. States that do not lie between inputs and outputs are left out. With
    `minimal`, so are modes that do not decay and that no input reaches or no output shows: an
    integrator after a difference, the phase of an oscillation. The remaining states are then not
    those of blocks.

    Raises `ModelError` that names the block that cannot be linearised.

    `graph` may have several rates. Inputs and outputs are in the units of their ports.

    >>> from proofmass import linearise, read_graph
    >>> system = linearise(read_graph("library:closed_loop_accelerometer"), loop="main")
    >>> system.nstates, system.ninputs, system.dt
    (5, 1, 2e-05)
    """
    planned = plan(graph)
    points = OperatingPoints(planned, at)
    if loop:
        return to_control(points.loop(one_loop(planned, loop)[1]).map, negated=True, minimal=minimal)
    wires = [[node_of(planned, signal) for signal in signals] for signals in (inputs, outputs)]
    return to_control(points.answered(lambda about: about.map(*wires)).between(), minimal=minimal)


def to_control(period_map: PeriodMap, negated: bool = False, minimal: bool = False) -> "control.StateSpace":
    """Return the map as a StateSpace. Names have colons, since python-control allows no dots: `dac:voltage`."""
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


def loops_of(planned: Plan) -> dict[str, Loop]:
    """Return the loops of a graph: those that it names, else all in its wires; raises `ModelError`
    if there is none.

    Where loops share wires, the fewest outputs that open them all stand for them, each with the
    others closed.
    """
    if planned.graph.loops:
        return dict(planned.graph.loops)
    groups = find_loops(planned)
    if not groups:
        hint = "margins need a loop: wire the output of a controller back to what it controls"
        raise planned.graph.placed(Problem(message="the graph has no loop", hint=hint, path=("wires",))).error
    cuts = [cut for part in groups for cut in (part.open_at[:1] or part.together)]
    if not cuts:
        raise ModelError([planned.graph.placed(_no_cut(part)) for part in groups])
    return {cut: Loop(open_at=cut) for cut in cuts}


def loop_nodes(planned: Plan, loop: str = "") -> dict[str, Endpoint]:
    """Return the outputs at which loops are opened: that of one, or those of all of the graph; raises `ModelError`."""
    if loop:
        return dict([one_loop(planned, loop)])
    return {name: node_of(planned, one.open_at) for name, one in loops_of(planned).items()}


def one_loop(planned: Plan, name: str) -> tuple[str, Endpoint]:
    """Name and output of the loop of a name, or opened at an output."""
    loops = planned.graph.loops
    if name in loops:
        return name, node_of(planned, loops[name].open_at)
    if "." in name:
        return name, node_of(planned, name)
    hint = did_you_mean(name, loops, "the loops") if loops else "name an output instead, as in dac.voltage"
    raise planned.graph.placed(Problem(message="there is no such loop", got=name, hint=hint, path=("loops",))).error


def node_of(planned: Plan, signal: str) -> Endpoint:
    """Block and port of an output that is one number; raises `ModelError`."""
    flat = inside(planned.graph.root, signal)
    found = find_output(planned.graph, flat)
    if isinstance(found, Missing):
        raise Problem(message=found.message, key=signal, hint=found.hint).error
    if not found[1].is_number:
        message = "not an output that is one number"
        raise Problem(message=message, key=signal, hint="choose an output of type float or int").error
    return split(flat)


def is_number(planned: Plan, signal: str) -> bool:
    """Return whether an output of the plan is one number."""
    found = find_output(planned.graph, inside(planned.graph.root, signal))
    return not isinstance(found, Missing) and found[1].is_number


def _no_cut(found: LoopGroup) -> Problem:
    more = len(found.ports) - _NAMED
    some = ", ".join([*found.ports[:_NAMED], *([f"and {more} more"] if more > 0 else [])])
    return Problem(
        message="these loops have no output at which they can be opened",
        key="loops",
        got=some,
        expected="an output in each loop that is one number, sampled or held",
        hint="put a Gain of 1 into the loop, and open it there",
        path=("wires",),
    )
