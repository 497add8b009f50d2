"""Which of several starts of a fit is best, by a search that was made by hand."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.identification.fitted import _best, _refuse_few, _shifts
from proofmass.runner.design.quantities.stopping import InterruptedSearch

ROWS = {"a": range(30), "b": range(10)}


class Search:
    """A search whose starts end at given levels of noise; it begins each with the first one."""

    signals, scales = ("a", "b"), np.array([7.0])

    def __init__(self, *ends: dict[str, float] | None) -> None:
        self.ends, self.noise, self.best = iter(ends), {"a": 9.0, "b": 9.0}, None
        self.started, self.stopped = list[float](), False

    def compared(self, signal: str) -> range:
        return ROWS[signal]

    def solved(self, start: Any) -> Any:
        assert self.noise == {"a": 9.0, "b": 9.0}
        self.started.append(float(start[0]))
        noise = next(self.ends)
        if noise is None:
            raise InterruptedSearch
        self.noise = dict.fromkeys("ab", 0.0)
        return SimpleNamespace(noise=noise)

    def interrupt(self) -> None:
        self.stopped = True

    def as_it_is(self, values: Any) -> Any:
        return SimpleNamespace(noise={"a": 1.0, "b": 1.0}, values=values)


def best(search: Any, starts: int) -> tuple[Any, int, bool]:
    unknown: Any = SimpleNamespace(start=5.0, sampled=lambda part, size: 93.0 + size + part)
    return _best(search, [unknown], starts, 3)


def test_the_start_with_the_least_noise_by_the_rows_of_each_output() -> None:
    """Logarithms of noise count by rows, 3 to 1: e and 1 make 0.75, 1 and e^2 make 0.5, which 0.50005 reaches."""
    e = math.e
    ends = [{"a": e, "b": 1.0}, {"a": 1.0, "b": e**2.0002}, {"a": 1.0, "b": e**2}, {"a": 1.0, "b": e**2.008}]
    search = Search(*ends)
    chosen, reached, interrupted = best(search, 4)
    assert chosen.noise == ends[2]
    assert (reached, interrupted) == (2, False)
    assert search.noise == ends[2]
    assert search.started == [5.0, *(100.0 + np.random.default_rng(3).random((3, 1))[:, 0])]


@pytest.mark.parametrize("starts", [0, 1])
def test_one_start_is_the_one_that_is_given(starts: int) -> None:
    search = Search({"a": 1.0, "b": 1.0})
    assert best(search, starts)[1:] == (1, False)
    assert search.started == [5.0]


def test_an_interrupted_search_has_what_is_there() -> None:
    search = Search({"a": 2.0, "b": 2.0}, None)
    chosen, reached, interrupted = best(search, 3)
    assert (chosen.noise["a"], reached, interrupted, search.stopped) == (2.0, 1, True, True)
    nothing = Search(None)
    chosen, reached, interrupted = best(nothing, 3)
    assert (chosen.values.tolist(), reached, interrupted) == ([5.0], 1, True)
    found: Any = Search(None)
    found.best = 0.5, np.array([7.0])
    assert best(found, 3)[0].values.tolist() == [7.0]


def test_there_are_more_values_than_unknowns() -> None:
    solver: Any = Search()
    _refuse_few(solver, [None] * 39)  # type: ignore[list-item]
    with pytest.raises(ModelError, match="too few values are left to compare") as refused:
        _refuse_few(solver, [None] * 40)  # type: ignore[list-item]
    assert (refused.value.problems[0].got, refused.value.problems[0].expected) == (
        "40",
        "more than 40, one for each unknown",
    )


@pytest.mark.defect("S925", before="an offset of one value was known to 6e-9 V beside noise of 0.1 V", after="refused")
def test_every_output_has_values_that_tell_its_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    solver: Any = Search()
    monkeypatch.setitem(ROWS, "b", range(8))
    _refuse_few(solver, [])
    monkeypatch.setitem(ROWS, "b", range(7))
    with pytest.raises(ModelError, match="b: too few values are left to compare") as refused:
        _refuse_few(solver, [])
    assert (refused.value.problems[0].got, refused.value.problems[0].expected) == ("7", "at least 8")


def test_offsets_and_delays_of_outputs() -> None:
    outputs: Any = [SimpleNamespace(signal="a", unit="V"), SimpleNamespace(signal="b", unit="m")]
    found = [(one.name, one.unit, one.start) for one in _shifts(outputs, ["b"], ["a"])]
    assert found == [("offset of b", "m", 0.0), ("delay of a", "s", 0.0)]
    with pytest.raises(ModelError, match="is not an output of the fit"):
        _shifts(outputs, [], ["c"])
