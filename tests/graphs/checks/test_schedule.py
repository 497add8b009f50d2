"""The order of a tick: loops without delay found and named, nothing refused that has none, always the same order."""

import ast
import dataclasses
import inspect
import random
import textwrap
from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import pytest

from proofmass.blocks import (
    Constant,
    Gain,
    MassSpringDamper,
    Sum,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.schedule import ConstantsOf, Schedule, outputs_of
from proofmass.graphs.checks.schedule import schedule as schedule_flat
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Endpoint, split
from tests.by_hand.graph_texts import ALONE


def schedule(graph: Graph) -> Schedule:
    return schedule_flat(flatten(graph))


class TwoWays(Block):
    """One output that its first input reaches at once, one that nothing reaches at once."""

    first = Input("1", "Reaches `direct`.")
    second = Input("1", "Reaches nothing within the tick.")


class State(NamedTuple):
    value: float


@TwoWays.output("1")
def direct(p: Any, x: State, first: float) -> float:
    """The first input and the state."""
    return first + x.value


@TwoWays.output("1")
def kept(p: Any, x: State) -> float:
    """The state."""
    return x.value


@TwoWays.update
def update(p: Any, x: State, first: float, second: float) -> State:
    return State(second)


KINDS: tuple[type[Block], ...] = (Gain, Sum, UnitDelay, TwoWays, Constant)
DRIVEN = {Gain: "gain", Constant: "value"}


def random_graph(seed: int) -> Graph:
    draw = random.Random(seed)
    blocks = {f"b{n}": draw.choice(KINDS)() for n in range(draw.randint(2, 9))}
    outputs = [f"{name}.{port}" for name, block in blocks.items() for port in type(block).outputs]
    wires = []
    for name, block in blocks.items():
        wires += [
            f"{draw.choice(outputs)} -> {name}.{port}"
            for port, declared in type(block).inputs.items()
            if declared.default is None or draw.random() < 0.2
        ]
        parameter = DRIVEN.get(type(block))
        if parameter and draw.random() < 0.3:
            wires.append(f"{draw.choice(outputs)} -> {name}.{parameter}")
    draw.shuffle(wires)
    return Graph(name=str(seed), rate=1000, blocks=blocks, wires=wires)


def reads_parameters(function: Callable[..., Any]) -> bool:
    """Whether a function names its first argument, the constants or parameters, in its body."""
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(definition, ast.FunctionDef)
    names = {node.id for statement in definition.body for node in ast.walk(statement) if isinstance(node, ast.Name)}
    return definition.args.args[0].arg in names


def within_a_tick(graph: Graph) -> set[tuple[Endpoint, Endpoint]]:
    """Pairs of outputs, the second of which needs the first within the same tick: from the definition alone."""
    pairs = set()
    for wire in graph.wires:
        (name, port), block = split(wire.target), graph.blocks[split(wire.target)[0]]
        for output, behaviour in type(block).output_functions.items():
            if port in behaviour.arguments or (port in type(block).parameters and reads_parameters(behaviour.function)):
                pairs.add((split(wire.source), (name, output)))
    return pairs


def has_loop(pairs: set[tuple[Endpoint, Endpoint]]) -> bool:
    """Brute force: whether following the pairs from any node comes back to it."""
    after: dict[Endpoint, set[Endpoint]] = {}
    for node, following in pairs:
        after.setdefault(node, set()).add(following)
    for first in after:
        reached: set[Endpoint] = set()
        ahead = {first}
        while ahead:
            reached |= ahead
            ahead = {following for node in ahead for following in after.get(node, ())}
            if first in ahead:
                return True
            ahead -= reached
    return False


def named_wires(error: ModelError) -> list[str]:
    (problem,) = error.problems
    return problem.got.split(", ")


@pytest.mark.exhaustive(but=8)
@pytest.mark.parametrize("first", range(0, 1000, 50))
def test_random_graphs_have_a_loop_when_brute_force_finds_one(first: int) -> None:
    loops = 0
    for seed in range(first, first + 50):
        graph = random_graph(seed)
        pairs = within_a_tick(graph)
        try:
            order = schedule(graph).order
        except ModelError as error:
            loops += 1
            assert has_loop(pairs), f"seed {seed}: a loop that is none"
            assert_closed(graph, named_wires(error))
        else:
            assert not has_loop(pairs), f"seed {seed}: a loop that was missed"
            at = {node: index for index, node in enumerate(order)}
            assert all(at[before] < at[after] for before, after in pairs)
            assert set(outputs_of(order)) == {(n, o) for n, b in graph.blocks.items() for o in type(b).outputs}
    assert 10 < loops < 45


def assert_closed(graph: Graph, wires: list[str]) -> None:
    """Every named wire is one of the graph, leads on within the tick, and the last leads to the first."""
    assert set(wires) <= {str(wire) for wire in graph.wires}
    pairs = within_a_tick(graph)
    for wire, following in zip(wires, [*wires[1:], wires[0]], strict=True):
        source, target = wire.split(" -> ")
        after = split(following.split(" -> ")[0])
        assert after[0] == split(target)[0]
        assert (split(source), after) in pairs


@pytest.mark.parametrize("seed", range(40))
def test_the_order_is_the_alphabetically_first_one(seed: int) -> None:
    graph = random_graph(seed)
    try:
        order = schedule(graph).order
    except ModelError:
        return
    needs: dict[Endpoint, set[Endpoint]] = {
        (n, port): set() for n, block in graph.blocks.items() for port in type(block).outputs
    }
    for wire in graph.wires:
        source, (name, port) = split(wire.source), split(wire.target)
        block = graph.blocks[name]
        if port in type(block).parameters:
            needs.setdefault(ConstantsOf(name), set()).add(source)
            for output in type(block).outputs:
                needs[name, output].add(ConstantsOf(name))
        for output in type(block).outputs:
            if port in type(block).feedthrough(output):
                needs[name, output].add(source)
    expected: list[Endpoint] = []
    while len(expected) < len(needs):
        expected.append(min(node for node in needs if node not in expected and needs[node] <= set(expected)))
    assert order == tuple(expected)


@pytest.mark.parametrize("seed", range(20))
def test_the_order_of_declaration_changes_nothing(seed: int) -> None:
    graph, draw = random_graph(seed), random.Random(seed)
    blocks, wires = list(graph.blocks.items()), list(graph.wires)
    draw.shuffle(blocks)
    draw.shuffle(wires)
    other = Graph(name=graph.name, rate=1000, blocks=dict(blocks), wires=wires)
    assert outcome(other) == outcome(graph)


def outcome(graph: Graph) -> object:
    try:
        scheduled = schedule(graph)
    except ModelError as error:
        return str(error)
    return scheduled.order, list(scheduled.divisors.items()), scheduled.base_rate


def test_blocks_wired_crosswise_have_no_loop_when_no_port_reaches_itself() -> None:
    blocks: dict[str, Block] = {"one": TwoWays(), "two": TwoWays()}
    wires = [
        "one.direct -> two.second",
        "two.direct -> one.second",
        "one.kept -> two.first",
        "two.kept -> one.first",
    ]
    assert len(schedule(Graph(name="", rate=1, blocks=blocks, wires=wires)).order) == 4
    crossed = ["one.direct -> two.first", "two.direct -> one.first", "one.kept -> two.second", "two.kept -> one.second"]
    with pytest.raises(ModelError) as caught:
        schedule(Graph(name="", rate=1, blocks=blocks, wires=crossed))
    assert named_wires(caught.value) == ["one.direct -> two.first", "two.direct -> one.first"]


def test_a_block_wired_to_itself() -> None:
    with pytest.raises(ModelError) as caught:
        schedule(Graph(name="", rate=1, blocks={"gain": Gain()}, wires=["gain.output -> gain.input"]))
    assert named_wires(caught.value) == ["gain.output -> gain.input"]
    assert schedule(Graph(name="", rate=1, blocks={"d": UnitDelay()}, wires=["d.output -> d.input"])).order


def test_a_driven_parameter_is_there_before_the_outputs_of_its_block() -> None:
    blocks: dict[str, Block] = {"a": UnitDelay(), "z": Constant()}
    graph = Graph(name="", rate=1, blocks={**blocks, "g": Gain()}, wires=["z.output -> g.gain", "a.output -> g.input"])
    scheduled = schedule(graph)
    assert scheduled.order == (("a", "output"), ("z", "output"), ConstantsOf("g"), ("g", "output"))
    assert scheduled.drivers == {("g", "gain"): ("z", "output"), ("g", "input"): ("a", "output")}


def test_a_loop_through_a_driven_parameter_names_the_parameter() -> None:
    wires = ["gain.output -> other.input", "other.output -> gain.gain", "source.output -> gain.input"]
    blocks: dict[str, Block] = {"gain": Gain(), "other": Gain(), "source": Constant()}
    with pytest.raises(ModelError) as caught:
        schedule(Graph(name="", rate=1, blocks=blocks, wires=wires))
    assert named_wires(caught.value) == ["gain.output -> other.input", "other.output -> gain.gain"]


def test_an_output_that_names_no_input_still_waits_for_a_driven_parameter() -> None:
    graph = Graph(name="", rate=1, blocks={"source": Constant()}, wires=["source.output -> source.value"])
    with pytest.raises(ModelError) as caught:
        schedule(graph)
    assert named_wires(caught.value) == ["source.output -> source.value"]


def test_base_rate_and_divisors() -> None:
    blocks: dict[str, Block] = {"a": Constant(), "b": Constant(), "c": Constant(), "mass": MassSpringDamper()}
    scheduled = schedule(Graph(name="", rate="50 kHz", blocks=blocks, rates={"a": "9.6 kHz", "b": "3.2 kHz"}))
    assert scheduled.base_rate == 1_200_000
    assert scheduled.divisors == {"a": 125, "b": 375, "c": 24, "mass": 1}


@pytest.mark.parametrize(
    ("facts", "rate"),
    [
        ({"blocks": {"mass": MassSpringDamper()}, "rate": "1/3 Hz"}, Fraction(1, 3)),
        ({"blocks": {"c": Constant()}, "rate": 5}, Fraction(5)),
        ({"blocks": {"c": Constant()}, "rates": {"c": 7}}, Fraction(7)),
        ({"blocks": {"c": Constant()}, "rate": 5, "rates": {"c": 7}}, Fraction(7)),
    ],
)
def test_the_rate_of_the_graph_counts_where_a_block_has_it(facts: dict[str, Any], rate: Fraction) -> None:
    assert schedule(Graph(name="", **facts)).base_rate == rate


@pytest.mark.exhaustive(but=20)
@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_every_output_of_the_library_is_scheduled_after_what_it_needs(path: Any) -> None:
    graph = flatten(read_graph(path)).as_graph()
    at = {node: index for index, node in enumerate(schedule(graph).order)}
    assert all(at[before] < at[after] for before, after in within_a_tick(graph))


@pytest.mark.exhaustive
def test_a_chain_of_ten_thousand_blocks_is_scheduled() -> None:
    gain = Gain()
    blocks = {f"b{n:05}": gain for n in range(10_000)}
    wires = [f"b{n:05}.output -> b{n + 1:05}.input" for n in range(9_999)]
    assert len(schedule(Graph(name="", rate=1, blocks=blocks, wires=wires)).order) == 10_000
    with pytest.raises(ModelError):
        schedule(Graph(name="", rate=1, blocks=blocks, wires=[*wires, "b09999.output -> b00000.input"]))


NEWTON = {"algebraic_loops": "newton"}


def test_a_loop_that_is_to_be_solved_is_ordered_behind_its_tears() -> None:
    blocks: dict[str, Block] = {"sum": Sum(), "gain": Gain(), "a": Constant(), "z": Gain()}
    wires = ["a.output -> sum.first", "sum.output -> gain.input", "gain.output -> sum.second", "sum.output -> z.input"]
    scheduled = schedule(Graph(name="", rate=1, blocks=blocks, wires=wires, integration=NEWTON))
    assert scheduled.order == (("a", "output"), ("gain", "output"), ("sum", "output"), ("z", "output"))
    assert [(loop.tears, loop.others) for loop in scheduled.loops] == [((("gain", "output"),), (("sum", "output"),))]


@pytest.mark.parametrize("first", range(0, 200, 50))
def test_random_loops_come_apart_at_their_tears(first: int) -> None:
    refused = set[str]()
    for seed in range(first, first + 50):
        graph = random_graph(seed)
        try:
            scheduled = schedule(dataclasses.replace(graph, integration=NEWTON))
        except ModelError as error:
            refused.add(str(error).partition("Newton's method cannot solve the loop, since ")[2][:18])
            continue
        assert bool(scheduled.loops) == has_loop(within_a_tick(graph))
        tears = {tear for loop in scheduled.loops for tear in loop.tears}
        at = {node: index for index, node in enumerate(scheduled.order)}
        assert all(after in tears or at[before] < at[after] for before, after in within_a_tick(graph))
    assert refused == {"the parameters of "}
