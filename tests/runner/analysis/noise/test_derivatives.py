"""Derivatives of the rms by parameters, against central differences of budgets anew."""

import math

import numpy as np
import pytest
import scipy.integrate

from proofmass import Graph, ModelError, noise
from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    Gain,
    LowPass,
    Power,
    Product,
    Sine,
    Sum,
    WhiteNoise,
)
from proofmass.graphs.model.changes import with_parameters
from proofmass.runner.analysis.noise.derivatives import slopes_and_sizes
from proofmass.runner.analysis.noise.noise_map import NoiseMap
from proofmass.runner.derivatives.dual_noise import DEVIATE

EXACT = 1e-6
RATE = 1000.0


def first_order(a: float = 0.9) -> Graph:
    blocks = {
        "w": WhiteNoise(density=2.0),
        "error": Difference(),
        "y": DiscreteIntegrator(gain=(1.0 - a) * RATE, output_unit="1"),
    }
    wires = ["w.output -> error.first", "y.output -> error.second", "error.output -> y.input"]
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires)


def chain() -> Graph:
    """Continuous filter, converter, decimation: sources of three kinds."""
    blocks = {
        "w": WhiteNoise(density=40e-6, unit="V"),
        "filter": LowPass(corner_frequency=80.0, gain=3.0, input_unit="V", output_unit="V"),
        "adc": AnalogToDigital(bits=12, reference=2.5),
        "scale": Gain(gain=0.7),
        "mean": Decimator(ratio=5),
    }
    wires = [
        "w.output -> filter.input", "filter.output -> adc.voltage", "adc.number -> scale.input",
        "scale.output -> mean.input",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires)


def curved(corner: float = 5.0) -> Graph:
    """A square about a point that a filter settles to: its slope is where the point is."""
    blocks = {
        "level": Constant(value=1.5),
        "filter": LowPass(corner_frequency=corner, gain=2.0),
        "w": WhiteNoise(density=1e-3),
        "sum": Difference(),
        "square": Power(exponent=2.0),
    }
    wires = [
        "level.output -> filter.input", "filter.output -> sum.first", "w.output -> sum.second",
        "sum.output -> square.input",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires)


def difference(graph: Graph, key: str, value: float, output: str, **options: object) -> float:
    """The derivative of the rms by a parameter, by central differences of two steps (Richardson)."""

    def slope(step: float) -> float:
        ends = (
            noise(with_parameters(graph, {key: value * (1.0 + side * step)}), output, frequencies=[1.0], **options).rms  # type: ignore[arg-type]
            for side in (1.0, -1.0)
        )
        return (next(ends) - next(ends)) / (2.0 * step * value)

    return (4.0 * slope(5e-4) - slope(1e-3)) / 3.0


@pytest.mark.exhaustive("chain", "chain-in-a-band", "soon", "at-rest", "loop-in-a-band")
@pytest.mark.parametrize(("graph", "output", "options"), [
    pytest.param(first_order(), "y.output", {}, id="loop"),
    pytest.param(first_order(), "y.output", {"band": (1.0, 40.0)}, id="loop-in-a-band"),
    pytest.param(chain(), "mean.mean", {}, id="chain"),
    pytest.param(chain(), "mean.mean", {"band": (2.0, 30.0)}, id="chain-in-a-band"),
    pytest.param(curved(0.5), "square.output", {"at": "0.05 s"}, id="soon"),
    pytest.param(curved(0.05), "square.output", {"at": "0.5 s"}, id="on-the-way", marks=pytest.mark.exhaustive),
    pytest.param(curved(), "square.output", {"at": "25 s"}, id="at-rest"),
])  # fmt: skip
def test_central_differences(graph: Graph, output: str, options: dict[str, object]) -> None:
    found = noise(graph, output, derivatives=True, **options).derivatives  # type: ignore[arg-type]
    assert found is not None
    assert len(found.effects) >= 2
    for effect in found.effects:
        if effect.value:
            expected = difference(graph, effect.parameter, effect.value, output, **options)
            assert effect.derivative == pytest.approx(expected, rel=EXACT), effect.parameter


