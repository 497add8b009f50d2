"""Noise budgets against closed forms, within 1e-9."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass.blocks import (
    AnalogToDigital,
    BrownianForce,
    ChopperModulator,
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    FlickerNoise,
    Gain,
    GaussMarkov,
    LowPass,
    MassSpringDamper,
    Product,
    RandomWalk,
    Sine,
    Sum,
    UnitDelay,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.rounding import round_half_even
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.noise.budget import noise
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from tests.by_hand.amounts import chosen

RATE = 1000.0
EXACT = 1e-9


def budget(blocks: dict[str, Block], wires: list[str], output: str, **options: object) -> NoiseBudget:
    rates = options.pop("rates", {})
    return noise(Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, rates=rates), output, **options)  # type: ignore[arg-type]


def first_order(a: float) -> NoiseBudget:
    """y[n+1] = y + (1 - a) (w - y): a loop through an integrator."""
    blocks = {
        "w": WhiteNoise(density=2.0),
        "error": Difference(),
        "y": DiscreteIntegrator(gain=(1.0 - a) * RATE, output_unit="1"),
    }
    return budget(
        blocks, ["w.output -> error.first", "y.output -> error.second", "error.output -> y.input"], "y.output"
    )


@pytest.mark.parametrize("a", [0.0, 0.5, 0.99, 0.999999])
def test_first_order_loop(a: float) -> None:
    white = 2.0**2 * RATE / 2.0
    assert first_order(a).rms ** 2 == pytest.approx(white * (1.0 - a) / (1.0 + a), rel=EXACT)


@pytest.mark.parametrize("over", [1e-3, 1e-7, 3e-9])
def test_a_pole_just_outside_the_circle_grows(over: float) -> None:
    with pytest.raises(ModelError, match="grows without end"):
        first_order(1.0 + over)


def test_density_of_a_first_order_loop() -> None:
    found, a = first_order(0.9), 0.9
    turn = 2.0 * math.pi * found.frequencies / RATE
    expected = 4.0 * (1.0 - a) ** 2 / (1.0 - 2.0 * a * np.cos(turn) + a * a)
    assert found.density == pytest.approx(expected, rel=EXACT)


@pytest.mark.parametrize("band", [(0.0, 20.0), (1.0, 3.0), (100.0, 500.0)])
def test_rms_in_a_band(band: tuple[float, float]) -> None:
    """The integral of 1 / (1 - 2 a cos + a^2) is an arctangent."""
    a = 0.97
    blocks = {"w": WhiteNoise(), "error": Difference(), "y": DiscreteIntegrator(gain=(1.0 - a) * RATE, output_unit="1")}
    wires = ["w.output -> error.first", "y.output -> error.second", "error.output -> y.input"]
    found = budget(blocks, wires, "y.output", band=band)

    def below(f: float) -> float:
        turned = math.pi / 2.0 if f == 500.0 else math.atan((1.0 + a) / (1.0 - a) * math.tan(math.pi * f / RATE))
        return (1.0 - a) ** 2 * RATE / (math.pi * (1.0 - a * a)) * turned

    assert found.rms**2 == pytest.approx(below(band[1]) - below(band[0]), rel=EXACT)


def test_noise_of_a_resistor_on_a_capacitor_is_kt_over_c() -> None:
    """Held from tick to tick it is (k T / C) tanh(x) / x, x = half a period by the time constant."""
    k, temperature, resistance, capacitance = 1.380649e-23, 300.0, 10e3, 1e-6
    corner = 1.0 / (2.0 * math.pi * resistance * capacitance)
    blocks = {
        "r": WhiteNoise(density=math.sqrt(4.0 * k * temperature * resistance), unit="V"),
        "c": LowPass(corner_frequency=corner, input_unit="V", output_unit="V"),
    }
    found = budget(blocks, ["r.output -> c.input"], "c.output")
    x = 0.5 / (RATE * resistance * capacitance)
    assert found.rms**2 == pytest.approx(k * temperature / capacitance * math.tanh(x) / x, rel=EXACT)
    assert found.rms**2 == pytest.approx(k * temperature / capacitance, rel=x * x / 2.9)


def test_brownian_force() -> None:
    found = budget(
        {"gas": BrownianForce(damping=2e-3), "m": Gain(input_unit="N")}, ["gas.force -> m.input"], "m.output"
    )
    assert found.density == pytest.approx(np.full(len(found.density), 4.0 * 1.380649e-23 * 300.0 * 2e-3), rel=EXACT)


def test_quantisation_is_white_with_a_twelfth_of_a_step_squared() -> None:
    blocks = {"w": WhiteNoise(density=0.1, unit="V"), "adc": AnalogToDigital(bits=12, reference=4.096)}
    found = budget(blocks, ["w.output -> adc.voltage"], "adc.number")
    rounding = next(source for source in found.sources if source.kind == "quantisation")
    assert rounding.rms**2 == pytest.approx(1.0 / 12.0, rel=EXACT)
    assert rounding.density == pytest.approx(np.full(len(found.density), 2.0 / 12.0 / RATE), rel=EXACT)
    assert not rounding.doubtful
    assert not [note for note in found.notes if "adc" in note]
    white = next(source for source in found.sources if source.kind == "WhiteNoise")
    assert white.rms == pytest.approx(0.1 * math.sqrt(RATE / 2.0) * 2048.0 / 4.096, rel=EXACT)
    assert white.share + rounding.share == pytest.approx(1.0, rel=EXACT)


def test_a_quantiser_that_noise_hardly_moves_is_told() -> None:
    blocks = {"w": WhiteNoise(density=1e-6, unit="V"), "adc": AnalogToDigital(bits=8, reference=1.0)}
    found = budget(blocks, ["w.output -> adc.voltage"], "adc.number")
    assert [source.doubtful for source in found.sources if source.kind == "quantisation"] == [True]
    moved = 1e-6 * math.sqrt(RATE / 2.0) * 128.0
    dither = next(source.dither for source in found.sources if source.dither)
    assert dither is not None
    assert dither.rms == pytest.approx(moved, rel=EXACT)
    assert dither.change == pytest.approx(moved * math.sqrt(2.0), rel=EXACT)
    assert "its error is noise only if signals move it more" in found.notes[0]


class Twice(Block):
    """A converter with two outputs of one number."""

    input = Input("1", "What is rounded.")


@Twice.output("1")
def upper(p: Twice, input: float) -> float:
    """The number."""
    return round_half_even(input)


@Twice.output("1")
def lower(p: Twice, input: float) -> float:
    """The same once more."""
    return round_half_even(input)


def test_both_outputs_of_a_converter_err_alike() -> None:
    """The sum of twice the same number has twice the error, not sqrt(2) of it as of two that add up in squares."""
    blocks = {"w": WhiteNoise(), "twice": Twice(), "sum": Sum()}
    wires = ["w.output -> twice.input", "twice.upper -> sum.first", "twice.lower -> sum.second"]
    found = budget(blocks, wires, "sum.output")
    rounding = next(source for source in found.sources if source.kind == "quantisation")
    assert rounding.rms == pytest.approx(math.sqrt(1.0 / 12.0) * 2.0, rel=EXACT)


@pytest.mark.parametrize("ratio", [2, 7, 20])
def test_averages_decimate_white_noise_without_changing_its_density(ratio: int) -> None:
    found = budget({"w": WhiteNoise(), "d": Decimator(ratio=ratio)}, ["w.output -> d.input"], "d.mean")
    assert found.rate == pytest.approx(RATE / ratio)
    assert found.density == pytest.approx(np.ones(len(found.density)), rel=EXACT)


def test_sampling_folds() -> None:
    """Noise of a first-order filter, of which a slow block reads each eighth value."""
    a, ratio = 0.8, 8
    blocks = {"w": WhiteNoise(), "f": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -a)), "slow": Gain()}
    wires = ["w.output -> f.input", "f.strictly_proper_part -> slow.input"]
    found = budget(blocks, wires, "slow.output", rates={"slow": "125 Hz"})

    def filtered(f: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        return 1.0 / (1.0 - 2.0 * a * np.cos(2.0 * np.pi * f / RATE) + a * a)

    folded = sum(filtered(found.frequencies + turn * RATE / ratio) for turn in range(ratio))
    assert found.density == pytest.approx(folded, rel=EXACT)
    assert found.rms**2 == pytest.approx(RATE / 2.0 / (1.0 - a * a), rel=EXACT)


def test_a_hold_shapes_by_its_sinc() -> None:
    ratio = 5
    blocks = {"w": WhiteNoise(density=3.0), "fast": Gain()}
    found = budget(blocks, ["w.output -> fast.input"], "fast.output", rates={"w": "200 Hz"})
    x = np.pi * found.frequencies / RATE
    assert found.rate == RATE
    assert found.density == pytest.approx(9.0 * (np.sin(ratio * x) / (ratio * np.sin(x))) ** 2, rel=EXACT, abs=1e-15)


def test_gauss_markov_noise() -> None:
    found = budget(
        {"g": GaussMarkov(standard_deviation=0.2, correlation_time=0.03), "o": Gain()},
        ["g.deviation -> o.input"],
        "o.output",
    )
    a = math.exp(-1.0 / (RATE * 0.03))
    expected = (
        2.0 * 0.04 * (1.0 - a * a) / RATE / (1.0 - 2.0 * a * np.cos(2.0 * np.pi * found.frequencies / RATE) + a * a)
    )
    assert found.density == pytest.approx(expected, rel=EXACT)
    assert found.rms == pytest.approx(0.2, rel=EXACT)


def test_a_random_walk_has_a_density_and_no_bound() -> None:
    found = budget({"k": RandomWalk(coefficient=0.3), "o": Gain()}, ["k.deviation -> o.input"], "o.output")
    step = 4.0 * np.sin(np.pi * found.frequencies / RATE) ** 2
    assert found.density == pytest.approx(2.0 * 0.09 / RATE**2 / step, rel=EXACT)
    assert any("without bound" in note for note in found.notes)
    assert found.levels["K"].value == pytest.approx(0.3, rel=1e-6)


def test_flicker_noise_through_a_high_pass() -> None:
    """Its ladder of filters is within 0.16 dB of level^2 / f."""
    a = 0.99
    blocks = {
        "n": FlickerNoise(level=0.5, lowest_frequency=0.01, highest_frequency=500.0),
        "f": DiscreteTransferFunction(numerator=(1.0, -1.0), denominator=(1.0, -a)),
    }
    found = budget(blocks, ["n.deviation -> f.input"], "f.output", band=(0.02, 450.0))
    z = np.exp(2j * np.pi * found.frequencies / RATE)
    expected = 0.25 / found.frequencies * np.abs((z - 1.0) / (z - a)) ** 2
    assert np.max(np.abs(10.0 * np.log10(found.density / expected))) < 0.17


def test_noise_is_referred_to_an_input_through_a_delay_of_several_rates() -> None:
    """What comes out of a decimator at the frequency that goes in: a mean of 10, delayed."""
    blocks = {
        "u": Gain(gain=2.0),
        "w": WhiteNoise(),
        "sum": Sum(),
        "d": Decimator(ratio=10),
        "zero": WhiteNoise(density=0.0),
    }
    wires = ["zero.output -> u.input", "u.output -> sum.first", "w.output -> sum.second", "sum.output -> d.input"]
    found = budget(blocks, wires, "d.mean", input="u.output")
    x = np.pi * found.frequencies / RATE
    assert np.abs(found.gain) == pytest.approx(np.abs(np.sin(10.0 * x) / (10.0 * np.sin(x))), rel=EXACT)
    assert found.referred_density == pytest.approx(1.0 / np.abs(found.gain) ** 2, rel=EXACT)


@pytest.mark.exhaustive
@pytest.mark.defect("S26", before="the noise of one state of a switch or mixer", after="the mean over its period")
def test_a_chopper_moves_flicker_noise_to_its_frequency() -> None:
    """Behind a square wave of Fourier coefficients c[k] the two-sided density is the sum of |c[k]|^2 S(f - k fc)."""
    half = 8
    blocks = {
        "flicker": FlickerNoise(level=1.0, lowest_frequency=0.5, highest_frequency=100.0, unit="V"),
        "chopper": ChopperModulator(half_period=half),
    }
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=["flicker.value -> chopper.input"])
    f = np.array([3.0, 30.0, 62.0, 70.0, 180.0, 300.0])
    found = noise(graph, "chopper.output", frequencies=f.tolist())
    square = np.where(np.arange(2 * half) < half, 1.0, -1.0)
    weights = np.abs(np.fft.fft(square) / len(square)) ** 2
    expected = np.zeros(len(f))
    for k, weight in enumerate(weights):
        shifted = (f - k * RATE / len(square)) % RATE
        apart = np.abs(np.where(shifted > RATE / 2.0, shifted - RATE, shifted))
        order = np.argsort(apart)
        values = noise(graph, "flicker.value", frequencies=apart[order].tolist()).density
        expected[order] += weight * values
    assert found.density == pytest.approx(expected, rel=EXACT)
    again = noise(graph, "chopper.output", frequencies=f.tolist(), at="periodic")
    assert again.density == pytest.approx(found.density, rel=EXACT)
    near, quiet = float(found.density[2]), float(found.density[0])  # the chopping frequency is 62.5 Hz
    assert near > 30.0 * quiet


@pytest.mark.defect("S26", before="the noise of one state of a switch or mixer", after="the mean over its period")
def test_synchronous_demodulation_halves_the_density_about_the_carrier() -> None:
    """White noise times sin(2 pi fc t): half of the density of the noise, at every frequency (Leland 2005)."""
    blocks = {
        "force": WhiteNoise(density=3.0),
        "carrier": Sine(amplitude=1.0, frequency=125.0),
        "mixer": Product(),
    }
    wires = ["force.output -> mixer.first", "carrier.output -> mixer.second"]
    found = budget(blocks, wires, "mixer.output")
    assert found.density == pytest.approx(9.0 / 2.0, rel=EXACT)
    assert found.rms**2 == pytest.approx(9.0 / 2.0 * RATE / 2.0, rel=EXACT)


@pytest.mark.defect("S26", before="the noise of one state of a switch or mixer", after="the mean over its period")
def test_brownian_force_demodulated_at_resonance() -> None:
    """A narrow band about the carrier comes down to zero: x sin gives S(fc - f) / 4 + S(fc + f) / 4 of two sides."""
    carrier, offset = 125.0, 5.0
    blocks = {
        "force": BrownianForce(damping=1e-6, temperature=300.0),
        "mass": MassSpringDamper(mass=1e-8, damping=1e-6, stiffness=1e-8 * (2.0 * math.pi * carrier) ** 2),
        "carrier": Sine(amplitude=1.0, frequency=carrier, unit="1"),
        "mixer": Product(first_unit="m"),
    }
    wires = [
        "force.force -> mass.force", "mass.displacement -> mixer.first", "carrier.output -> mixer.second",
    ]  # fmt: skip
    mixed = budget(blocks, wires, "mixer.output", frequencies=[offset]).density
    straight = budget(blocks, wires, "mass.displacement", frequencies=[carrier - offset, carrier + offset]).density
    assert mixed == pytest.approx(np.sum(straight) / 4.0, rel=EXACT)


def test_an_output_without_noise_is_refused() -> None:
    blocks = {"w": WhiteNoise(), "o": Gain(), "other": UnitDelay(), "nothing": Constant()}
    with pytest.raises(ModelError, match=r"no noise reaches o\.output"):
        budget(blocks, ["w.output -> other.input", "nothing.output -> o.input"], "o.output")


def test_a_converter_that_stands_still_is_told_from_one_that_is_not_there() -> None:
    blocks = {"nothing": Constant(unit="V"), "adc": AnalogToDigital()}
    with pytest.raises(ModelError, match="what adc would round stands still here: let an input move"):
        budget(blocks, ["nothing.output -> adc.voltage"], "adc.code")


def test_an_empty_band_is_refused() -> None:
    with pytest.raises(ModelError, match="the band is empty"):
        budget({"w": WhiteNoise(), "o": Gain()}, ["w.output -> o.input"], "o.output", band=(600.0, 700.0))


@pytest.mark.exhaustive("1000")
@pytest.mark.defect("S605", before="1.604 for means of 2,000 values", after="the integral to eleven digits")
@pytest.mark.parametrize("ratio", chosen((2, 100, 1000), (2000,)))
def test_the_band_of_a_held_mean_of_many_values(ratio: int) -> None:
    """A held white sequence has the density of one value times the squared Dirichlet kernel, whose lobes are known."""
    blocks = {"white": WhiteNoise(density=1.0), "mean": Decimator(ratio=ratio), "fast": Gain()}
    wires = ["white.output -> mean.input", "mean.mean -> fast.input"]
    graph = Graph(name="", rate="10 kHz", blocks=blocks, wires=wires, rates={"fast": "10 kHz"})
    lag, high = np.arange(1, ratio), 2000.0
    triangle = (ratio - lag) * np.sin(2.0 * math.pi * high * lag / 10000.0) / (math.pi * lag)
    # The kernel's integral from 0 to f is N f + 2 sum (N - k) sin(2 pi k f / r) r / (2 pi k); a value has 1/N of 5 kHz.
    kernel = ratio * high + 10000.0 * math.fsum(triangle)
    wanted = kernel / ratio**2
    assert noise(graph, "fast.output", band=(0.0, high)).rms ** 2 == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize(
    ("frequencies", "slow"), [((1.0, 10.0, 99.0, 101.0, 400.0), 3), ((200.0, 500.0, 799.0, 801.0), 3)]
)
def test_coefficients_are_of_the_slow_part_of_a_density(frequencies: tuple[float, ...], slow: int) -> None:
    """Up to a tenth of the rate, and up to four times the first frequency where that is more: N^2 = S / 2."""
    density = np.where(np.arange(len(frequencies)) < slow, 4.0, 4e-6)
    found = replace(first_order(0.0), frequencies=np.array(frequencies), density=density).levels
    assert found["N"].value == pytest.approx(math.sqrt(2.0), rel=1e-3)
