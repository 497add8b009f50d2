"""Groups of continuous blocks that are integrated together: their members, and all that is evaluated in them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.checks.schedule import (
    AlgebraicLoop,
    ConstantsOf,
    OutputStep,
    Schedule,
    in_order,
    last_name,
    loop_of,
    outputs_of,
)
from proofmass.graphs.model.digraph import connected, with_following
from proofmass.graphs.model.flatten import FlatGraph, has_own_rate
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.bindings import WireBinding, bindings


@dataclass(frozen=True)
class Group:
    """Continuous blocks that act on each other, and the blocks between them.

    `states` are the fields of the blocks' states, modes included. `nodes` are evaluated at every
    instant, in order: outputs, and the constants of blocks that a signal within the group drives.
    `loops` are solved at every instant. `inputs` are the outputs of other blocks that act on the
    group, held over the tick; those in `ramps` move on a straight line to their next value.
    `events` are those of its blocks, `corners` those of all its members, of which the last
    `counters` count.
    """

    blocks: tuple[str, ...]
    states: tuple[tuple[str, str], ...]
    kinds: tuple[type, ...]  # of the states
    nodes: tuple[OutputStep, ...]
    loops: tuple[AlgebraicLoop, ...]
    inputs: tuple[Endpoint, ...]
    ramps: tuple[Endpoint, ...]
    events: tuple[tuple[str, str], ...]
    corners: tuple[tuple[str, str], ...]
    counters: int

    @property
    def counts(self) -> int:
        """Place of the first counter among events and corners."""
        return self.watched - self.counters

    @property
    def watched(self) -> int:
        """Number of events and corners at which steps end."""
        return len(self.events) + len(self.corners)

    @property
    def members(self) -> tuple[str, ...]:
        """All blocks whose functions the group calls, in the order of their names."""
        return tuple(sorted({*self.blocks, *(node[0] for node in self.nodes)}))

    @property
    def guesses(self) -> tuple[Endpoint, ...]:
        """Outputs whose values at the start of the tick are the initial guesses for the loops."""
        return tuple(tear for loop in self.loops for tear in loop.tears)


def find_groups(graph: FlatGraph, schedule: Schedule) -> tuple[Group, ...]:
    """All groups of a flat graph, in alphabetical order."""
    wiring = _Wiring(graph, schedule)
    continuous = [name for name, block in graph.blocks.items() if type(block).continuous()]
    joined: list[tuple[str, str]] = []
    for name in continuous:
        reached = {node[0] for node in wiring.needed([name]) if node in wiring.moving}
        joined += ((name, other) for other in reached if type(graph.blocks[other]).continuous())
    members = sorted(tuple(sorted(part, key=last_name)) for part in connected(continuous, joined))
    return tuple(_group(graph, schedule, wiring, blocks) for blocks in members)


def sources(graph: FlatGraph, schedule: Schedule) -> tuple[Endpoint, ...]:
    """Outputs that follow from the time alone, in order: the next value is known a tick ahead."""
    sources: dict[Endpoint, None] = {}
    for node in outputs_of(schedule.order):
        follows = analogue(graph, node[0]) and schedule.divisors[node[0]] == 1
        if follows and all(before in sources for before in _needs(graph, schedule, node)):
            sources[node] = None
    return tuple(sources)


def moving(graph: FlatGraph, schedule: Schedule) -> frozenset[Endpoint]:
    """Return the outputs that move between ticks; all others hold their value until the next one."""
    ramps = sources(graph, schedule) if graph.integration.sources == "first_order_hold" else ()
    return frozenset({*outputs_of(_Wiring(graph, schedule).moving), *ramps})


def ahead(graph: FlatGraph, schedule: Schedule, groups: Iterable[Group]) -> tuple[Endpoint, ...]:
    """Outputs of sources from which ramps follow, in order: they are known one tick ahead."""
    ramps: list[OutputStep] = [node for group in groups for node in group.ramps]
    needed = with_following(ramps, lambda node: _needs(graph, schedule, node))
    return tuple(node for node in outputs_of(schedule.order) if node in needed)


class _Wiring:
    """Finds the outputs that move between ticks, and those that the derivatives of a block need."""

    def __init__(self, graph: FlatGraph, schedule: Schedule) -> None:
        self.graph, self.schedule = graph, schedule
        free = set(sources(graph, schedule)) if graph.integration.sources == "continuous" else set[Endpoint]()
        able = {name for name, block in graph.blocks.items() if type(block).continuous() or analogue(graph, name)}
        follow: dict[OutputStep, list[OutputStep]] = {}  # outputs that move with a node
        for node in schedule.order:
            if node[0] in able:
                for before in _needs(graph, schedule, node):
                    follow.setdefault(before, []).append(node)
        moved = (node for node in outputs_of(schedule.order) if type(graph.blocks[node[0]]).continuous())
        first: list[OutputStep] = [*free, *moved]
        self.moving = with_following(first, lambda node: follow.get(node, ()))

    def needed(self, blocks: Iterable[str]) -> set[OutputStep]:
        """Nodes on which derivatives and events of blocks depend in an instant, and the inputs."""
        own = [node for name in blocks for node in self._of_block(name)]
        return with_following(own, lambda n: _needs(self.graph, self.schedule, n) if n in self.moving else ())

    def _of_block(self, name: str) -> Iterator[OutputStep]:
        block = self.graph.blocks[name]
        kind = type(block)
        behaviours = [kind.functions["derivative"]] if "derivative" in kind.functions else []
        behaviours += [behaviour for pair in kind.events.values() for behaviour in pair]
        for behaviour in behaviours:
            yield from _wires(self.schedule, block, name, behaviour)
        if ConstantsOf(name) in self.moving:
            yield ConstantsOf(name)


def _group(graph: FlatGraph, schedule: Schedule, wiring: _Wiring, blocks: tuple[str, ...]) -> Group:
    fields = [(name, *item) for name in blocks for item in state_fields(graph.blocks[name])]
    needed = wiring.needed(blocks)
    outside = (node for node in outputs_of(needed) if node not in wiring.moving)
    inputs = sorted(outside, key=lambda node: (last_name(node[0]), node[1]))
    inside = [node for node in schedule.order if node in needed and node in wiring.moving]
    needs = {node: _needs(graph, schedule, node) for node in inside}
    nodes, cycles = in_order({node: [n for n in befores if n in needs] for node, befores in needs.items()})
    moving = dict.fromkeys(name for name, _ in outputs_of(nodes))
    corners = [(name, corner) for name in moving for corner in type(graph.blocks[name]).corners]
    corners = [corner for corner in corners if _is_known(graph.blocks[corner[0]], schedule, *corner, needed)]
    counters = [(name, corner) for name, corner in corners if type(graph.blocks[name]).corners[corner].returns is int]
    ahead = sources(graph, schedule) if graph.integration.sources == "first_order_hold" else ()
    return Group(
        blocks=blocks,
        states=tuple((name, field) for name, field, _ in fields),
        kinds=tuple(kind for _, _, kind in fields),
        nodes=nodes,
        loops=tuple(map(loop_of, cycles)),
        inputs=tuple(inputs),
        ramps=tuple(node for node in inputs if node in ahead),
        events=tuple((name, event) for name in blocks for event in type(graph.blocks[name]).events),
        corners=(*(corner for corner in corners if corner not in counters), *counters),
        counters=len(counters),
    )


def _is_known(block: Block, schedule: Schedule, name: str, corner: str, known: set[OutputStep]) -> bool:
    """Return whether the group knows all that a corner reads."""
    return known.issuperset(_wires(schedule, block, name, type(block).corners[corner]))


def _wires(schedule: Schedule, block: Block, name: str, behaviour: Behaviour) -> list[Endpoint]:
    """Outputs that a function of a block reads."""
    given = bindings(schedule, block, name, "", behaviour)
    return [binding.node for binding in given if isinstance(binding, WireBinding)]


def state_fields(block: Block) -> list[tuple[str, type]]:
    """Fields of a block's state with their types."""
    made = type(block).state_class()
    return [] if made is None else list(made.__annotations__.items())