def test_a_first_order_loop_in_closed_form() -> None:
    """rms = d sqrt(f / 2 (1 - a) / (1 + a)): by the density rms / d, by the gain g with a = 1 - g / f in one step."""
    found = noise(first_order(), "y.output", derivatives=True)
    assert found.derivatives is not None
    by = {effect.parameter: effect.derivative for effect in found.derivatives.effects}
    a, gain = 0.9, 100.0
    assert by["w.density"] == pytest.approx(found.rms / 2.0, rel=1e-12)
    by_a = found.rms * -1.0 / (1.0 - a * a)
    assert by["y.gain"] == pytest.approx(by_a * -1.0 / RATE, rel=1e-9)
    assert by_a * -1.0 / RATE * gain > 0.0


def test_one_more_bit_halves_the_rounding() -> None:
    graph = chain()
    found = noise(graph, "mean.mean", derivatives=True)
    (step,) = found.steps
    assert step.parameter == "adc.bits"
    finer = noise(with_parameters(graph, {"adc.bits": 13}), "mean.mean")
    assert step.change == pytest.approx(finer.rms - found.rms, rel=1e-12)
    assert {s.block: s.rms for s in finer.sources}["adc"] == pytest.approx(
        {s.block: s.rms for s in found.sources}["adc"], rel=1e-9
    )  # in steps, whatever their size


@pytest.mark.exhaustive
def test_an_operating_point_that_moves_is_said() -> None:
    found = noise(curved(1e-3), "square.output", at="30 s", derivatives=True)
    assert any("operating point as fixed" in note for note in found.notes)


def test_without_being_asked_there_are_none() -> None:
    found = noise(first_order(), "y.output")
    assert found.derivatives is None
    assert "derivatives" not in found.as_data()
    with pytest.raises(ModelError):
        noise(first_order(), "y.nothing", derivatives=True)
    assert math.isfinite(found.rms)


@pytest.mark.parametrize("values", [1, 2])
def test_derivatives_in_a_band_are_those_of_the_integral(values: int) -> None:
    """x' = 0.6 x + 0.8 w, y[i] = c[i] x + d[i] w, w white, values y[0] and y[1] half a period T apart.

    The density is 2 T / r^2 |sum of exp(-2 pi j f i T / r) h[i]|^2 for r values, h[i] = 0.8 c[i] / (z - 0.6) + d[i].
    """
    period, entries = 1e-3, {"a0": 0.6, "b0": 0.8, "c0": 1.5, "d0": 0.2}
    if values == 2:
        entries |= {"c1": -0.4, "d1": 0.7}
    shapes = {"a": 1, "b": 1, "c": values, "d": values}

    def of_matrices(at: dict[str, float]) -> tuple[np.ndarray, ...]:
        return tuple(np.array([[at.get(f"{name}{i}", 0.0)] for i in range(rows)]) for name, rows in shapes.items())

    units = {name: of_matrices({name: 1.0}) for name in entries}
    of = NoiseMap(of_matrices(entries), period, inputs=(("hiss", DEVIATE, 0),), slopes=units)  # type: ignore[arg-type]

    def square(at: dict[str, float]) -> float:
        def density(f: float) -> float:
            h = at["b0"] / (np.exp(2j * math.pi * f * period) - at["a0"])
            turns = [np.exp(-2j * math.pi * f * i * period / values) for i in range(values)]
            heard = sum(turn * (at[f"c{i}"] * h + at[f"d{i}"]) for i, turn in enumerate(turns))
            return float(2.0 * period / values**2 * abs(heard) ** 2)

        return float(scipy.integrate.quad(density, 50.0, 200.0, epsabs=0.0, epsrel=1e-12)[0])

    found, _ = slopes_and_sizes(of, (50.0, 200.0), math.sqrt(square(entries)))
    for name, value in entries.items():
        sides = [math.sqrt(square({**entries, name: value + side})) for side in (1e-5, -1e-5)]
        assert found[name] == pytest.approx((sides[0] - sides[1]) / 2e-5, rel=1e-6), name


