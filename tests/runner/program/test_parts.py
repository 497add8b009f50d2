"""A long function in parts computes the bits of the whole, whatever stands between two parts."""

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.program import parts
from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, Function, Operand, Storage, Variable
from proofmass.runner.program.lower import program
from proofmass.runner.program.tick import write_tick
from proofmass.runner.targets.llvm_text import content_of
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.verify_program import verify

GRAPHS = ["closed_loop_accelerometer", "vibratory_gyroscope", "self_calibration_fixed", "recorded_motion"]


def all_kinds() -> tuple[Function, dict[Variable, tuple[Storage, int]], Storage]:
    """Values, variables and views of every kind, made in one place and read in another, in and behind a loop."""
    builder = Builder("long")
    last = builder.parameter(INTEGER, "last")
    given = builder.array(FLOAT, 4, "given")
    moving = builder.array(INTEGER, 2, "moving", True)
    memory = builder.array(FLOAT, 40, "memory", True)
    out = builder.array(FLOAT, 8, "out", True)
    count = builder.variable(INTEGER, "count")  # in `moving`, from call to call
    high = builder.variable(TRUTH, "high")
    total = builder.variable(FLOAT, "total", 0.25)
    unset = builder.variable(FLOAT, "unset")
    gain = builder.load(given, 1)
    half = builder.view(out, 4, 4, "half")
    squared = builder.compute("multiply", gain, gain)
    large = builder.compute("less", 2.0, squared)
    rounded = builder.compute("integer_of_float", squared)
    with builder.counted(0, last, 1, "turn") as turn:
        moved = builder.compute("add", builder.get(total), builder.compute("multiply", squared, 0.5))
        builder.set(total, moved)
        builder.set(count, builder.compute("add_integers", builder.get(count), rounded))
        odd = builder.compute("equal_integers", builder.compute("and", turn, 1), 1)
        with builder.when(builder.compute("both", odd, large)):
            builder.set(high, builder.compute("not", builder.get(high)))
        with builder.otherwise():
            builder.set(unset, builder.compute("add", builder.get(unset), gain))
        inner: Operand = moved
        with builder.counted(0, 3, 1, "inner") as place:
            builder.store(half, place, builder.compute("multiply", inner, builder.compute("float_of_integer", place)))
        builder.store(out, 3, builder.compute("select", builder.get(high), inner, 1.5))
    for place, value in enumerate((builder.get(total), builder.get(unset), squared)):
        builder.store(out, place, value)
    return builder.function(), {count: (moving, 0), high: (moving, 1)}, memory


def results(
    function: Function, places: dict[Variable, tuple[Storage, int]], turns: int
) -> tuple[list[float], list[int]]:
    """What the function leaves in its arrays; one that is whole keeps the variables of `places` itself."""
    out, moving = [0.0] * 8, [5, 1]
    evaluate(function, turns, [0.5, 1.75, 0.0, 0.0], moving, [float("nan")] * 40, out)
    return out, moving


