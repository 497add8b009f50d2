"""Corners at which the least margin is looked for, and margins of loops that have none."""

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import pytest

from proofmass import margins
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.design.proof import least_found as least_found_of
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.least_found import _corners, margin_of
from proofmass.runner.design.worst.ranges import Range


def test_the_worst_corner_and_its_neighbours() -> None:
    ranges = (*(Range(name, name, "1", 2.0, 1.0, 3.0) for name in "abc"), Range("d", "d", "1", 0.0, 0.0, 0.0))
    worse = {"a": 3.0, "b": 1.0, "c": 3.0, "d": 0.0}  # the last is a source that is held
    assert list(_corners(worse, ranges, ())) == [
        worse,
        worse | {"a": 1.0},
        worse | {"b": 3.0},
        worse | {"c": 1.0},
        worse,
    ]


@pytest.mark.defect(
    "S874", before="of a turn its two ends, which are one: 28.8 dB beside 26.8 dB elsewhere", after="places all around"
)
@pytest.mark.parametrize("least", [-0.44, 0.0, 0.31, 0.48])
def test_a_turn_has_no_ends(least: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """20 dB less what a gain and the phase of a carrier take away."""

    def margin(sensors: object, claim: object, at: Mapping[str, float]) -> float:
        return 20.0 - at["gain"] - math.cos(2.0 * math.pi * (at["turns"] - least))

    monkeypatch.setattr(least_found_of, "value_there", margin)
    ranges = Range("gain", "gain", "1", 1.0, 0.9, 1.1), Range("turns", "turns", "", 0.0, -0.5, 0.5)
    sensors: Any = SimpleNamespace(turns={"turns"})
    found = least_found_of.least_found(sensors, ranges, Claim("main", "wire", "gain margin", 6.0))
    assert found.at["gain"] == 1.1
    assert found.margin == pytest.approx(17.9, abs=0.02)


@pytest.mark.parametrize(("gain", "rate"), [(1000.0, math.inf), (500.0, 1000.0 * math.log(2.0))])
def test_a_loop_that_ends_in_one_tick_decays_at_any_rate(gain: float, rate: float) -> None:
    """An integrator with feedback -x at 1 kHz: x[n+1] = (1 - gain T) x[n]."""
    graph = read_graph_text(f"""
name = "deadbeat"
rate = "1 kHz"
wires = ["inverter.output -> integrator.input", "integrator.output -> inverter.input"]
blocks.inverter = {{ kind = "Gain", gain = -1.0, input_unit = "s" }}
blocks.integrator = {{ kind = "DiscreteIntegrator", gain = {gain} }}
""")
    assert margin_of(margins(graph), "decay rate") == pytest.approx(rate, rel=1e-12)
