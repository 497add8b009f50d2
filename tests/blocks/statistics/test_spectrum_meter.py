"""Density at all lines against Welch's method in SciPy, and the same bits in every engine and in lanes."""

import numpy as np
import pytest
import scipy.signal

from proofmass import Graph, ModelError, Study, run_study, simulate
from proofmass.blocks import SpectrumMeter, VectorElement, WhiteNoise
from tests.by_hand.functions import drive

PERIOD, SEGMENT = 1e-2, 32
LINES = SEGMENT // 2 + 1


@pytest.mark.parametrize("skip", [0, 11])
def test_against_welch(skip: int) -> None:
    inputs = (5.0 + np.random.default_rng(2).normal(size=400)).tolist()
    rows = drive(SpectrumMeter(segment=SEGMENT, skip=skip), [{"input": u} for u in inputs], PERIOD)
    _, density = scipy.signal.welch(
        np.array(inputs)[skip:-1], 1.0 / PERIOD, "hann", nperseg=SEGMENT, noverlap=SEGMENT // 2, detrend="constant"
    )
    assert rows[-1]["density"] == pytest.approx(np.sqrt(density), rel=1e-11, abs=1e-13)
    assert rows[-1]["segments"] == (399 - skip) // (SEGMENT // 2) - 1
    assert not any(rows[SEGMENT - 1 + skip]["density"])


def test_a_segment_is_a_power_of_two() -> None:
    with pytest.raises(ModelError, match="a power of two"):
        SpectrumMeter(segment=100)


def test_engines_and_lanes_have_the_same_bits() -> None:
    blocks = {
        "noise": WhiteNoise(density=1.0),
        "meter": SpectrumMeter(segment=SEGMENT),
        **{f"line_{k}": VectorElement(size=LINES, index=k, unit="(1)/sqrt(Hz)") for k in (0, 5, 16)},
    }
    graph = Graph(
        name="",
        rate=1.0 / PERIOD,
        seed=4,
        samples=200,
        blocks=blocks,
        wires=[
            "noise.output -> meter.input",
            *(f"meter.density -> {name}.vector" for name in blocks if "line" in name),
        ],
        probes=["meter.density"],
        measures={name: {"signal": f"{name}.output", "statistic": "last"} for name in blocks if "line" in name},
    )
    runs = [simulate(graph, engine=engine) for engine in ("python", "compiled")]
    assert runs[0]["meter.density"].values.tobytes() == runs[1]["meter.density"].values.tobytes()
    study = run_study(Study(graph, runs=4, seed=4), engine="compiled")
    one_by_one = run_study(Study(graph, runs=4, seed=4), engine="python")
    for name, values in one_by_one.values.items():
        assert values.tobytes() == study.values[name].tobytes()