@pytest.mark.defect("S791", before="a budget with derivatives had another rms, 1.70 for 1.73", after="the same")
def test_a_budget_with_derivatives_has_the_rms_of_the_one_without() -> None:
    """Noise times a sine of 2.4 V in steps of 1 V: 0, 2, 2, 2 and so on, whose squares have the mean 3.

    The budget without derivatives is in `test_alike_by_chance`.
    """
    blocks = {
        "w": WhiteNoise(density=math.sqrt(2.0 / 80_000)),  # of variance one
        "carrier": Sine(frequency=1e4, amplitude=2.4, unit="V"),
        "adc": AnalogToDigital(bits=3, reference=4.0),
        "turned": Product(),
    }
    wires = ["carrier.output -> adc.voltage", "w.output -> turned.first", "adc.number -> turned.second"]
    graph = Graph(name="coarse", rate=80_000, blocks=blocks, wires=wires)
    assert noise(graph, "turned.output", derivatives=True).rms == pytest.approx(math.sqrt(3.0))


@pytest.mark.exhaustive("2", "4")
@pytest.mark.defect("S819", before="the rms of a carrier without steps, squared, over that with them", after="1 of 1")
@pytest.mark.parametrize("bits", [2, 3, 4])
def test_a_carrier_in_steps_scales_no_noise(bits: int) -> None:
    """The rms is that of white noise times that of the steps: it is proportional to the density and to a gain."""
    blocks = {
        "w": WhiteNoise(density=0.1), "gain": Gain(gain=3.0), "carrier": Sine(frequency=125.0, amplitude=1.7, unit="V"),
        "steps": AnalogToDigital(bits=bits, reference=4.0), "mixer": Product(),
    }  # fmt: skip
    wires = [
        "carrier.output -> steps.voltage", "steps.number -> mixer.second", "w.output -> gain.input",
        "gain.output -> mixer.first",
    ]  # fmt: skip
    graph = Graph(name="steps", rate=RATE, blocks=blocks, wires=wires, samples=64)
    budget = noise(graph, "mixer.output", derivatives=True)
    assert budget.derivatives is not None
    found = {effect.parameter: effect.derivative * effect.value for effect in budget.derivatives.effects}
    assert found["w.density"] == pytest.approx(budget.rms)
    assert found["gain.gain"] == pytest.approx(budget.rms)


@pytest.mark.defect("S823", before="those of one tick: -1 by a phase, 1.41 by an offset", after="of a whole turn: none")
def test_two_carriers_whose_squares_add_up_have_the_derivatives_of_a_whole_turn() -> None:
    """sin^2 + cos^2 is one in each tick. A phase or an offset makes it more in some ticks and less in others."""
    sine, cosine = (Sine(frequency=125.0, amplitude=1.0, phase=phase) for phase in (0.0, 0.5 * math.pi))
    blocks = {
        "w": WhiteNoise(density=0.1), "sine": sine, "cosine": cosine, "a": Product(), "b": Product(), "c": Product(),
        "d": Product(), "sum": Sum(),
    }  # fmt: skip
    wires = [
        "w.output -> a.first", "sine.output -> a.second", "a.output -> b.first", "sine.output -> b.second",
        "w.output -> c.first", "cosine.output -> c.second", "c.output -> d.first", "cosine.output -> d.second",
        "b.output -> sum.first", "d.output -> sum.second",
    ]  # fmt: skip
    budget = noise(Graph(name="two", rate=RATE, blocks=blocks, wires=wires, samples=64), "sum.output", derivatives=True)
    assert budget.derivatives is not None
    found = {effect.parameter: effect.derivative for effect in budget.derivatives.effects}
    assert found["sine.amplitude"] == pytest.approx(budget.rms)
    assert found["cosine.amplitude"] == pytest.approx(budget.rms)
    for name in ("sine.phase", "cosine.phase", "sine.offset", "cosine.offset"):
        assert found.get(name, 0.0) == pytest.approx(0.0, abs=1e-9 * budget.rms)
