"""Rounding within fixed-point blocks: its noise against runs in which the same filter has more bits.

White noise goes into a converter of 20 bits, and that into a second-order section of 12. What a section of 40 bits
makes of the same mantissas differs by the rounding errors of the narrow one alone.
"""

import math
from typing import get_args

import numpy as np
import pytest
from scipy.stats import chi2

from proofmass import Graph, ModelError, noise, simulate, spectrum
from proofmass.blocks import (
    Constant,
    Decimator,
    FixedCast,
    FixedGain,
    FixedProduct,
    FixedQuantiser,
    FixedSecondOrderSection,
    FixedSineTable,
    FixedSum,
    FixedToNumber,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Rounding
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget

RATE = 1000.0
NARROW, FINE = Fixed(14, 10), Fixed(40, 32)
COEFFICIENTS = {"b0": 0.02, "b1": 0.04, "b2": 0.02, "a1": -1.5625, "a2": 0.640625}
OUTPUT = Fixed(12, 7)


def graph(state: Fixed, output: Fixed, amplitude: float = 1.0) -> Graph:
    """A quantised noise through a resonant low-pass filter with these formats."""
    source = Fixed(20, 12)
    blocks: dict[str, Block] = {
        "white": WhiteNoise(density=amplitude * math.sqrt(2.0 / RATE)),
        "quantiser": FixedQuantiser(output_format=source),
        "section": FixedSecondOrderSection(
            **COEFFICIENTS, input_format=source, coefficient_format=Fixed(18, 14), state_format=state,
            output_format=output,
        ),
        "number": FixedToNumber(input_format=output),
    }  # fmt: skip
    wires = ["white.output -> quantiser.input", "quantiser.output -> section.input", "section.output -> number.input"]
    return Graph(name="fixed", rate=RATE, blocks=blocks, wires=wires, probes=["number.output"])


def section_rms(of: Graph, **options: object) -> tuple[float, np.ndarray]:
    found = noise(of, "number.output", **options)  # type: ignore[arg-type]
    (source,) = [source for source in found.sources if source.block == "section"]
    assert source.kind == "rounding"
    assert not source.doubtful
    return source.rms, source.density


def test_closed_form_of_the_rounding_of_a_section() -> None:
    """The error of y goes through 1 / A(z), that of the output nowhere: 1/12 of a step squared, and more by ties."""
    rms, _ = section_rms(graph(NARROW, OUTPUT))
    a1, a2 = COEFFICIENTS["a1"], COEFFICIENTS["a2"]
    gain = (1.0 + a2) / ((1.0 - a2) * ((1.0 + a2) ** 2 - a1**2))  # sum of squares of the impulse response of 1 / A
    dropped = 12 + 14 - 10, 10 - 7
    state, output = (
        2.0**-fraction * math.sqrt((1.0 + 2.0 * 4.0**-bits) / 12.0)
        for fraction, bits in zip((10, 7), dropped, strict=True)
    )
    assert rms**2 == pytest.approx(state**2 * gain + output**2, rel=1e-9)


@pytest.mark.exhaustive
def test_rounding_is_that_of_a_run() -> None:
    """The narrow section less the wide one, in rms and in spectrum."""
    values = 1 << 16
    narrow, wide = (
        np.asarray(simulate(graph(*formats), samples=values, seed=5)["number.output"].values)
        for formats in ((NARROW, OUTPUT), (FINE, FINE))
    )
    error = (narrow - wide)[1000:]
    found = spectrum(error, rate=RATE, segment=256)
    lines = slice(3, -2)
    rms, density = section_rms(graph(NARROW, OUTPUT), frequencies=found.frequencies[lines].tolist())
    assert np.std(error) == pytest.approx(rms, rel=0.01)
    low, high = chi2.ppf([0.005, 0.995], found.freedom) / found.freedom
    ratio = found.density[lines] / density
    assert np.mean((low <= ratio) & (ratio <= high)) > 0.95


def test_a_filter_that_noise_hardly_moves_is_doubtful() -> None:
    """Noise of a hundredth of a step: the error is no noise, which is told."""
    found = noise(graph(NARROW, Fixed(12, 3), amplitude=1e-3), "number.output")
    (source,) = [source for source in found.sources if source.block == "section"]
    assert source.doubtful
    assert any(note.startswith("section: noise moves its input by") for note in found.notes)


def test_bits_that_are_not_dropped_make_no_noise() -> None:
    """A gain of one bit, and a cast to more bits, are exact."""
    first, second = Fixed(20, 12), Fixed(30, 20)
    blocks: dict[str, Block] = {
        "white": WhiteNoise(density=0.01),
        "quantiser": FixedQuantiser(output_format=first),
        "gain": FixedGain(gain=2.0, input_format=first, gain_format=Fixed(4, 0), output_format=Fixed(24, 12)),
        "cast": FixedCast(input_format=Fixed(24, 12), output_format=second),
        "number": FixedToNumber(input_format=second),
    }
    wires = ["white.output -> quantiser.input", "quantiser.output -> gain.input", "gain.output -> cast.input"]
    found = noise(
        Graph(name="", rate=RATE, blocks=blocks, wires=[*wires, "cast.output -> number.input"]), "number.output"
    )
    assert {source.block for source in found.sources if source.rms > 0.0} == {"white", "quantiser"}


@pytest.mark.exhaustive("-3")
@pytest.mark.parametrize("bits", [1, 3])
@pytest.mark.parametrize("rounding", get_args(Rounding))
def test_errors_of_all_rules_of_rounding(rounding: Rounding, bits: int) -> None:
    """The variance over all mantissas of either sign, counted one by one."""
    first, second = Fixed(20, 12), Fixed(20, 12 - bits)
    blocks: dict[str, Block] = {
        "white": WhiteNoise(density=1.0),
        "quantiser": FixedQuantiser(output_format=first),
        "cast": FixedCast(input_format=first, output_format=second, rounding=rounding),
        "number": FixedToNumber(input_format=second),
    }
    wires = ["white.output -> quantiser.input", "quantiser.output -> cast.input", "cast.output -> number.input"]
    found = noise(Graph(name="", rate=RATE, blocks=blocks, wires=wires), "number.output")
    (cast,) = [source for source in found.sources if source.block == "cast"]
    errors = [cast_of(FixedValue(m, 12), second, rounding) - m / 2.0**12 for m in range(-(2**10), 2**10 + 1)]
    assert cast.rms == pytest.approx(float(np.std(errors)), rel=2e-3)


def cast_of(value: FixedValue, format: Fixed, rounding: Rounding) -> float:
    return float(value.to(format, rounding))


def budget(*wires: str, **blocks: Block) -> NoiseBudget:
    whole = {"white": WhiteNoise(density=0.01 * math.sqrt(2.0 / RATE)), **blocks}
    return noise(Graph(name="words", rate=RATE, blocks=whole, wires=wires), "number.output")


def rms_of_rounding(fraction: int, dropped: int) -> float:
    """Of the nearest step, ties to even."""
    return 2.0**-fraction * math.sqrt((1.0 + 2.0 * 4.0**-dropped) / 12.0)


@pytest.mark.defect(
    "S693",
    before="noise through a fixed-point word that is squared at 0 ends with an AttributeError",
    after="the closed forms of the roundings",
)
def test_a_word_that_no_longer_depends_on_noise() -> None:
    """The square of a word has no slope at 0, where it is: its own rounding does not move, and the word goes on."""
    word, sum_format = Fixed(20, 12), Fixed(20, 10)
    found = budget(
        "white.output -> quantiser.input",
        "quantiser.output -> square.first",
        "quantiser.output -> square.second",
        "square.output -> sum.first",
        "quantiser.output -> sum.second",
        "sum.output -> number.input",
        quantiser=FixedQuantiser(output_format=word),
        square=FixedProduct(first_format=word, second_format=word, output_format=word),
        sum=FixedSum(input_format=word, output_format=sum_format),
        number=FixedToNumber(input_format=sum_format),
    )
    parts = {source.block: source.rms for source in found.sources if source.rms}
    assert parts == pytest.approx(
        {"white": 0.01, "quantiser": 2.0**-12 / math.sqrt(12.0), "sum": rms_of_rounding(10, 2)}, rel=1e-12
    )


@pytest.mark.defect(
    "S694",
    before="a converter that is given its own words adds the noise of a rounding, and a stored coefficient too",
    after="neither has any: their errors stand still",
)
def test_errors_that_stand_still() -> None:
    word, coefficient = Fixed(12, 11), Fixed(8, 6)
    found = budget(
        "white.output -> adc.input",
        "adc.output -> between.input",
        "between.output -> again.input",
        "stored.output -> coefficient.input",
        "again.output -> product.first",
        "coefficient.output -> product.second",
        "product.output -> number.input",
        adc=FixedQuantiser(output_format=word),
        between=FixedToNumber(input_format=word),
        again=FixedQuantiser(output_format=word),
        stored=Constant(value=0.7),
        coefficient=FixedQuantiser(output_format=coefficient),
        product=FixedProduct(first_format=word, second_format=coefficient, output_format=Fixed(20, 17)),
        number=FixedToNumber(input_format=Fixed(20, 17)),
    )
    parts = {source.block: source.rms for source in found.sources if source.rms}
    factor = round(0.7 * 2**6) / 2**6
    step = 2.0**-11
    assert parts == pytest.approx({"white": 0.01 * factor, "adc": factor * step / math.sqrt(12.0)}, rel=1e-9)


@pytest.mark.defect("S828", before="1.15 steps rms, no doubt", after="the same, with a note on the 0.68 steps of a run")
@pytest.mark.parametrize(("motion", "doubtful"), [(1.0, True), (4.0, True), (60.0, False)])
def test_a_cut_magnitude_errs_against_its_sign(motion: float, doubtful: bool) -> None:
    """A run has 0.4 steps less than goes in, as E[x e] of a Gaussian x is -s / sqrt(2 pi): the budget has more."""
    word, step = Fixed(30, 20), 2.0**-10
    rng = np.random.default_rng(1)
    run = float(np.std(np.trunc(motion * rng.normal(size=100_000))))
    found = budget(
        "hiss.output -> quantiser.input",
        "quantiser.output -> cast.input",
        "cast.output -> number.input",
        hiss=WhiteNoise(density=motion * step * math.sqrt(2.0 / RATE)),
        quantiser=FixedQuantiser(output_format=word),
        cast=FixedCast(input_format=word, output_format=Fixed(20, 10), rounding="toward_zero"),
        number=FixedToNumber(input_format=Fixed(20, 10)),
    )
    (cast,) = [source for source in found.sources if source.block == "cast"]
    assert cast.doubtful == doubtful
    assert any("towards zero" in note for note in found.notes) == doubtful
    assert found.rms / step == pytest.approx(run, rel=0.02) or doubtful
    assert run == pytest.approx(motion - 0.4, rel=0.15)


@pytest.mark.defect("S1058", before="over 32 ticks 1.25e-5 of what is 8.7e-4 in a run, without a note", after="refused")
@pytest.mark.parametrize("ratio", [8, 32, 100])
def test_noise_through_bits_is_refused_over_any_number_of_ticks(ratio: int) -> None:
    """Bits of a phase choose an entry of a sine table: noise moves it from entry to entry, and bits have no slope."""
    blocks: dict[str, Block] = {
        "white": WhiteNoise(density=1e-3),
        "before": FixedQuantiser(output_format=Fixed(12, 12)),
        "sine": FixedSineTable(phase_bits=12, fraction_bits=10),
        "number": FixedToNumber(input_format=Fixed(12, 10)),
        "behind": WhiteNoise(density=1e-6),
        "both": Sum(),
        "mean": Decimator(ratio=ratio),
    }
    wires = ["white.output -> before.input", "before.output -> sine.phase", "sine.sine -> number.input"]
    wires += ["number.output -> both.first", "behind.output -> both.second", "both.output -> mean.input"]
    with pytest.raises(ModelError, match="bits of a number"):
        noise(Graph(name="", rate=RATE, blocks=blocks, wires=wires), "mean.mean")
