"""Roundings of random chains of fixed-point blocks against runs: a chain less the same with many more bits.

`python -m tests.runner.analysis.noise.test_fixed_chains FIRST LAST` compares others.
"""

import math
import sys
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, ModelError, deviation_over_runs, noise, simulate
from proofmass.blocks import FixedGain, FixedQuantiser, FixedToNumber, WhiteNoise
from proofmass.blocks.arithmetic.fixed_point import Fixed, Rounding
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget, NoiseSource
from tests.by_hand.fixed_chains import OUTPUT, RATE, fixed_chain
from tests.runner.analysis.noise.test_random_graphs import FINE, SEGMENT, expected

PARTS = 16
BANDS = slice(2, 8), slice(8, 20), slice(20, 31)  # lines
MOST = 5.0  # standard errors
LEAST_ERROR = 0.01  # of a mean square
LEAST = 1e-4  # of the largest density
SAMPLE = 57
SETTLED = 400  # values
SPREAD = 0.03  # part of a deviation
DOUBTFUL = 0.01  # share of a source in the roundings


def rounding_of(budget: NoiseBudget) -> tuple[float, np.ndarray, bool]:
    """Return mean square and density of the roundings after the first, and whether they are in doubt."""
    after = [source for source in budget.sources if source.kind == "rounding"]
    square = sum(source.rms**2 for source in after)
    doubt = any(source.doubtful and source.rms**2 > DOUBTFUL * square for source in after)
    return square, np.sum([source.density for source in after], axis=0), doubt


