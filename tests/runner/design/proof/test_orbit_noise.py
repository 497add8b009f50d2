"""Noise on orbits: closed forms, `noise` itself, brute force over random loops, forged certificates."""

import itertools
import math
import random
from typing import Any

import pytest

from proofmass import noise
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import amounts, chosen
from tests.by_hand.orbiting_loops import (
    DEMODULATED,
    SIGMA,
    MixedLoop,
    carrier_of,
    demodulated_rms,
    with_noise,
)
from tests.runner.design.proof.test_prove import status
from tests.runner.verification.test_certificates import forged

LOOP = read_graph_text(with_noise(DEMODULATED))
WITHIN = {"level.value": "5 %", "gain.gain": "5 %"}
CORNERS = list(itertools.product((0.95, 1.05), (95.0, 105.0)))
WORST = max(demodulated_rms(*corner) for corner in CORNERS)
STEP = 0.1  # of a converter


def found(limit: Any, graph: Graph = LOOP, **given: Any) -> Proofs:
    return prove(graph, noise={"plant.output": limit}, **({"tolerances": WITHIN, "workers": 1} | given))


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return found(1.03 * WORST)


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_a_limit_is_proved_up_to_the_closed_form(proved: Proofs) -> None:
    (proof,) = proved.proofs
    assert (proof.status, proof.claim.orbit) == ("proved", pytest.approx(4e-3))


@pytest.mark.exhaustive
def test_a_limit_below_the_closed_form_is_refuted_by_a_sensor() -> None:
    broken = found(0.999 * WORST)
    assert status(broken) == ["refuted"]
    sensor = broken.proofs[0].counterexample or {}
    assert demodulated_rms(sensor["level.value"], sensor["gain.gain"]) > 0.999 * WORST
    assert "noise GRAPH --output plant.output" in proofs_text(broken)


@pytest.mark.parametrize("others", amounts(0, 4))
def test_noise_finds_no_sensor_above_what_is_proved(proved: Proofs, others: int) -> None:
    """It is the mean over the orbit of the variance that both speak of."""
    rng, limit = random.Random(1), proved.proofs[0].claim.limit
    for level, gain in [*CORNERS, *((rng.uniform(0.95, 1.05), rng.uniform(95.0, 105.0)) for _ in range(others))]:
        sensor = LOOP.with_parameters({"level.value": level, "gain.gain": gain})
        rms = noise(sensor, "plant.output", at="periodic").rms
        assert rms == pytest.approx(demodulated_rms(level, gain), rel=1e-9)
        assert rms < limit


def test_without_tolerances_the_sensor_itself_has_a_bound() -> None:
    rms = demodulated_rms(1.0, 100.0)
    assert status(found(1.001 * rms, tolerances=None)) == ["proved"]
    assert status(found(0.999 * rms, tolerances=None)) == ["refuted"]
    (least,) = found("", tolerances=None).proofs
    assert least.status == "proved"
    assert rms < least.claim.limit < 1.02 * rms


@pytest.mark.exhaustive
def test_errors_of_a_converter_count_on_an_orbit() -> None:
    """A step q of the converter has an error of rms q / sqrt(12), in the ticks in which the carrier is not zero."""
    wires = '"plant.output -> adc.voltage", "adc.number -> curve.temperature"'
    text = DEMODULATED.replace('"plant.output -> curve.temperature"', wires).replace("c1 = 1.0", f"c1 = {STEP}")
    text = text.replace("c2 = 0.5", f"c2 = {0.5 * STEP**2}").replace('output_unit = "1"', 'output_unit = "V"')
    text += f'[blocks.adc]\nkind = "AnalogToDigital"\nreference = {2048.0 * STEP}\n'
    sensor, rms = read_graph_text(with_noise(text)), demodulated_rms(1.0, 100.0, STEP / math.sqrt(12.0))
    assert rms > 1.005 * demodulated_rms(1.0, 100.0)
    assert status(found(1.001 * rms, sensor, tolerances=None, at="settled")) == ["proved"]
    assert status(found(0.999 * rms, sensor, tolerances=None, at="settled")) == ["refuted"]


def test_noise_of_a_loop_at_rest_is_that_of_one_period() -> None:
    """With a constant in the place of the carrier, x' = x + k (u + w - x - x^2 / 2): an orbit of one period."""
    text = with_noise(DEMODULATED).replace('kind = "Sine"\nfrequency = "250 Hz"', 'kind = "Constant"\nvalue = 1.0')
    a = 1.0 - 0.1 * math.sqrt(3.0)  # 1 + x is sqrt(1 + 2 u)
    rms = 0.1 * SIGMA / math.sqrt(1.0 - a * a)
    for off, said in ((1.001, "proved"), (0.999, "refuted")):
        answer = found(off * rms, read_graph_text(text), tolerances=None)
        assert status(answer) == [said]
        assert (answer.proofs[0].claim.at_rest, answer.proofs[0].claim.orbit) == (True, 0.0)


