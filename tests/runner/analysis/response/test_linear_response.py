"""Linear responses against closed forms and scipy."""

import math
from typing import Any

import numpy as np
import pytest
import scipy.optimize
import scipy.signal

from proofmass import Graph, noise, response, worst
from proofmass.blocks import (
    Constant,
    Decimator,
    Delay,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    Gain,
    LowPass,
    MovingAverage,
    SigmaDeltaModulator,
    UnitDelay,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.call_numbers import frequencies_of
from proofmass.runner.design.quantities.output_figures import value_of_response

RATE = 1000.0


def chain(*blocks: Block, rates: tuple[str, ...] = ()) -> Graph:
    """A constant, and blocks one behind the other, called a, b, c."""
    names = ["u", *"abcd"[: len(blocks)]]
    ports = ["output", *(next(iter(type(block).outputs)) for block in blocks)]
    wires = [f"{n}.{p} -> {m}.input" for n, p, m in zip(names, ports, names[1:], strict=False)]
    own = dict(zip(names[1:], rates, strict=False))
    return Graph(
        name="", rate="1 kHz", blocks=dict(zip(names, (Constant(), *blocks), strict=True)), wires=wires, rates=own
    )


def first_order(a: float) -> Graph:
    return chain(DiscreteTransferFunction(numerator=(1.0 - a, 0.0), denominator=(1.0, -a)))


@pytest.mark.parametrize("a", [0.2, 0.9, 0.9999])
def test_first_order_against_closed_forms(a: float) -> None:
    """y[n] = a y[n-1] + (1 - a) u[n]: the step is 1 - a^(n+1), the delay at rest a / (1 - a) periods."""
    found = response(first_order(a), "u.output", "a.output")
    turn = np.exp(2j * np.pi * found.frequencies / RATE)
    assert found.gain == pytest.approx((1.0 - a) / (1.0 - a / turn), rel=1e-9)
    assert found.at_rest == pytest.approx(1.0, rel=1e-12)
    assert found.delay == pytest.approx(a / (1.0 - a) / RATE, rel=1e-5)
    sine = (1.0 - a) / (2.0 * math.sqrt(a))  # of half the angle at which the size is sqrt(1/2)
    if sine <= 1.0:
        assert found.bandwidth == pytest.approx(math.asin(sine) * RATE / math.pi, rel=1e-9)
    else:
        assert found.bandwidth is None
    step = found.step
    assert step is not None
    assert step.overshoot == pytest.approx(0.0, abs=1e-12)

    def crossing(level: float) -> float:
        """Time at which straight lines between the values 1 - a^(n+1) reach a level."""
        n = max(0, math.ceil(math.log(1.0 - level) / math.log(a) - 1.0 - 1e-9))
        after, before = 1.0 - a ** (n + 1), 1.0 - a**n
        return (n - 1.0 + (level - before) / (after - before)) / RATE if n else 0.0

    assert step.rise == pytest.approx(crossing(0.9) - crossing(0.1), rel=1e-4)
    assert step.settling == pytest.approx(crossing(0.98), rel=1e-4)


@pytest.mark.parametrize(("numerator", "denominator"), [
    ((0.02, 0.01), (1.0, -1.8, 0.83)),
    ((0.0, -0.05, 0.08), (1.0, -1.6, 0.66, -0.02)),
    ((0.0, 0.5), (1.0, 0.5)),
])  # fmt: skip
def test_figures_of_a_step_against_a_filtered_one(numerator: tuple[float, ...], denominator: tuple[float, ...]) -> None:
    graph = chain(DiscreteTransferFunction(numerator=numerator, denominator=denominator))
    found = response(graph, "u.output", "a.output").step
    assert found is not None
    padded = [*[0.0] * (len(denominator) - len(numerator)), *numerator]
    values = scipy.signal.lfilter(padded, denominator, np.ones(4000))
    final = values[-1]
    fine = np.interp(np.arange(0.0, 3999.0, 1e-3), np.arange(4000.0), values) / final  # straight lines between values
    assert found.final == pytest.approx(final, rel=1e-9)
    assert found.overshoot == pytest.approx(np.max(values / final) - 1.0, rel=1e-9, abs=1e-9)
    assert found.undershoot == pytest.approx(max(0.0, -np.min(values / final)), rel=1e-9, abs=1e-12)
    assert found.peak == pytest.approx(np.max(values), rel=1e-7)  # where it rises to the end
    rise = np.argmax(fine >= 0.9) - np.argmax(fine >= 0.1)
    assert found.rise == pytest.approx(rise * 1e-3 / RATE, abs=2e-3 / RATE)
    settling = np.flatnonzero(np.abs(fine - 1.0) > 0.02)[-1]
    assert found.settling == pytest.approx(settling * 1e-3 / RATE, abs=2e-3 / RATE)


def test_a_delay_is_that_of_all_registers() -> None:
    found = response(chain(UnitDelay(), UnitDelay(), UnitDelay()), "u.output", "c.output")
    assert found.delay == pytest.approx(3.0 / RATE, rel=1e-9)
    assert np.abs(found.gain) == pytest.approx(1.0, rel=1e-12)
    assert found.bandwidth is None


def test_mean_of_two_rates() -> None:
    """The mean of 10 values at a tenth of the rate: a sinc, and at the multiples of the rate nothing."""
    found = response(chain(Decimator(ratio=10)), "u.output", "a.mean", frequencies=[1.0, 20.0, 49.0])
    n, f = 10, np.array([1.0, 20.0, 49.0])
    size = np.abs(np.sin(np.pi * n * f / RATE) / (n * np.sin(np.pi * f / RATE)))
    assert np.abs(found.gain) == pytest.approx(size, rel=1e-9)


def test_a_hold_of_a_slow_input_is_a_sinc() -> None:
    """A low-pass at the fast rate reads values at a tenth of it: its mean at the slow frequency is a held sine."""
    blocks = {"u": Constant(), "a": MovingAverage(length=1)}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=["u.output -> a.input"], rates={"u": "100 Hz"})
    found = response(graph, "u.output", "a.mean", frequencies=[10.0, 40.0])
    f = np.array([10.0, 40.0])
    assert np.abs(found.gain) == pytest.approx(np.abs(np.sin(np.pi * f / 100.0) / (10.0 * np.sin(np.pi * f / RATE))))