def distances(number: int, values: int) -> tuple[list[float], bool]:
    """Return by how many standard errors the mean square of a run, and of bands, differs; and whether it is told."""
    graph, fine = fixed_chain(number), fixed_chain(number, fine=True)
    lines = np.arange(1, FINE * SEGMENT // 2) * RATE / (FINE * SEGMENT)
    square, density, doubt = rounding_of(noise(graph, OUTPUT, frequencies=lines.tolist()))
    narrow, wide = (np.asarray(simulate(of, samples=values + 200, seed=3)[OUTPUT].values) for of in (graph, fine))
    error = (narrow - wide)[200:]
    error -= error.mean()
    if square == 0.0:
        return [0.0 if np.abs(error).max() < 1e-9 else math.inf], doubt
    window = np.hanning(SEGMENT + 1)[:-1]
    spectra = np.abs(np.fft.rfft(error[: len(error) // SEGMENT * SEGMENT].reshape(-1, SEGMENT) * window, axis=1)) ** 2
    spectra *= 2.0 / (RATE * np.sum(window**2))
    density = expected(density)
    found = [(np.mean(error[: len(error) // PARTS * PARTS].reshape(PARTS, -1) ** 2, axis=1), square)]
    for band in BANDS:
        if density[band].min() > LEAST * density.max():
            ratio = np.mean(spectra[:, band] / density[band], axis=1)
            found.append((np.array([part.mean() for part in np.array_split(ratio, PARTS)]), 1.0))
    far = []
    for parts, whole in found:
        deviation = max(float(np.std(parts, ddof=1)) / math.sqrt(PARTS), LEAST_ERROR * whole)
        far.append((float(parts.mean()) - whole) / deviation)
    return far, doubt


def worst_of(number: int, values: int) -> float:
    """Return the largest distance of a chain, 0 where a doubt is told, or no noise is left."""
    try:
        far, doubt = distances(number, values)
    except ModelError:
        return 0.0
    return 0.0 if doubt else max(map(abs, far))


def spread_apart(number: int, values: int) -> float:
    """Return by which part the deviation over runs of the roundings is off that of a run, 0 where a doubt is told."""
    graph, fine = fixed_chain(number), fixed_chain(number, fine=True)
    try:
        found = deviation_over_runs(graph, OUTPUT, until=SETTLED / RATE)
    except ModelError:
        return 0.0
    rms = math.hypot(*(of for name, of in found.sources.items() if name not in ("noise", "quantiser", "corner")))
    narrow, wide = (np.asarray(simulate(of, samples=values + SETTLED, seed=3)[OUTPUT].values) for of in (graph, fine))
    run = float(np.std((narrow - wide)[SETTLED:]))
    return 0.0 if found.notes else abs(rms - run) / max(rms, run, 1e-9)


def gain_budget(gain: float, steps: float, **options: Any) -> NoiseSource:
    """Return the rounding of a gain of 14 fraction bits, whose input is moved by so many steps."""
    format = Fixed(16, 8)
    blocks: dict[str, Block] = {
        "noise": WhiteNoise(density=steps * 2.0**-8 * math.sqrt(2.0 / RATE)),
        "quantiser": FixedQuantiser(output_format=format),
        "gain": FixedGain(gain=gain, input_format=format, output_format=format, **options),
        "number": FixedToNumber(input_format=format),
    }
    wires = ["noise.output -> quantiser.input", "quantiser.output -> gain.input", "gain.output -> number.input"]
    found = noise(Graph(name="gain", rate=RATE, blocks=blocks, wires=wires), OUTPUT)
    return next(source for source in found.sources if source.block == "gain")


@pytest.mark.defect(
    "S830",
    before="0.289 steps rms of a gain of 0.5, and of 1 or 2, of 14 fraction bits",
    after="0.354 steps, and none",
)
@pytest.mark.exhaustive(but=7)
@pytest.mark.parametrize("rounding", ["half_even", "half_up", "floor"])
@pytest.mark.parametrize("gain", [0.5, 0.75, 1.0, 1.25, 2.0])
def test_bits_that_are_always_zero_are_not_dropped(gain: float, rounding: Rounding) -> None:
    """The error of a factor of few bits takes few values, which are counted one by one."""
    source = gain_budget(gain, 10.0, rounding=rounding)
    products = [Fraction(gain) * word for word in range(-1024, 1024)]
    nearest = {"half_even": round, "half_up": lambda x: math.floor(x + Fraction(1, 2)), "floor": math.floor}
    errors = [float(nearest[rounding](product) - product) for product in products]
    assert source.rms * 2.0**8 == pytest.approx(float(np.std(errors)), abs=1e-9)
    assert not source.doubtful


@pytest.mark.defect("S831", before="no doubt, at 0.289 steps rms", after="the same in doubt, with a note")
@pytest.mark.parametrize(
    ("gain", "steps", "doubtful"),
    [(1.51, 3.0, True), (1.51, 60.0, False), (1.002, 10.0, True), (0.334, 3.0, True), (0.61, 10.0, False)],
)
def test_words_that_a_factor_hardly_tells_apart(gain: float, steps: float, doubtful: bool) -> None:
    """A gain near a ratio of small numbers gives a few words few errors; many words have all."""
    words = np.rint(steps * np.random.default_rng(1).normal(size=200_000))
    product = round(gain * 2**14) / 2**14 * words
    error = np.rint(product) - product
    off = abs(12.0 * float(np.mean(error**2)) - 1.0)
    assert (off > 0.01) == doubtful
    assert gain_budget(gain, steps).doubtful == doubtful


@pytest.mark.defect(
    "S831", before="chains of few bits are up to 90 % off without a note", after="5 standard errors, or a note"
)
@pytest.mark.parametrize("number", [SAMPLE])
def test_chains_round_as_in_a_run(number: int) -> None:
    assert worst_of(number, 1 << 13) < MOST


@pytest.mark.exhaustive
@pytest.mark.defect(
    "S804", before="48 of 70 chains spread 3 % to a factor of 12 otherwise than runs, without a note", after="none"
)
@pytest.mark.parametrize("number", range(70))
def test_chains_spread_as_runs(number: int) -> None:
    assert spread_apart(number, 1 << 14) < SPREAD


@pytest.mark.exhaustive
@pytest.mark.parametrize("number", range(120))
def test_many_chains_round_as_in_a_run(number: int) -> None:
    assert worst_of(number, 1 << 16) < MOST


if __name__ == "__main__":
    for number in range(*map(int, sys.argv[1:3])):
        if (apart := spread_apart(number, 1 << 14)) > SPREAD:
            print(number, f"spread {100.0 * apart:.0f} % off")
        try:
            far, doubt = distances(number, 1 << 16)
        except ModelError as error:
            print(number, "no budget", str(error)[:90])
            continue
        if doubt or max(map(abs, far)) > MOST:
            print(number, "told" if doubt else "SILENT", [f"{each:.1f}" for each in far])
