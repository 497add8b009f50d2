"""Results at a prompt: mappings, arithmetic, and a line for each."""

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