def test_noise_under_any_change_on_an_orbit_is_open() -> None:
    answer = found(1.01 * WORST, any_change=True)
    assert status(answer) == ["open"]
    assert "parameters that stay as they are" in answer.proofs[0].searched.why


@pytest.mark.exhaustive
def test_noise_without_a_bound_on_an_orbit_is_not_proved() -> None:
    """At a gain of 1000 the slope is (1 - 2.236)^2."""
    assert "proved" not in status(found(1e6, tolerances={"gain.gain": [90.0, 1000.0]}, seconds=2.0))


# -- brute force -------------------------------------------------------------------------------------------------------

NAMES = {"level": "level.value", "gain": "gain.gain", "shake": "shake.gain", "depth": "depth.gain"}


@pytest.mark.parametrize("seed", chosen((1,), (0, *range(2, 30))))
def test_no_proof_and_no_refutation_is_false(seed: int) -> None:
    """Corners and random places of a box, by covariances of a program of its own."""
    rng = random.Random(seed)
    ticks = rng.randint(2, 6)
    cycles, phase, width = (
        rng.randint(1, ticks - 1),
        rng.choice([0.0, rng.uniform(0.0, 6.28)]),
        rng.choice([0.01, 0.05]),
    )
    middle = {
        "level": rng.uniform(-0.3, 1.5), "shake": rng.uniform(0.0, 1.0), "depth": rng.uniform(0.0, 1.2),
        "gain": rng.uniform(50.0, 600.0), "bend": rng.uniform(-0.2, 0.4),
    }  # fmt: skip
    names = rng.sample(sorted(NAMES), 2)
    places = list(itertools.product((-1.0, 1.0), repeat=2))
    places += [(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)) for _ in range(20)]
    moved = [{n: middle[n] * (1.0 + width * by) for n, by in zip(names, place, strict=True)} for place in places]
    carrier = carrier_of(cycles, ticks, phase)
    largest = max(MixedLoop(**(middle | one)).rms(carrier) for one in moved)
    limit = rng.choice([0.98, 1.03, 1.1, 1.3]) * (largest if math.isfinite(largest) else 1.0)
    answer = found(
        limit, MixedLoop(**middle).graph(cycles, ticks, phase, noisy=True),
        tolerances={NAMES[name]: f"{100.0 * width} %" for name in names}, seconds=8.0, at="settled",
    )  # fmt: skip
    (proof,) = answer.proofs
    if proof.status == "proved":
        assert largest < limit * (1.0 + 1e-9)
        assert check_certificate(certificate(answer))
    if proof.status == "refuted":
        sensor = {name: (proof.counterexample or {}).get(NAMES[name], middle[name]) for name in names}
        assert MixedLoop(**(middle | sensor)).rms(carrier) > limit * (1.0 - 1e-9)


# -- certificates ------------------------------------------------------------------------------------------------------


def _lower(c: Any) -> None:
    claim = c["claims"][0]
    claim["limit"] *= 0.95
    claim["ends"] = [claim["limit"]] * 2
    for leaf in claim["leaves"]:
        leaf["box"][-1] = claim["ends"]


def _more_noise(c: Any) -> None:
    for loop in c["loops"]:
        for corner in loop["corners"]["middle"]:
            corner[0][-1] *= 3.0


def _no_orbit(c: Any) -> None:
    for loop in c["loops"]:
        del loop["rest"]


def _nearer(c: Any) -> None:
    for loop in c["loops"]:
        loop["rest"]["reach"] = [0.5 * reach for reach in loop["rest"]["reach"]]


def _at_the_start(c: Any) -> None:
    c["claims"][0]["at_rest"] = False


def _in_continuous_time(c: Any) -> None:
    c["claims"][0]["continuous"] = True


@pytest.mark.parametrize(
    "change",
    [_lower, _more_noise, _no_orbit, _nearer, _at_the_start, _in_continuous_time],
    ids=lambda one: one.__name__,
)
def test_a_forged_certificate_is_refused(proved: Proofs, change: Any) -> None:
    text = certificate(proved)
    (line,) = check_certificate(text)
    assert line.startswith(f"plant.output, noise of at most {1.03 * WORST!r} on an orbit of 0.004 s: ")
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(text, change))
