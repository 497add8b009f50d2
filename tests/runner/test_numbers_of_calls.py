"""Numbers that calls in Python take: what is no number of tries, no rate and no time is refused by name."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from proofmass import (
    allan,
    design_modulator,
    fit,
    noise,
    prove,
    read_graph,
    read_study,
    replay,
    response,
    run_study,
    spectrum,
    worst,
)
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.call_numbers import positive, real, whole

GRAPH = read_graph("library:closed_loop_accelerometer")
TOLERANCES = {"torquer.gain": "5 %"}
STUDY = read_study("library:scale_factor_drift")
VALUES = np.arange(4000.0) % 7.0
COUNTS: dict[str, Callable[[Any], Any]] = {
    "samples": lambda n: worst(GRAPH, tolerances=TOLERANCES, samples=n),
    "corners": lambda n: worst(GRAPH, tolerances=TOLERANCES, corners=n),
    "seed": lambda n: worst(GRAPH, tolerances=TOLERANCES, samples=1, seed=n),
    "threads": lambda n: run_study(STUDY, threads=n),
    "lanes": lambda n: run_study(STUDY, lanes=n),
    "run": lambda n: replay(STUDY, n),
    "epoch": lambda n: replay(STUDY, 0, epoch=n),
    "order": lambda n: design_modulator(n, 64),
    "levels": lambda n: design_modulator(2, 64, levels=n),
    "starts": lambda n: fit(GRAPH, {}, starts=n, free={}, outputs={}),
    "workers": lambda n: prove(GRAPH, tolerances=TOLERANCES, gain_margin="6 dB", workers=n),
}
NUMBERS: dict[str, Callable[[Any], Any]] = {
    "rate": lambda x: allan(VALUES, rate=x),
    "swing": lambda x: design_modulator(2, 64, swing=x),
    "seconds": lambda x: prove(GRAPH, tolerances=TOLERANCES, gain_margin="6 dB", seconds=x),
    "frequencies": lambda x: noise(GRAPH, "dac.code", frequencies=[x]),
}
PUSH, CODE = "acceleration.output", "dac.code"
REALS: dict[str, Callable[[Any], Any]] = {
    "tolerances": lambda x: worst(GRAPH, tolerances={"torquer.gain": x}),
    "tolerances from": lambda x: worst(GRAPH, tolerances={"torquer.gain": [x, 1.0]}),
    "band": lambda x: worst(GRAPH, {"quiet": {"noise": CODE, "band": [x, 100.0]}}, tolerances=TOLERANCES),
    "peak": lambda x: prove(GRAPH, input=PUSH, peak={CODE: x}, seconds=0.0),
    "constants": lambda x: prove(GRAPH, constants={PUSH: x}, seconds=0.0),
    "slow_change": lambda x: prove(GRAPH, tolerances=TOLERANCES, slow_change={"torquer.gain": x}, seconds=0.0),
}


@pytest.mark.defect("H893", before="`negative dimensions are not allowed`, of NumPy", after="the name, what it may be")
@pytest.mark.parametrize("value", [-1, 1.5, math.nan, True])
@pytest.mark.parametrize("name", COUNTS)
def test_a_count_is_refused_by_its_name(name: str, value: object) -> None:
    with pytest.raises(ModelError, match=rf"(?s)^{name}: .*got: +{value!r}\n +expected: "):
        COUNTS[name](value)


@pytest.mark.defect("S989", before="frequencies that no output has, and times of NaN, were taken", after="refused")
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_is_refused_by_its_name(name: str, value: float) -> None:
    with pytest.raises(ModelError, match=rf"(?s)^{name}: .*got: +{value:g}\b"):
        NUMBERS[name](value)


@pytest.mark.defect("S1066", before="a tolerance of True was 100 %, and a peak was 1", after="refused")
@pytest.mark.parametrize("name", REALS)
def test_a_truth_value_is_no_number(name: str) -> None:
    with pytest.raises(ModelError, match=r"must be|is not a"):
        REALS[name](True)


@pytest.mark.defect("C888", before="TypeError, OverflowError, errors of NumPy", after="refused, or taken")
def test_tolerances_and_limits_of_any_kind() -> None:
    for given in ([None, 1.0], 10**400):
        with pytest.raises(ModelError, match=r"tolerances\..torquer.gain"):
            worst(GRAPH, tolerances={"torquer.gain": given})
    limits = {CODE: np.array([-1e4, 0.0])}
    assert len(prove(GRAPH, input=PUSH, scale_factor=limits, seconds=0.0).proofs) == 2


@pytest.mark.defect("C889", before="a `Refusal`, which no caller knows", after="ModelError: skip: not a number")
def test_a_skip_is_refused_by_its_name() -> None:
    table = {"time": np.arange(20.0), "code": np.ones(20)}
    with pytest.raises(ModelError, match=r"^skip: not a number followed by a unit"):
        fit(GRAPH, table, outputs={CODE: "code"}, free=["torquer.gain"], skip="soon")


def test_no_runs_of_a_study_are_left_out() -> None:
    """With `threads` of NaN a study of two runs had none, without a word."""
    assert len(run_study(STUDY, runs=2, threads=np.int64(2)).numbers) == 2


@pytest.mark.defect("S1065", before="`rate=True` was 1 Hz", after="refused")
@pytest.mark.parametrize("rate", [math.inf, True])
def test_spectra_want_a_rate_too(rate: float) -> None:
    with pytest.raises(ModelError, match="plain values need a rate"):
        spectrum(VALUES, rate=rate)


@pytest.mark.defect("C886", before="a response at 0 Hz had no text", after="a row for 0 Hz")
@pytest.mark.parametrize("frequencies", [[0.0], [0.0, 1.0]])
def test_a_response_at_rest_has_a_table(frequencies: list[float]) -> None:
    found = response(GRAPH, "acceleration.output", "dac.code", frequencies=frequencies)
    rows = [line.split()[0] for line in str(found).splitlines()[-len(frequencies) :]]
    assert rows == [f"{f:g}" for f in frequencies]


def test_what_is_whole_and_what_is_positive() -> None:
    assert [real(value) for value in (1, np.float32(0.5), math.inf)] == [1.0, 0.5, math.inf]
    assert [whole(value) for value in (1, np.int64(1), True, 1.0, "1", None)] == [True, True, *[False] * 4]
    assert [positive(value) for value in (1, np.float64(0.5), 0, math.nan, "1", None)] == [True, True, *[False] * 4]
