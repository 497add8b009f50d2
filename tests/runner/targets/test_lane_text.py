"""Several runs side by side compute, each in its lane, the bits of the run alone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.runner.program.form import FLOAT, INTEGER, Program, Storage, Value
from proofmass.runner.program.listing import listing
from proofmass.runner.program.varying import ALL
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.lane_text import LanesOf, lane_text
from proofmass.runner.targets.native_lanes import aligned
from tests.by_hand.hostile_operations import operations_arrays, operations_program
from tests.by_hand.programs import Writer, program
from tests.by_hand.random_programs import RandomProgram, random_arrays
from tests.by_hand.verify_program import verify

FAST = machine_code.Settings(level=1, wide=True)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cache folder of the test's own."""
    monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path / "cache"))


def rows(arrays: list[Any]) -> Any:
    """The arrays of several runs, one lane beside the other."""
    made = aligned((len(arrays[0]), len(arrays)), arrays[0].dtype)
    made[:] = np.array(arrays).T
    return made


def same(one: Any, other: Any) -> bool:
    """Whether bits are equal, but for those of NaN."""
    if one.dtype != np.float64:
        return bool((one == other).all())
    return bool(((one.view(np.int64) == other.view(np.int64)) | (np.isnan(one) & np.isnan(other))).all())


def compare(made: Program, lanes: int, runs: list[list[Any]], differing: frozenset[Storage] | None = None) -> None:
    """Run a program in lanes and alone; arrays that are not `differing` are the same in all runs."""
    verify(made)
    arrays = [p for p in made.entry.parameters if isinstance(p, Storage)]
    numbers = frozenset(p for p in made.entry.parameters if isinstance(p, Value))
    shared = frozenset(array for array in arrays if not array.writable and array.name == "table")
    entries = {array: ALL for array in arrays if differing is None or array in differing}
    side_by_side = [runs[0][k].copy() if a in shared else rows([r[k] for r in runs]) for k, a in enumerate(arrays)]
    count = aligned((lanes,), np.dtype(np.int64))
    count[:] = np.arange(lanes)
    of_entry = LanesOf(numbers, shared, {a: bits for a, bits in entries.items() if a not in shared})
    function = machine_code.load_lanes(made, lanes, of_entry, FAST)
    function(*[count.ctypes.data] * len(numbers), *(array.ctypes.data for array in side_by_side))
    alone = machine_code.load(made, machine_code.Settings(level=1))
    for lane, run in enumerate(runs):
        alone(*[lane] * len(numbers), *(array.ctypes.data for array in run))
        for array, together, own in zip(arrays, side_by_side, run, strict=True):
            if array not in shared:
                assert same(np.ascontiguousarray(together[:, lane]), own), (array.name, lane, together[:, lane], own)


@pytest.mark.exhaustive("8")
@pytest.mark.parametrize("lanes", [8, 16])
def test_operations_on_hostile_values(lanes: int) -> None:
    def run(lane: int) -> list[Any]:
        return [np.roll(array, 7 * lane) for array in operations_arrays()]

    made = operations_program()
    compare(made, lanes, [run(lane) for lane in range(lanes)])


def test_powers_of_two_divide_as_in_python() -> None:
    dividends, divisors = [7, -7, 8, -1, 2**62, -(2**63), 0, 12345], [1, 2, 8, 2**40]
    number, out = Storage(INTEGER, 1, False, "number"), Storage(INTEGER, 2 * len(divisors), True, "out")
    w = Writer("entry", number, out)
    value = w.load(number, 0)
    for place, divisor in enumerate(divisors):
        w.store(out, 2 * place, w.do("floor_divide", value, divisor))
        w.store(out, 2 * place + 1, w.do("modulo", value, divisor))
    given, found = rows([np.array([n]) for n in dividends]), rows([np.zeros(2 * len(divisors), int)] * 8)
    of_entry = LanesOf(frozenset(), frozenset(), {number: ALL, out: ALL})
    function = machine_code.load_lanes(program(w.function), 8, of_entry, FAST)
    function(given.ctypes.data, found.ctypes.data)
    assert found.T.tolist() == [[n for d in divisors for n in divmod(dividend, d)] for dividend in dividends]


@pytest.mark.exhaustive(but=20)
@pytest.mark.parametrize("seed", range(60))
def test_random_programs(seed: int) -> None:
    made = RandomProgram(seed).program
    lanes = (2, 4, 8)[seed % 3]
    runs = [random_arrays(100 * seed + lane) for lane in range(lanes)]
    for run in runs:
        run[3] = runs[0][3]
    try:
        compare(made, lanes, runs)
    except AssertionError:
        print(listing(made))
        raise


@pytest.mark.parametrize("seed", range(60, 80))
def test_random_programs_of_runs_that_begin_alike(seed: int) -> None:
    made = RandomProgram(seed).program
    runs = [random_arrays(seed) for _ in range(4)]
    compare(made, 4, runs, frozenset())


def test_what_is_the_same_in_all_lanes_is_computed_once() -> None:
    time, gain = Value(FLOAT, "time"), Value(FLOAT, "gain")
    out = Storage(FLOAT, 2, True, "out")
    w = Writer("entry", time, gain, out)
    shared = w.do("divide", time, 3.0)
    w.store(out, 0, shared)
    w.store(out, 1, w.do("multiply", shared, gain))
    text = lane_text(program(w.function), 8, LanesOf(frozenset({gain}), frozenset(), {}))
    assert text.count("fdiv double") == 1
    assert "fdiv <8" not in text
    assert text.count("fmul <8 x double>") == 1


def test_of_an_array_only_the_entries_that_differ_are_in_lanes() -> None:
    table, out = Storage(FLOAT, 3, False, "table"), Storage(FLOAT, 3, True, "out")
    w = Writer("entry", table, out)
    for place in range(3):
        w.store(out, place, w.do("divide", w.load(table, place), 3.0))
    text = lane_text(program(w.function), 8, LanesOf(frozenset(), frozenset(), {table: 0b010, out: 0}))
    assert (text.count("fdiv double"), text.count("fdiv <8 x double>")) == (2, 1)


def test_integers_of_loops_stay_single() -> None:
    n, out = Value(INTEGER, "n"), Storage(FLOAT, 10, True, "out")
    w = Writer("entry", n, out)
    with w.count(0, n) as i:
        w.store(out, i, w.do("add", w.load(out, i), 1.0))
    text = lane_text(program(w.function), 4, LanesOf(frozenset(), frozenset(), {out: 1}))
    assert "phi i64" in text
    assert "fadd <4 x double>" in text