def _needs(graph: FlatGraph, schedule: Schedule, step: OutputStep) -> list[OutputStep]:
    """Nodes on which an output, or the constants of a block, depend within an instant."""
    name, block, drivers = step[0], graph.blocks[step[0]], schedule.drivers
    driven: list[OutputStep] = [drivers[name, p] for p in type(block).parameters if (name, p) in drivers]
    if isinstance(step, ConstantsOf):
        return driven
    fed: list[OutputStep] = [drivers[name, i] for i in type(block).feedthrough(step[1]) if (name, i) in drivers]
    return [*fed, ConstantsOf(name)] if driven and type(block).output_functions[step[1]].reads_constants else fed


def analogue(graph: FlatGraph, name: str) -> bool:
    """Return whether a block has no memory, only numbers, and follows its inputs at every instant.

    Blocks with codes or bits (converters), with a state, or with a rate of their own work at ticks.
    """
    kind = type(graph.blocks[name])
    ports = [*kind.inputs.values(), *kind.outputs.values()]
    meanings = {meaning for behaviour in kind.output_functions.values() for meaning in behaviour.meanings}
    return (
        not kind.continuous()
        and kind.state_class() is None
        and not kind.buffers
        and all(port.dtype is float and not port.shape and port.every == 1 for port in ports)
        and meanings.isdisjoint({Meaning.TICK, Meaning.DEVIATE})
        and not has_own_rate(graph, name)
    )