@pytest.mark.parametrize("length", [1, 2, 3, 5, 8])
def test_everything_finds_its_way_from_part_to_part(length: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LONG", 1)
    monkeypatch.setattr(parts, "PART", length)
    function, places, memory = all_kinds()
    used = parts.in_parts(function, places, memory, 3)
    assert used is not None
    assert used > 3
    verify(program(function))
    assert len(program(function).functions) > 2
    for turns in (0, 1, 2, 7):
        out, moving = results(function, places, turns)
        squared, total, unset, high, count = 1.75**2, 0.25, 0.0, True, 5
        for turn in range(turns):
            total += squared * 0.5
            count += int(squared)
            high, unset = (not high, unset) if turn % 2 else (high, unset + 1.75)
        last = [total if high else 1.5, 0.0, total, 2.0 * total] if turns else [0.0] * 4
        assert out == [total, unset, squared, *last, 0.0]
        assert moving == [count, high]


def test_a_short_function_stays_whole() -> None:
    function, places, memory = all_kinds()
    before = list(function.body)
    assert parts.in_parts(function, places, memory, 0) is None
    assert function.body == before


def test_a_function_that_leaves_a_loop_stays_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LONG", 1)
    monkeypatch.setattr(parts, "PART", 1)
    builder = Builder("leaves")
    memory = builder.array(FLOAT, 9, "memory", True)
    with builder.counted(0, 9, 1, "turn") as turn:
        builder.store(memory, turn, 1.0)
        with builder.when(builder.compute("equal_integers", turn, 4)):
            builder.leave()
    assert parts.in_parts(builder.function(), {}, memory, 0) is None


def bounds_and_views() -> tuple[Function, Storage]:
    """Loops whose ends stand in a view of a table or are computed before, views that move, and loops without an end."""
    builder = Builder("long")
    first = builder.parameter(INTEGER, "first")
    table = builder.array(INTEGER, 4, "table")
    memory = builder.array(FLOAT, 40, "memory", True)
    out = builder.array(FLOAT, 8, "out", True)
    ends = builder.view(table, 2, 2, "ends")
    turns = builder.load(ends, 1, "turns")
    begin = builder.compute("add_integers", first, 1)
    with builder.counted(begin, turns, 1, "turn") as turn:
        left = builder.variable(INTEGER, "left", 3)
        number = builder.compute("float_of_integer", turn)
        with builder.when(builder.compute("less_integers", turn, turns)):
            pair = builder.view(out, turn, 2, "pair")
            builder.store(pair, 1, builder.compute("add", builder.load(pair, 0), 1.0))
            builder.store(pair, 0, number)
            with builder.repeated(lambda: builder.compute("less_integers", 0, builder.get(left))):
                builder.set(left, builder.compute("subtract_integers", builder.get(left), 1))
                builder.store(pair, 1, builder.compute("add", builder.load(pair, 1), 0.25))
    builder.store(out, 7, builder.compute("float_of_integer", turns))
    return builder.function(), memory


@pytest.mark.parametrize("length", [1, 4, 30])
def test_bounds_and_views_find_their_way(length: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LONG", 1)
    monkeypatch.setattr(parts, "PART", length)
    function, memory = bounds_and_views()
    assert parts.in_parts(function, {}, memory, 0) is not None
    verify(program(function))
    for first in (-1, 1):
        out = [0.0] * 8
        evaluate(function, first, [9, 9, 9, 4], [float("nan")] * 40, out)
        expected = [0.0] * 8
        for turn in range(first + 1, 4):
            expected[turn + 1] = expected[turn] + 1.0 + 0.75
            expected[turn] = float(turn)
        expected[7] = 4.0
        assert out == expected


def test_a_view_that_moves_is_not_handed_from_part_to_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LONG", 1)
    monkeypatch.setattr(parts, "PART", 1)
    builder = Builder("moves")
    first = builder.parameter(INTEGER, "first")
    memory = builder.array(FLOAT, 9, "memory", True)
    pair = builder.view(memory, first, 2, "pair")
    builder.store(pair, 0, 1.0)
    assert parts.in_parts(builder.function(), {}, memory, 0) is None


def test_a_function_that_returns_from_a_loop_without_an_end_stays_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LONG", 1)
    builder = Builder("returns")
    memory = builder.array(FLOAT, 9, "memory", True)
    with builder.repeated(lambda: True):
        builder.store(memory, 0, 1.0)
        builder.give()
    assert parts.in_parts(builder.function(), {}, memory, 0) is None


def behind(planned: Plan, compiled: CompiledPlan, calls: tuple[int, ...]) -> list[np.ndarray]:
    """What the probes recorded in some calls of the loop, and everything that moves, behind them."""
    kinds = {float: np.float64, int: np.int64, bool: np.bool_}
    loop, last = CompiledLoop(planned, 3, 1, start(planned), compiled), calls[-1]
    recorded = [np.zeros((p.rows(0, last), *p.shape), dtype=kinds[p.dtype]) for p in planned.probes]
    for end in calls:
        spans = [(p.rows(0, loop.tick), p.rows(0, end)) for p in planned.probes]
        loop.advance(end, [rows[first:behind] for rows, (first, behind) in zip(recorded, spans, strict=True)])
    memory = loop.memory()
    moving = [*(state for state in memory.states.values() if state), *memory.wires.values()]
    return [*recorded, *(np.array(value, dtype=float) for value in moving)]


@pytest.mark.exhaustive("self_calibration_fixed")
@pytest.mark.parametrize("name", GRAPHS)
def test_ticks_in_parts_have_the_same_bits(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(read_graph(library_file(f"{name}.toml")))
    whole = behind(planned, CompiledPlan(planned), (150,))
    monkeypatch.setattr(parts, "LONG", 30)
    monkeypatch.setattr(parts, "PART", 25)
    compiled = CompiledPlan(planned)
    verify(compiled.written.program)
    assert any(function.apart for function in compiled.written.program.functions.values())
    assert content_of(write_tick(planned).program) == content_of(compiled.written.program)
    for one, other in zip(whole, behind(planned, compiled, (1, 70, 150)), strict=True):
        assert one.tobytes() == other.tobytes()
