"""Laws of ageing against their closed forms and against the blocks that simulate them sample by sample."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.constants import Boltzmann, electron_volt

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.noise_and_drift.arrhenius_ageing import ArrheniusAgeing
from proofmass.graphs.studies.ageing import LAWS, read_drift

YEAR = 31557600.0
AGES = [0.0, YEAR, 4 * YEAR, 10 * YEAR]


def aged(table: dict[str, Any], run: int = 0) -> np.ndarray[Any, Any]:
    return np.array(read_drift({"relative": True, **table}, "V").aged(2.0, AGES, 3, run, 8)) / 2.0 - 1.0


def test_ramp() -> None:
    assert aged({"ramp": "20 ppm/year"}) == pytest.approx([0.0, 20e-6, 80e-6, 200e-6], abs=1e-15)
    absolute = read_drift({"ramp": "1 mV/year"}, "V").aged(2.0, AGES, 3, 0, 8)
    assert absolute == pytest.approx([2.0, 2.001, 2.004, 2.01], rel=1e-15)


def test_logarithmic() -> None:
    expected = [10e-6 * math.log10(1.0 + age / 360000.0) for age in AGES]
    assert aged({"logarithmic": "10 ppm", "onset": "100 h"}) == pytest.approx(expected, abs=1e-15)


def test_arrhenius() -> None:
    factor = math.exp(0.7 * electron_volt / Boltzmann * (1.0 / 298.15 - 1.0 / 358.0))
    table = {"arrhenius": "1 ppm/year", "temperature": "358 K", "activation_energy": "0.7 eV"}
    assert aged(table) == pytest.approx([1e-6 * factor * age / YEAR for age in AGES], rel=1e-9, abs=1e-15)


@pytest.mark.defect("S213", before="0.699985 eV where nothing is said", after="0.7 eV to the last digit")
def test_the_activation_energy_is_that_of_the_documents() -> None:
    table = {"arrhenius": "1 ppm/year", "relative": True}
    said = read_drift({**table, "activation_energy": "0.7 eV"}, "V")
    assert read_drift(table, "V") == said
    assert (
        ArrheniusAgeing().activation_energy == said.activation_energy == pytest.approx(0.7 * electron_volt, rel=1e-15)
    )


@pytest.mark.exhaustive
def test_a_random_walk_has_independent_steps_of_the_variance_of_their_time() -> None:
    paths = np.array([aged({"random_walk": "3 ppm/sqrt(year)"}, run) for run in range(4000)]) * 1e6
    steps = np.diff(paths, axis=1)
    assert (paths[:, 0] == 0.0).all()
    assert steps.std(axis=0) == pytest.approx(3.0 * np.sqrt([1.0, 3.0, 6.0]), rel=4 / math.sqrt(8000))
    correlation = np.corrcoef(steps.T) - np.eye(3)
    assert abs(correlation).max() < 4 / math.sqrt(4000)


@pytest.mark.parametrize("law", [law for law in LAWS if law not in ("random_walk", "cycles")])
def test_the_spread_of_a_pace_is_between_sensors_not_between_epochs(law: str) -> None:
    unit = "ppm" if law == "logarithmic" else "ppm/year"
    without = aged({law: f"10 {unit}"})
    paths = np.array([aged({law: f"10 {unit}", f"{law}_spread": f"2 {unit}"}, run) for run in range(2000)])
    factors = paths[:, 1:] / without[1:]
    assert np.ptp(factors, axis=1).max() < 1e-6
    assert factors[:, 0].std() == pytest.approx(0.2, rel=4 / math.sqrt(4000))


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"relative": True}, ""),
        ({"onset": "1 d", "ramp": "1 V/s"}, "onset"),
        ({"ramp": "1 V"}, "ramp"),
        ({"random_walk": "-1 V/sqrt(s)"}, "random_walk"),
        ({"arrhenius": "1 V/s", "temperature": 0}, "temperature"),
    ],
)
def test_mistakes(table: dict[str, Any], key: str) -> None:
    with pytest.raises(Refusal) as caught:
        read_drift(table, "V")
    assert caught.value.key == key
