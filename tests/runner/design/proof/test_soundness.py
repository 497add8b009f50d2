"""Proofs against the truth: loops whose matrices are written down by hand, boxes that exact fractions decide."""

import itertools
import math
import random
from collections.abc import Callable, Mapping
from fractions import Fraction

import numpy as np
import pytest
import scipy.optimize

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.design.proof.prove import MarginProof, prove, prove_margin
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.toleranced_loops import RATE, Loop, random_loop

Factors = Callable[[float], complex]  # by a number from -1 to 1
SECONDS = 6.0  # of a search
SAMPLE = (1, 21, 40)
OTHERS = (0, 4, 8, 9)  # for other claims than gain and phase margins
_BORDER = 1e-9  # of a pole, by which eigenvalues in doubles may be wrong


def factors(proof: MarginProof) -> Factors:
    """The factors at the wire of a claim."""
    limit = proof.claim.limit
    if proof.claim.kind == "gain margin":
        return lambda part: complex(10.0 ** (part * limit / 20.0))
    if proof.claim.kind == "phase margin":
        return lambda part: complex(np.exp(1j * part * math.radians(limit)))
    return lambda part: 1.0 + 0.0j


def sensor(loop: Loop, place: Mapping[str, float]) -> dict[str, float]:
    """The parameters at a place of the box, -1 to 1 along each side."""
    return loop.values | {n: loop.values[n] * (1.0 + loop.tolerances[n] * place[n]) for n in place}


def worst_radius(loop: Loop, factor: Factors, draw: random.Random) -> float:
    """The largest pole at all corners and random places of the box, and after a descent from the worst of them."""
    names = list(loop.tolerances)

    def radius(place: tuple[float, ...]) -> float:
        *where, part = np.clip(place, -1.0, 1.0)
        return loop.radius(sensor(loop, dict(zip(names, where, strict=True))), factor(part))

    places = list(itertools.product((-1.0, 1.0), repeat=len(names) + 1))
    places += [tuple(draw.uniform(-1.0, 1.0) for _ in range(len(names) + 1)) for _ in range(40)]
    worst = max(places, key=radius)
    found = scipy.optimize.minimize(
        lambda place: -radius(tuple(place)), 0.98 * np.array(worst), method="Nelder-Mead", options={"maxfev": 80}
    )
    return max(radius(worst), radius(tuple(found.x)))


def largest_factor(loop: Loop, values: Mapping[str, float], factor: Factors) -> float:
    """The largest pole of one sensor with any of the factors."""
    parts = np.linspace(-1.0, 1.0, 201)
    sizes = [loop.radius(values, factor(part)) for part in parts]
    best = int(np.argmax(sizes))
    around = parts[max(best - 1, 0)], parts[min(best + 1, 200)]
    refined = scipy.optimize.minimize_scalar(
        lambda part: -loop.radius(values, factor(part)), bounds=around, method="bounded", options={"xatol": 1e-10}
    )
    return max(*sizes, -float(refined.fun))


@pytest.mark.parametrize("seed", chosen(SAMPLE, [seed for seed in range(200) if seed not in SAMPLE]))
def test_no_proof_and_no_refutation_is_false(seed: int) -> None:
    loop, draw = random_loop(seed), random.Random(seed)
    limits = draw.choice((1.0, 3.0, 6.0)), draw.choice((10.0, 30.0, 45.0))
    found = prove(
        loop.graph(),
        tolerances={name: f"{100.0 * width} %" for name, width in loop.tolerances.items()},
        gain_margin=f"{limits[0]} dB",
        phase_margin=f"{limits[1]} deg",
        seconds=SECONDS,
    )
    for proof in found.proofs:
        factor = factors(proof)
        if proof.status == "proved":
            assert worst_radius(loop, factor, draw) < 1.0 + _BORDER, proof.claim
        if proof.status == "refuted":
            assert proof.counterexample is not None
            broken = loop.values | dict(proof.counterexample)
            assert all(
                abs(broken[n] / loop.values[n] - 1.0) <= loop.tolerances[n] + 1e-12 for n in proof.counterexample
            )
            assert largest_factor(loop, broken, factor) > 1.0 - _BORDER, proof.claim


MEASURED = {"disk margin": Loop.disk_margin, "delay margin": Loop.delay_margin, "decay rate": Loop.decay_rate}


