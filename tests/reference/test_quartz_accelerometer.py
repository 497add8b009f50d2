"""The digital quartz accelerometer against closed forms: scale factor, drift signs, loop gain, carrier and baseband.

Parameters are those of the library graph: assumptions [A], since the paper has none.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from docs.papers.quartz_accelerometer import CODES_PER_AMPERE, FEEDBACK_CURRENT, SCALE_FACTOR, library, mean_output
from proofmass.blocks import DiscreteTransferFunction
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.run.simulate import simulate

ONE_G = 9.80665


@pytest.fixture(scope="module")
def at_one_g() -> float:
    return mean_output()


def test_scale_factor_within_1_ppm(at_one_g: float) -> None:
    """K0 / (kt kVI kDA) = 8827.40 codes per m/s^2, with the sign of the feedback."""
    assert abs(SCALE_FACTOR + 8827.397) < 1e-3
    assert (at_one_g - mean_output({"specific_force.value": -ONE_G})) / (2.0 * ONE_G) == pytest.approx(
        SCALE_FACTOR, rel=1e-6
    )


def test_bias_of_the_reference_capacitors() -> None:
    """0.2138 % of imbalance tilt the plate by (r - 1/2) 2 d / l; the flexure's torque is a bias of 102.2 ug."""
    angle = (42.590865 / 85.0 - 0.5) * 2.0 * 12.5e-6 / 10e-3
    bias = 3.0e-3 * angle / 8.0e-6
    assert bias / 9.80665e-6 == pytest.approx(102.2, abs=0.1)
    assert mean_output({"specific_force.value": 0.0}) == pytest.approx(-SCALE_FACTOR * bias, abs=0.01)


@pytest.mark.parametrize(
    ("parameter", "nominal", "expected"),
    [
        ("da0.reference", 5.0, -1.0 / 1.001),
        ("converter.resistance", 342.0, 1.0),
        ("torquer.gain", 0.065, -1.0 / 1.001),
        ("follow_up.gain", 3.0, 0.0),
        ("da1.reference", 2.5, 0.0),
        ("adc.reference", 5.0, 0.0),
        ("forward_gain.gain", 1.0, 0.0),
        ("amplifier.feedback_resistance", 90e3, 0.0),
        ("pendulum.inertia", 1e-7, 0.0),
        ("pendulum.damping", 4e-4, 0.0),
        ("pickoff.capacitance", 42.5e-12, 0.0),
        ("pid.proportional", 0.06, 0.0),
    ],
)
def test_what_a_drift_does_to_the_output_within_0_1_ppm(
    at_one_g: float, parameter: str, nominal: float, expected: float
) -> None:
    """+0.1 % of the reference or the torquer: -x / (1 + x); of the resistor: +x; of the forward channel: nothing."""
    drifted = mean_output({parameter: 1.001 * nominal})
    assert drifted / at_one_g - 1.0 == pytest.approx(1e-3 * expected, abs=1e-7)


def switched(changes: dict[str, object]) -> float:
    """N_on - N_off of the first measurement."""
    result = simulate(library("quartz_feedback_gain").with_parameters(changes), engine="compiled", duration="0.45 s")
    return float(result["estimator.difference"].values[-1])


@pytest.mark.parametrize("parameter", ["specific_force.value", "torquer.gain"])
def test_switched_difference_holds_neither_acceleration_nor_torquer(parameter: str) -> None:
    """Eq. 26: -I_ref / (k_VI k_DA) = -71738.85 [P], whatever the acceleration and kt."""
    expected = -FEEDBACK_CURRENT * CODES_PER_AMPERE
    assert expected == pytest.approx(-71738.85, abs=5e-3)
    for value in {"specific_force.value": (-2.0, 0.0, 20.0), "torquer.gain": (0.06, 0.07)}[parameter]:
        assert switched({f"accelerometer.{parameter}": value}) == pytest.approx(expected, rel=1e-7)