def test_a_continuous_low_pass_is_held_exactly() -> None:
    corner = 20.0
    found = response(chain(LowPass(corner_frequency=corner)), "u.output", "a.output")
    pole = math.exp(-2.0 * math.pi * corner / RATE)
    turn = np.exp(2j * np.pi * found.frequencies / RATE)
    assert found.gain == pytest.approx((1.0 - pole) / (turn - pole), rel=1e-9)


def test_an_integrator_does_not_settle() -> None:
    found = response(chain(DiscreteIntegrator(gain=1.0, output_unit="s")), "u.output", "a.output")
    assert found.step is None
    assert math.isinf(found.at_rest)
    assert any("does not settle" in note for note in found.notes)


@pytest.mark.defect("S966", before="times of a step begin at the output's first value", after="at the step itself")
@pytest.mark.parametrize(("source", "output"), [(0.0, 0.08), (0.03, 0.05), (0.03, 0.0)])
def test_the_times_of_a_step_count_from_the_step_where_clocks_are_offset(source: float, output: float) -> None:
    """The low-pass passes 98 % on the straight line between two values of 1 - exp(-t / tau)."""
    graph = Graph(
        name="",
        rate="10 Hz",
        blocks={"u": Constant(), "a": LowPass(corner_frequency=2.0), "b": Gain()},
        wires=["u.output -> a.input", "a.output -> b.input"],
        offsets={"u": f"{source} s", "b": f"{output} s"},
    )
    times = (output - source) % 0.1 + 0.1 * np.arange(100)
    values = 1.0 - np.exp(-4.0 * np.pi * times)
    step = response(graph, "u.output", "b.output").step
    assert step is not None
    assert step.settling == pytest.approx(np.interp(0.98, values, times), rel=1e-9)


def test_what_no_wire_reaches_is_refused() -> None:
    graph = Graph(name="", rate="1 kHz", blocks={"u": Constant(), "v": Constant()})
    with pytest.raises(ModelError, match=r"u\.output does not move v\.output"):
        response(graph, "u.output", "v.output")