@pytest.mark.exhaustive("8")
@pytest.mark.parametrize("seed", chosen(OTHERS, [seed for seed in range(200) if seed not in OTHERS]))
def test_no_proof_of_other_figures_is_false(seed: int) -> None:
    """The least of each figure at all corners and at random places, and at the sensor that is named."""
    loop, draw = random_loop(seed), random.Random(seed)
    if loop.radius(loop.values) > 0.9999 or loop.ticks > 1:
        return
    kinds = {
        kind: min(measure(loop, loop.values), 1.8 if kind == "disk margin" else 1.0)
        for kind, measure in MEASURED.items()
    }
    limits = {kind: value * draw.choice((0.5, 0.8, 0.95, 1.05)) for kind, value in kinds.items()}
    found = prove(
        loop.graph(),
        tolerances={name: f"{100.0 * width} %" for name, width in loop.tolerances.items()},
        disk_margin=f"{limits['disk margin']!r}",
        delay_margin=f"{limits['delay margin']!r} s",
        decay_rate=f"{limits['decay rate']!r} 1/s",
        seconds=SECONDS,
    )
    places = list(itertools.product((-1.0, 1.0), repeat=len(loop.tolerances)))
    places += [tuple(draw.uniform(-1.0, 1.0) for _ in loop.tolerances) for _ in range(10)]
    sensors = [sensor(loop, dict(zip(loop.tolerances, place, strict=True))) for place in places]
    for proof in found.proofs[3:]:
        kind, limit = proof.claim.kind, limits[proof.claim.kind]
        if proof.status == "proved":
            assert all(loop.radius(one) < 1.0 for one in sensors)
            assert min(MEASURED[kind](loop, one) for one in sensors) > limit * (1.0 - 1e-9), proof.claim
        if proof.status == "refuted":
            broken = loop.values | dict(proof.counterexample or {})
            assert loop.radius(broken) > 1.0 - _BORDER or MEASURED[kind](loop, broken) < limit * (1.0 + 1e-4), (
                proof.claim
            )
    if any(proof.status == "proved" for proof in found.proofs):
        assert len(check_certificate(certificate(found))) == sum(proof.status == "proved" for proof in found.proofs)


# -- the border of a loop of second order, in exact fractions ----------------------------------------------------------

SECOND = f"""
name = "second order"
rate = "{RATE} Hz"
samples = 16
wires = ["minus.output -> gain.input", "gain.output -> inner.first", "back.output -> inner.second",
         "inner.output -> first.input", "first.output -> back.input", "first.output -> second.input",
         "second.output -> minus.input"]
probes = ["gain.output"]
[loops.main]
open_at = "gain.output"
[blocks.minus]
kind = "Negation"
[blocks.gain]
kind = "Gain"
[blocks.inner]
kind = "Difference"
[blocks.back]
kind = "Gain"
[blocks.first]
kind = "DiscreteIntegrator"
output_unit = "1"
[blocks.second]
kind = "DiscreteIntegrator"
output_unit = "1"
"""


def is_stable(gain: Fraction, back: Fraction, first: Fraction, second: Fraction) -> bool:
    """Jury's conditions of z^2 + p z + q, for x' = x + f T (-g y - b x), y' = y + s T x."""
    t = Fraction(1, RATE)
    p = first * t * back - 2
    q = 1 - first * t * back + first * second * gain * t * t
    return abs(q) < 1 and abs(p) < 1 + q


BORDERS = [
    Fraction(sign * mantissa, 10**digits) for digits in (1, 3, 6, 9, 12, 15) for sign in (-1, 1) for mantissa in (1, 3)
]
NEAR = (Fraction(3, 10), Fraction(-1, 1000), Fraction(-1, 10**9))


@pytest.mark.parametrize("off", chosen(NEAR, [one for one in BORDERS if one not in NEAR]), ids=str)
def test_a_box_that_ends_at_the_border_is_proved_where_all_of_it_is_stable(off: Fraction) -> None:
    """It oscillates at q = 1, second gain T = back: all of the box is stable if its worst corner is."""
    draw = random.Random(off.numerator)
    back, first = 2.0 ** draw.randint(-1, 2), 2.0 ** draw.randint(4, 6)
    gain = draw.uniform(0.5, 2.0) * 8.0
    end = float(Fraction(back) * RATE / Fraction(gain) * (1 - off))  # of the second gain
    graph = read_graph_text(SECOND).with_parameters(
        {"gain.gain": gain, "back.gain": back, "first.gain": first, "second.gain": 0.9 * end}
    )
    seconds = 60.0 if off <= Fraction(-1, 1000) or off >= Fraction(1, 10) else SECONDS  # these have an answer
    within = {"second.gain": [0.8 * end, end], "first.gain": "10 %"}
    proof = prove_margin(graph, "main", "stable", 0.0, within, seconds=seconds)
    firsts = [Fraction(first) * part for part in (Fraction(9, 10), Fraction(11, 10))]
    all_stable = all(is_stable(Fraction(gain), Fraction(back), f, Fraction(end)) for f in firsts)
    assert all_stable == (off > 0)
    if proof.status == "proved":
        assert all_stable
    if proof.status == "refuted":
        assert proof.counterexample is not None
        at = {name: Fraction(value) for name, value in proof.counterexample.items()}
        assert not is_stable(Fraction(gain), Fraction(back), at["first.gain"], at["second.gain"])
    if off >= Fraction(1, 10):
        assert proof.status == "proved"
    if off <= Fraction(-1, 1000):
        assert proof.status == "refuted"
