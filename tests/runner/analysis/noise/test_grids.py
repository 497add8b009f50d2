"""Errors of roundings on grids: their sizes counted one by one, and who asks for them."""

import math
from fractions import Fraction
from typing import NamedTuple, get_args

import numpy as np
import pytest

from proofmass import Graph, deviation_over_runs, noise, prove
from proofmass.blocks import (
    AnalogToDigital,
    FixedGain,
    FixedQuantiser,
    FixedToNumber,
    Gain,
    NumericallyControlledOscillator,
    Product,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed, Rounding
from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.blocks.arithmetic.rounding import round_half_even
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.graphs.model.quantities import Noise
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.noise.along_run import budgets_along
from proofmass.runner.analysis.noise.grid_errors import GridErrors, size_of
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from proofmass.runner.design.quantities.output_figures import read_noise
from proofmass.runner.planning.plan import plan
from tests.by_hand.fixed_chains import OUTPUT, fixed_chain

RATE = 1000.0
NEAREST = {
    "half_even": round,
    "half_up": lambda x: math.floor(x + Fraction(1, 2)),
    "toward_zero": math.trunc,
    "floor": math.floor,
}
GAINS = [(0.5, "half_even", math.sqrt(1 / 8)), (0.5, "floor", 0.25), (2.0, "half_even", 0.0), (1.0, "floor", 0.0)]
WHITE = WhiteNoise(density=10.0 * math.sqrt(2.0 / RATE))  # ten steps


@pytest.mark.parametrize("rounding", get_args(Rounding))
@pytest.mark.parametrize("levels", [1, 2, 3, 5, 6, 8, 64])
@pytest.mark.parametrize("offset", [Fraction(0), Fraction(1, 2), Fraction(1, 4), Fraction(1, 6), Fraction(-2, 7)])
def test_sizes_of_errors_counted_one_by_one(rounding: Rounding, levels: int, offset: Fraction) -> None:
    """As many steps below 0 as above, and as many even as odd."""
    values = [step + offset + Fraction(n, levels) for step in (-8, -7, 6, 7) for n in range(levels)]
    errors = [NEAREST[rounding](value) - value for value in values]
    mean = sum(errors) / len(errors)
    square = sum((error - mean) ** 2 for error in errors) / len(errors)
    assert size_of(levels, float(offset), rounding) ** 2 == pytest.approx(float(12 * square), abs=1e-9)


@pytest.mark.parametrize("bits", [1, 2, 3])
def test_errors_that_are_not_known_are_those_of_all_bits_that_are_dropped(bits: int) -> None:
    size = GridErrors({}, {}).size(("gain", "output"), Drop(bits, "floor"))
    assert size / math.sqrt(12.0) == pytest.approx(np.std(np.arange(2**bits) / 2**bits))


def rounded_gain(gain: float, rounding: Rounding) -> tuple[dict[str, Block], list[str]]:
    """Return blocks and wires of a gain of 14 fraction bits; a step is 1."""
    word = Fixed(16, 0)
    blocks: dict[str, Block] = {
        "noise": WHITE,
        "quantiser": FixedQuantiser(output_format=word),
        "gain": FixedGain(gain=gain, input_format=word, output_format=word, rounding=rounding),
        "number": FixedToNumber(input_format=word),
    }
    return blocks, ["noise.output -> quantiser.input", "quantiser.output -> gain.input", "gain.output -> number.input"]


def graph(blocks: dict[str, Block], wires: list[str], **options: object) -> Graph:
    return Graph(name="grid", rate=RATE, blocks=blocks, wires=wires, **options)  # type: ignore[arg-type]


@pytest.mark.defect("S804", before="0.289 steps of any gain over runs", after="0.354 or 0.25 of 0.5, none of 1 or 2")
@pytest.mark.parametrize(("gain", "rounding", "error"), GAINS)
def test_the_spread_of_a_value_has_the_errors_that_are_there(gain: float, rounding: Rounding, error: float) -> None:
    found = deviation_over_runs(graph(*rounded_gain(gain, rounding)), OUTPUT, until=0.05)
    assert found.sources.get("gain", 0.0) == pytest.approx(error, rel=1e-9)
    assert found.notes == ()


def test_the_error_of_a_gain_is_there_however_large_the_noise() -> None:
    blocks, wires = rounded_gain(0.5, "half_even")
    large = {"noise": WhiteNoise(density=1e8 * math.sqrt(2.0 / RATE))}
    parts = {source.block: source.rms for source in noise(graph(blocks | large, wires), OUTPUT).sources}
    assert parts["gain"] == pytest.approx(math.sqrt(1 / 8), rel=1e-6)


@pytest.mark.defect("S804", before="chains 4 and 13 are a factor of 5 and 7 off without a note", after="a note")
@pytest.mark.exhaustive("13-True", "19-False")
@pytest.mark.parametrize(("number", "told"), [(3, False), (4, True), (13, True), (19, False)])
def test_the_spread_of_a_value_tells_what_is_in_doubt(number: int, told: bool) -> None:
    found = deviation_over_runs(fixed_chain(number), OUTPUT, until=0.05)
    assert bool(found.notes) == told
    assert list(found.as_data()["notes"]) == list(found.notes)


@pytest.mark.defect("S804", before="0.289 steps of the gain in a figure of noise", after="those of the budget")
def test_a_figure_of_noise_is_that_of_the_budget() -> None:
    of = graph(*rounded_gain(0.5, "half_even"))
    reading = read_noise(OperatingPoints(plan(of)), Noise(OUTPUT, "", None, "1"), {}, False)
    assert reading is not None
    assert reading.value == pytest.approx(noise(of, OUTPUT).rms, rel=1e-12)
    assert reading.value == pytest.approx(math.hypot(5.0, 0.5 / math.sqrt(12.0), math.sqrt(1 / 8)), rel=1e-9)


@pytest.mark.defect(
    "S807", before="0.289 steps of the gain before a carrier", after="0.354 or 0.25 of 0.5, none of 1 or 2"
)
@pytest.mark.parametrize(("gain", "rounding", "error"), GAINS)
def test_budgets_along_a_run_have_the_errors_that_are_there(gain: float, rounding: Rounding, error: float) -> None:
    """Behind a carrier that fits no number of ticks the error shows as what is ten steps does."""
    blocks, wires = rounded_gain(gain, rounding)
    blocks |= {"carrier": NumericallyControlledOscillator(frequency=7.3890561), "mixer": Product()}
    of = graph(blocks, [*wires, "number.output -> mixer.first", "carrier.sine -> mixer.second"], samples=60)
    (found,) = budgets_along(OperatingPoints(plan(of)), ["mixer.output"], None, ())
    assert isinstance(found, NoiseBudget)
    parts = {source.block: source.rms for source in found.sources}
    assert parts.get("gain", 0.0) / parts["noise"] == pytest.approx(error / (10.0 * gain), rel=1e-9)


@pytest.mark.defect("S808", before="0.289 steps of a converter that cuts towards 0", after="0.577")
def test_a_converter_that_cuts_errs_by_a_whole_step() -> None:
    word = Fixed(16, 0)
    blocks: dict[str, Block] = {
        "noise": WhiteNoise(density=100.0 * math.sqrt(2.0 / RATE)),
        "quantiser": FixedQuantiser(output_format=word, rounding="toward_zero"),
        "number": FixedToNumber(input_format=word),
    }
    of = graph(blocks, ["noise.output -> quantiser.input", "quantiser.output -> number.input"])
    values = 100.0 * np.random.default_rng(1).normal(size=100_000)
    run = float(np.std(np.trunc(values) - values))
    parts = {source.block: source.rms for source in noise(of, OUTPUT).sources}
    assert parts["quantiser"] == pytest.approx(run, rel=0.01)
    spread = deviation_over_runs(of, OUTPUT, until=0.05)
    assert spread.sources["quantiser"] == pytest.approx(run, rel=0.01)


CONVERTER = AnalogToDigital(bits=16, reference=32768.0)


class Conversions(NamedTuple):
    count: int


class CountingConverter(Block):
    """Converter with steps of 1 V that counts."""

    voltage = Input("V", "What is rounded.")


@CountingConverter.output("1")
def number(p: CountingConverter, voltage: float) -> float:
    """The nearest number, of two an even one."""
    return round_half_even(voltage)


@CountingConverter.update
def update(p: CountingConverter, x: Conversions) -> Conversions:
    return Conversions(x.count + 1)


def converters(gain: float, second: Block = CONVERTER) -> Graph:
    """Return one converter behind another, with steps of 1 V."""
    blocks: dict[str, Block] = {
        "noise": WhiteNoise(density=10.0 * math.sqrt(2.0 / RATE), unit="V"),
        "first": CONVERTER,
        "gain": Gain(gain=gain, output_unit="V"),
        "second": second,
        "end": Gain(gain=1.0),
    }
    wires = ["noise.output -> first.voltage", "first.number -> gain.input", "gain.output -> second.voltage"]
    return graph(blocks, [*wires, "second.number -> end.input"])


@pytest.mark.defect("S809", before="0.289 steps of a second converter, in doubt", after="0.354, as of half a word")
@pytest.mark.parametrize("converter", [CONVERTER, CountingConverter()])
def test_a_converter_of_words_has_their_levels(converter: Block) -> None:
    sources = noise(converters(0.5, converter), "end.output").sources
    (second,) = [source for source in sources if source.block == "second"]
    assert second.rms == pytest.approx(math.sqrt(1 / 8), rel=1e-9)
    assert not second.doubtful


@pytest.mark.defect("S809", before="a bound of 5.0105 V is proved, where a run has 5.0146 V", after="no proof")
@pytest.mark.exhaustive("0.37")
@pytest.mark.parametrize(("gain", "verdict"), [(0.5, "open"), (0.37, "proved"), (1.0, "proved")])
def test_a_proof_needs_errors_that_are_no_larger_than_uniform(gain: float, verdict: str) -> None:
    (found,) = prove(converters(gain), tolerances={"noise.density": "0.001 %"}, noise={"end.output": ""}).proofs
    assert found.status == verdict
