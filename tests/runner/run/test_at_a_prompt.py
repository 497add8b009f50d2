"""Results at a prompt: mappings, arithmetic, and a line for each."""

import copy
import pickle
from collections.abc import Callable
from dataclasses import is_dataclass

import numpy as np
import pytest

import proofmass


@pytest.fixture(scope="module")
def result() -> proofmass.Result:
    return proofmass.simulate("library:template")


def test_a_result_is_read_as_a_mapping(result: proofmass.Result) -> None:
    assert list(result.keys()) == ["sensor.displacement", "adc.code"]
    assert "adc.code" in result
    assert "adc.cod" not in result
    assert {signal: trace.digest for signal, trace in result.items()} == {one: result[one].digest for one in result}
    assert [trace.signal for trace in result.values()] == list(result)


def test_traces_take_part_in_arithmetic(result: proofmass.Result) -> None:
    trace = result["sensor.displacement"]
    assert type(trace * 2) is np.ndarray
    assert np.array_equal(trace * 2, trace.values * 2)
    assert np.array_equal(1e9 * trace - trace, 1e9 * trace.values - trace.values)
    assert np.array_equal(np.abs(-trace), np.abs(trace.values))
    assert np.mean(trace) == np.mean(trace.values)


@pytest.mark.friendly(16, "a prompt shows a line, not pages")
def test_what_a_prompt_shows_is_a_line(result: proofmass.Result) -> None:
    budget = proofmass.noise("library:closed_loop_accelerometer", "dac.code")
    margins = proofmass.margins("library:closed_loop_accelerometer")
    density = proofmass.spectrum(result["adc.code"])
    for shown in map(repr, (result, result.graph, result["adc.code"], budget, margins, density)):
        assert len(shown) < 200
        assert "\n" not in shown


@pytest.mark.defect(
    "C893", before="results compared by == end in an error of NumPy", after="two results are equal if they are one"
)
def test_two_results_are_equal_if_they_are_one(result: proofmass.Result) -> None:
    again = proofmass.simulate("library:template")
    assert result != again
    assert result == result
    assert result.digest == again.digest
    assert again not in [result]
    assert len({result, again, result}) == 2


def test_no_result_has_an_equality_of_its_fields() -> None:
    kinds = [getattr(proofmass, name) for name in proofmass.__all__ if name[0].isupper()]
    results = [kind for kind in kinds if is_dataclass(kind) and kind.__module__.startswith("proofmass.runner")]
    assert len(results) > 10
    by_fields = [kind for kind in results if kind.__eq__ is not object.__eq__]
    assert by_fields == [proofmass.Trace]  # which compares its values, as an array does


@pytest.mark.defect(
    "S1037", before="values of a copied or pickled trace can be changed", after="read-only, as those of the run"
)
@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_copies_of_a_result_are_read_only(
    again: Callable[[proofmass.Result], proofmass.Result], result: proofmass.Result
) -> None:
    copied = again(result)
    assert copied.digest == result.digest
    assert not copied["adc.code"].values.flags.writeable