@pytest.mark.defect("S404", before="the nearest of the frequencies that are shown", after="the peak, to rounding")
@pytest.mark.parametrize("numerator", [(0.0, 1.0), (1.0, -1.0)])  # a low-pass filter, a band-pass filter
@pytest.mark.parametrize("quality", [2.5, 40.0])
@pytest.mark.parametrize("frequencies", [(), (1.0, 400.0)])
def test_the_peak_and_the_band_edges(
    quality: float, numerator: tuple[float, float], frequencies: tuple[float, ...]
) -> None:
    """Against the quotient of polynomials, its largest size and where it is 3 dB less."""
    turn = 2.0 * math.pi * 79.67 / RATE
    size = math.exp(-0.5 * turn / quality)
    denominator = (1.0, -2.0 * size * math.cos(turn), size * size)
    block = DiscreteTransferFunction(numerator=(*numerator, 0.0), denominator=denominator)
    found = response(chain(block), "u.output", "a.output", frequencies=frequencies)

    def gain(f: float) -> float:
        z = np.exp(2j * np.pi * f / RATE)
        return float(abs(np.polyval((*numerator, 0.0), z) / np.polyval(denominator, z)))

    width = 79.67 / quality
    options = {"xatol": 1e-9}
    bounds = (79.67 - width, 79.67 + 0.5 * width)
    best = scipy.optimize.minimize_scalar(lambda f: -gain(f), bounds=bounds, method="bounded", options=options)
    assert found.peak == (pytest.approx(best.x, rel=1e-6), pytest.approx(-best.fun, rel=1e-12))
    level = math.sqrt(0.5) * (gain(0.0) if numerator[0] == 0.0 else -best.fun)
    high = scipy.optimize.brentq(lambda f: gain(f) - level, best.x, 0.5 * RATE, xtol=1e-12)
    assert found.corners[1] == pytest.approx(high, rel=1e-9)
    if numerator[0]:
        low = scipy.optimize.brentq(lambda f: gain(f) - level, 0.0, best.x, xtol=1e-12)
        assert found.corners[0] == pytest.approx(low, rel=1e-9)
    else:
        assert found.corners[0] is None


@pytest.mark.parametrize("quality", [100.0, 1e4])
def test_straight_lines_between_the_frequencies_shown_follow_a_resonance(quality: float) -> None:
    turn = 2.0 * math.pi * 79.67 / RATE
    size = math.exp(-0.5 * turn / quality)
    denominator = (1.0, -2.0 * size * math.cos(turn), size * size)
    found = response(
        chain(DiscreteTransferFunction(numerator=(0.0, 1.0, 0.0), denominator=denominator)), "u.output", "a.output"
    )
    f = 79.67 * (1.0 + np.linspace(-8.0, 8.0, 400) / (2.0 * quality))
    z = np.exp(2j * np.pi * f / RATE)
    drawn = np.interp(f, found.frequencies, 20.0 * np.log10(np.abs(found.gain)))
    assert drawn == pytest.approx(20.0 * np.log10(np.abs(z / np.polyval(denominator, z))), abs=0.7)  # dB


def test_the_largest_gain_of_a_low_pass_filter_is_at_rest() -> None:
    assert response(first_order(0.9), "u.output", "a.output").peak == (0.0, pytest.approx(1.0, rel=1e-12))


@pytest.mark.defect("S969", before="a lag of 432 deg met a limit of -100 deg: -72 deg", after="all turns are counted")
@pytest.mark.parametrize(("ticks", "gain", "at_rest"), [(4, 1.0, 0.0), (400, 1.0, 0.0), (400, -2.0, 180.0)])
def test_the_phase_counts_turns_from_rest_whatever_frequencies_are_asked_for(
    ticks: int, gain: float, at_rest: float
) -> None:
    graph = chain(Delay(ticks=ticks), Gain(gain=gain))
    whole = response(graph, "u.output", "b.output")
    lags = 360.0 * ticks * whole.frequencies / RATE
    assert np.degrees(whole.phase) == pytest.approx(at_rest - lags, abs=1e-6)
    single = response(graph, "u.output", "b.output", frequencies=[300.0])
    assert value_of_response(single, "phase") == pytest.approx(at_rest - 108.0 * ticks, abs=1e-6)


@pytest.mark.defect("S971", before="at 700 Hz the gain of 300 Hz, of values at 1 kHz", after="refused: 0 to 500 Hz")
@pytest.mark.parametrize("frequency", [700.0, -3.0, math.nan, 1e9])
def test_frequencies_beyond_half_the_rates_are_refused(frequency: float) -> None:
    graph = chain(LowPass(corner_frequency=100.0), Gain())
    with pytest.raises(ModelError, match="no response at this frequency"):
        response(graph, "u.output", "b.output", frequencies=[frequency])
    wanted = {"gain": {"response": "b.output", "input": "u.output", "frequency": frequency}}
    with pytest.raises(ModelError, match="frequency"):
        worst(graph, wanted, tolerances={"b.gain": "5 %"}, samples=1)