def test_proportional_loop_is_off_by_its_loop_gain() -> None:
    """Without integral the dc loop gain is 243.3, the output 0.99591 of the true one, and -200 ppm leak -0.82 ppm.

    Converters of 32 bits keep the loop as it is and show what codes of 20 bits hide.
    """
    fine = {"adc.bits": 32, "da2.bits": 32, "forward_gain.gain": 2.0**12 / 2.0**8}  # 8 bits more in front, 12 behind
    fine |= {"pid.integral": 0.0, "pid.limited": False}
    gain = 8.0e3 / 3.0e-3 * 2**23 / 5.0 * 0.06 / CODES_PER_AMPERE * 0.065 * (34952 / 131072 * 2.5 * 3.0 / 2.0)
    assert gain == pytest.approx(243.3, abs=0.05)
    assert gain / (1.0 + gain) == pytest.approx(0.99591, abs=1e-5)

    def slope(changes: dict[str, Any]) -> float:
        rest, one_g = (mean_output(fine | changes | {"specific_force.value": a}) / 4096.0 for a in (0.0, ONE_G))
        return (one_g - rest) / ONE_G

    found = slope({})
    assert found / SCALE_FACTOR == pytest.approx(gain / (1.0 + gain), rel=1e-7)
    leak = slope({"follow_up.gain": 3.0 * (1.0 - 200e-6)}) / found - 1.0
    assert leak == pytest.approx(-200e-6 / (1.0 + gain), rel=1e-3)
    assert 1e6 * leak == pytest.approx(-0.82, abs=0.005)


def test_carrier_and_baseband_are_the_same_device() -> None:
    carrier, baseband = library("quartz_accelerometer_carrier").blocks, library("quartz_accelerometer").blocks
    shared = set(carrier) & set(baseband)
    assert len(shared) == 18
    assert {name: carrier[name] for name in shared} == {name: baseband[name] for name in shared}


def test_carrier_and_baseband_agree() -> None:
    """Mean output within 1e-7; on the way from rest to 1 g within 0.5 % of 1 g after the first half millisecond.

    The baseband waits a sample where the demodulator averages over one: 20 us against 10 us of delay.
    """
    carrier, baseband = (
        simulate(library(name), engine="compiled", duration="0.5 s")["da2.code"].values.astype(float)
        for name in ("quartz_accelerometer_carrier", "quartz_accelerometer")
    )
    assert carrier[15_000:].mean() / baseband[15_000:].mean() - 1.0 == pytest.approx(0.0, abs=1e-7)
    assert np.abs(carrier - baseband)[25:].max() < 0.005 * np.abs(baseband[-1])
    assert np.abs(carrier - baseband)[1000:].max() < 1e-4 * np.abs(baseband[-1])


def with_delays(samples: int) -> Graph:
    """The loop with a register more or less: the graph has one already."""
    graph = library("quartz_accelerometer")
    line = DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, *[0.0] * samples))
    return replace(graph, blocks={**graph.blocks, "computing": line})


def test_margins_of_the_loop() -> None:
    """Those of the loop with its one sample of delay, by python-control and closed-loop poles [A]."""
    found = margins(library("quartz_accelerometer"), "da2.voltage").as_data()
    assert found["gain_margin_db"] == pytest.approx(22.48, abs=0.01)
    assert found["phase_margin_deg"] == pytest.approx(88.5, abs=0.05)
    assert found["delay_margin_s"] == pytest.approx(746.8e-6, abs=0.05e-6)
    assert found["gain_crossovers_hz"] == [pytest.approx(329.2, abs=0.06)]
    assert found["bandwidth_hz"] == pytest.approx(342.0, abs=0.5)
    assert found["sensitivity_peak_db"] == pytest.approx(1.45, abs=0.005)


@pytest.mark.exhaustive
def test_first_unstable_delay_is_39_samples() -> None:
    assert margins(with_delays(38), "da2.voltage").stable
    assert not margins(with_delays(39), "da2.voltage").stable
    assert margins(with_delays(1), "da2.voltage").poles == pytest.approx(
        margins(library("quartz_accelerometer"), "da2.voltage").poles, abs=1e-12
    )