def test_a_fast_source_has_a_response_beyond_half_the_rate_of_what_it_moves() -> None:
    graph = chain(Gain(), Gain(), rates=("1 kHz", "100 Hz"))
    assert abs(response(graph, "u.output", "b.output", frequencies=[450.0]).gain[0]) == pytest.approx(1.0)


@pytest.mark.defect("H897", before="a response through 4,000 ticks of delay takes minutes", after="8 s")
@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("ticks", [200, 4_000])
def test_behind_a_long_delay_everything_is_late_and_else_the_same(ticks: int) -> None:
    filtered = LowPass(corner_frequency=10.0)
    plain = response(chain(filtered), "u.output", "a.output")
    late = response(chain(Delay(ticks=ticks), filtered), "u.output", "b.output", frequencies=plain.frequencies)
    turn = np.exp(-2j * np.pi * plain.frequencies * ticks / RATE)
    assert late.gain == pytest.approx(plain.gain * turn, rel=1e-9)
    assert late.delay == pytest.approx(plain.delay + ticks / RATE, rel=1e-6)
    assert late.bandwidth == pytest.approx(plain.bandwidth, rel=1e-9)
    assert plain.step is not None
    assert late.step is not None
    assert late.step.rise == pytest.approx(plain.step.rise, rel=1e-6)
    assert late.step.settling == pytest.approx(plain.step.settling + ticks / RATE, rel=1e-9)


@pytest.mark.defect("S981", before="two integrators began at +180 deg: 176.4 deg at 10 Hz", after="-183.6 deg")
def test_the_phase_of_two_integrators_begins_at_half_a_turn_behind() -> None:
    """T / (z - 1) is -90 deg - w T / 2."""
    graph = chain(*[DiscreteIntegrator(output_unit="1")] * 2)
    found = response(graph, "u.output", "b.output", frequencies=[1.0, 10.0])
    assert np.degrees(found.phase) == pytest.approx([-180.36, -183.6], abs=1e-6)


@pytest.mark.defect("S1057", before="over 64 ticks off by 0.4 %, or none was found", after="as over 32")
@pytest.mark.parametrize("levels", [2, 3, 16])
@pytest.mark.parametrize("ratio", [32, 64, 200])
def test_a_modulator_has_the_same_response_whatever_number_of_values_is_averaged(levels: int, ratio: int) -> None:
    """Its level counts as what it is chosen for: V = g1 g2 / ((z - 1)^2 + g2 (z - 1) + g1 g2) U, both gains 1/2."""
    frequencies = np.array([0.01, 0.1, 1.0])
    mean = chain(SigmaDeltaModulator(levels=levels, unit="1"), Decimator(ratio=ratio))
    ports = [f"{wire.source} -> {wire.target}".replace("a.code", "a.output") for wire in mean.wires]
    graph = Graph(name="", rate="1 kHz", blocks=dict(mean.blocks) | {"u": Constant(value=0.13)}, wires=ports)
    found = response(graph, "u.output", "b.mean", frequencies=frequencies.tolist())
    z = np.exp(2j * np.pi * frequencies / RATE)
    modulated = 0.25 / ((z - 1.0) ** 2 + 0.5 * (z - 1.0) + 0.25)
    boxcar = np.mean([z**-k for k in range(1, ratio + 1)], axis=0)
    assert found.gain == pytest.approx(modulated * boxcar, rel=1e-9)
    assert found.notes == ()


@pytest.mark.defect("C898", before="ValueError or TypeError of Python", after="must be a list of numbers")
@pytest.mark.parametrize("given", [np.array([[1.0, 2.0]]), 5.0, np.float64(5.0), ["1 Hz"], [True], "12", [None]])
def test_frequencies_are_a_list_of_numbers(given: Any) -> None:
    graph = Graph(
        name="",
        rate=1000,
        blocks={"noise": WhiteNoise(density=1.0), "gain": Gain()},
        wires=["noise.output -> gain.input"],
    )
    with pytest.raises(ModelError, match="frequencies: must be a list of numbers"):
        response(graph, "noise.output", "gain.output", frequencies=given)
    with pytest.raises(ModelError, match="frequencies: must be a list of numbers"):
        noise(graph, "gain.output", frequencies=given)


def test_frequencies_of_numpy_are_numbers() -> None:
    assert frequencies_of(np.array([1, 2], dtype=np.int32)) == [1.0, 2.0]
    assert frequencies_of((np.float32(0.5), 1)) == [0.5, 1.0]
    assert frequencies_of(()) == []
