"""Sigma-delta modulators: loops by recursion, prediction by simulation, graphs by programs written anew."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate
from scipy import signal

from proofmass import Graph, ModelError, design_modulator, read_graph, simulate, write_graph
from proofmass.runner.design.modulators.noise_transfer import NoiseTransfer, synthesised
from proofmass.runner.design.modulators.prediction import _growth, _powers, predicted
from proofmass.runner.design.modulators.simulation import enough_samples
from proofmass.runner.design.modulators.structures import FORMS, Structure, loop_response, realised, scaled
from proofmass.runner.design.modulators.text import modulator_text


@pytest.mark.parametrize("order", [1, 2, 4, 7])
@pytest.mark.parametrize(("gain", "centre"), [(1.3, 0.0), (1.9, 0.0), (1.5, 0.1), (1.4, 0.4)])
def test_the_gain_is_reached_far_from_the_band_and_nowhere_passed(order: int, gain: float, centre: float) -> None:
    if centre and order % 2:
        order += 1
    if centre == 0.0 or order > 1:
        transfer = synthesised(order, 50, gain, centre=centre)
        gains = np.abs(transfer.at(np.linspace(0.0, 0.5, 2001)))
        assert np.abs(transfer.at(0.5 if centre < 0.25 else 0.0)) == pytest.approx(gain, rel=1e-12)
        assert gains.max() < gain * (1.02 if centre else 1.0 + 1e-9)
        assert max(map(abs, transfer.poles)) < 1.0


@pytest.mark.parametrize(("order", "centre"), [(2, 0.0), (3, 0.0), (5, 0.0), (6, 0.2)])
def test_no_shift_of_a_zero_lessens_the_noise_in_the_band(order: int, centre: float) -> None:
    half = 0.25 / 64 if centre else 0.5 / 64
    points = np.linspace(centre - half, centre + half, 4001)

    def noise(zeros: np.ndarray) -> float:
        """Return the power in the band, of zeros alone: the poles are far away."""
        z = np.exp(2j * math.pi * points)
        near = [z - zero for zero in zeros if centre == 0.0 or zero.imag > 0.0]
        return float(np.mean(np.abs(np.prod(near, axis=0)) ** 2))

    zeros = np.array(synthesised(order, 64, zeros="optimised", centre=centre).zeros)
    assert noise(zeros) < noise(np.array(synthesised(order, 64, zeros="none", centre=centre).zeros))
    for place, zero in enumerate(zeros):
        pair = np.abs(zeros - zero.conjugate()) < 1e-12
        for turn in (0.002 / 64, -0.002 / 64):
            moved = zeros.copy()
            if zero.imag == 0.0:
                continue
            moved[place], moved[pair] = zero * np.exp(1j * turn), (zero * np.exp(1j * turn)).conjugate()
            assert noise(moved) > noise(zeros)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("pulse", [None, (0.0, 1.0), (0.3, 0.8)])
def test_the_closed_loop_has_the_noise_transfer_function(form: str, pulse: tuple[float, float] | None) -> None:
    """An impulse of the quantiser's error in a loop of gain 1; states scaled or not."""
    wanted, structure = synthesised(5, 24, 1.4), Structure(form, 5, pulse)
    k = realised(wanted, structure, "first")
    expected = structure.reachable(wanted)
    response = signal.lfilter(np.poly(expected.zeros).real, np.poly(expected.poles).real, np.eye(1, 200)[0])
    for coefficients in (k, scaled(structure, k, [0.3, 2.0, 0.7, 5.0, 1.3])):
        rows, last = structure.stepped(coefficients)
        x, levels = np.zeros(5), []
        for error in np.eye(1, 200)[0]:
            levels.append(last[:5] @ x + error)
            x = rows[:, :5] @ x + rows[:, 6] * levels[-1]
        assert np.abs(levels - response).max() < 1e-7


@pytest.mark.parametrize(("form", "pulse"), [("CIFB", (0.0, 1.0)), ("CIFF", (0.25, 0.75))])
def test_a_continuous_loop_sees_what_a_discrete_one_sees(form: str, pulse: tuple[float, float]) -> None:
    """Impulse invariance: the integrators by a solver of differential equations, the discrete loop by its recursion."""
    wanted = synthesised(3, 64)
    k = realised(wanted, Structure(form, 3, pulse), "first")

    def slopes(time: float, x: np.ndarray) -> list[float]:
        level = 1.0 if pulse[0] <= time < pulse[1] else 0.0
        a = k.a if form == "CIFB" else (1.0, 0.0, 0.0)
        return [-a[0] * level, x[0] - k.g[0] * x[2] - a[1] * level, x[1] - a[2] * level]

    ends, x, seen = [0.0, *pulse, *range(1 if pulse[1] < 1.0 else 2, 13)], np.zeros(3), []
    for begin, end in itertools.pairwise(ends):
        if end > begin:
            x = scipy.integrate.solve_ivp(slopes, (begin, end - 1e-15), x, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
            seen += [x[2] if form == "CIFB" else k.a @ x] if end == int(end) else []
    discrete = realised(wanted, Structure("CRFB", 3), "first")
    assert seen == pytest.approx(loop_response(Structure("CRFB", 3), discrete, 12), abs=2e-10)


@pytest.mark.parametrize("amplitude", [0.05, 0.5, 0.85])
def test_gains_of_one_bit_by_drawing(amplitude: float) -> None:
    """Noise that a sign passes and adds, of a sine in Gaussian noise whose sizes give this amplitude at the output."""
    passed, added = _powers(amplitude)
    generator = np.random.default_rng(5)
    sine = np.sin(2.0 * np.pi * np.arange(400_000) / 400_000)
    noise = generator.standard_normal(400_000)
    sizes = np.geomspace(0.02, 8.0, 12)
    outputs = [2.0 * np.mean(np.sign(size * sine + noise) * sine) for size in sizes]
    size = np.exp(np.interp(amplitude, outputs, np.log(sizes)))
    bits = np.sign(size * sine + noise)
    gain = np.mean(bits * noise)
    rest = bits - amplitude * sine - gain * noise
    assert passed == pytest.approx(gain**2, rel=0.03)
    assert added == pytest.approx(np.mean(rest**2), rel=0.03)


def test_growth_is_the_power_of_the_impulse_response() -> None:
    transfer = synthesised(4, 32)
    n, d = np.poly(transfer.zeros).real, np.poly(transfer.poles).real
    for k in (0.7, 1.0, 1.6):
        response = signal.lfilter(n, (1.0 - k) * n + k * d, np.eye(1, 5000)[0])
        assert _growth(transfer, k) == pytest.approx(float(np.sum(response**2)), rel=1e-9)
    first = NoiseTransfer((1.0,), (0.0,))  # 1 - z^-1: at a gain k the power is 2 / (2 - k)
    assert _growth(first, 1.3) == pytest.approx(2.0 / 0.7)


@pytest.mark.parametrize(("order", "oversampling", "form"), [(3, 64, "CIFB"), (4, 48, "CRFF"), (5, 32, "CRFB")])
def test_prediction_of_one_bit_is_a_little_below_the_simulation(order: int, oversampling: float, form: str) -> None:
    """The quantiser sees less than Gaussian noise would have in its tails: the prediction is 1 to 6 dB low."""
    of = design_modulator(order, oversampling, form=form, samples=8192)
    pairs = [(p, s) for a, p, s in zip(of.amplitudes, of.predicted, of.simulated, strict=True) if -40.0 <= a <= -6.0]
    assert all(p is not None and s is not None and -1.0 < s - p < 7.0 for p, s in pairs)
    assert 1.0 < np.mean([s - p for p, s in pairs]) < 6.0
    last = max(a for a, s in zip(of.amplitudes, of.simulated, strict=True) if s is not None)
    assert abs(20.0 * math.log10(of.stable_limit) - last) < 2.5


def test_prediction_of_many_levels() -> None:
    """Noise of step^2 / 12 by an integral of its own, and the simulation within 1.5 dB."""
    of = design_modulator(3, 16, gain=4.0, levels=33, form="CRFF", samples=8192)
    frequencies = np.linspace(0.0, 1.0 / 32.0, 20001)
    power = 2.0 * np.trapezoid(np.abs(of.transfer.at(frequencies)) ** 2, frequencies) * (2.0 / 32.0) ** 2 / 12.0
    for amplitude, foretold, measured in zip(of.amplitudes, of.predicted, of.simulated, strict=True):
        if -40.0 <= amplitude <= -3.0:
            assert foretold == pytest.approx(amplitude + 10.0 * math.log10(0.5 / power), abs=1e-4)
            assert measured == pytest.approx(foretold, abs=1.5)


def run(graph: Graph, signal_name: str, samples: int, folder: Path) -> np.ndarray:
    """Return a signal of a graph that was written to a file."""
    file = folder / "loop.toml"
    file.write_text(write_graph(graph), encoding="utf-8")
    return np.asarray(simulate(read_graph(file), samples=samples)[signal_name].values)


def test_bits_of_the_graph_of_a_chain_of_resonators(tmp_path: Path) -> None:
    of = design_modulator(3, 64, samples=1024)
    (a1, a2, a3), (b1, *_), (c1, c2, c3), (g,) = (getattr(of.coefficients, letter) for letter in "abcg")
    x1 = x2 = x3 = 0.0
    expected = []
    for n in range(4000):
        u, v = 0.5 * math.sin(2.0 * math.pi * 103 * n / 65536), 1.0 if c3 * x3 >= 0.0 else -1.0
        x2_next = x2 + c1 * x1 - g * x3 - a2 * v
        x1, x2, x3 = x1 + b1 * u - a1 * v, x2_next, x3 + c2 * x2_next - a3 * v
        expected.append(v)
    assert (run(of.graph("2 MHz"), "quantiser.sign", 4000, tmp_path) == expected).all()


def test_levels_of_the_graph_of_a_feed_forward_chain(tmp_path: Path) -> None:
    of = design_modulator(4, 32, form="CIFF", feeds="all", levels=5, gain=3.0, samples=1024)
    a, (b, *_), c, (g1, g2) = (getattr(of.coefficients, letter) for letter in "abcg")
    x = [0.0] * 4
    expected = []
    for n in range(2000):
        u = 0.5 * math.sin(2.0 * math.pi * 205 * n / 65536)
        y = sum(weight * state for weight, state in zip(a, x, strict=True)) + u
        v = min(max(round((y + 1.0) * 2.0), 0), 4) / 2.0 - 1.0
        w = [b * u - c[0] * v - g1 * x[1], c[1] * x[0], c[2] * x[1] - g2 * x[3], c[3] * x[2]]
        x = [state + step for state, step in zip(x, w, strict=True)]
        expected.append(v)
    assert (run(of.graph(), "quantiser.output", 2000, tmp_path) == expected).all()


def test_bits_of_the_graph_of_a_continuous_loop(tmp_path: Path) -> None:
    of = design_modulator(3, 64, form="CIFF", pulse=(0.0, 1.0), samples=1024)
    a, (b, *_), (c1, c2, c3), (g,) = (getattr(of.coefficients, letter) for letter in "abcg")
    rates = np.zeros((5, 5))
    rates[:3] = [[0, 0, 0, b, -c1], [c2, 0, -g, 0, 0], [0, c3, 0, 0, 0]]
    step = scipy.linalg.expm(rates)[:3]
    x, expected = np.zeros(3), []
    for n in range(4000):
        u, v = 0.5 * math.sin(2.0 * math.pi * 103 * n / 65536), 1.0 if a @ x >= 0.0 else -1.0
        x = step @ [*x, u, v]
        expected.append(v)
    assert (run(of.graph("3.072 MHz"), "quantiser.sign", 4000, tmp_path) == expected).all()


def test_states_stay_within_the_swing_up_to_the_peak() -> None:
    of, plain = (design_modulator(4, 64, swing=swing, samples=2048) for swing in (0.8, None))
    assert list(of.amplitudes) == sorted({*of.amplitudes}), "up to full scale"
    assert of.amplitudes[-1] == 0.0
    assert of.swings == (0.8,) * 4
    assert of.simulated == pytest.approx(plain.simulated, abs=1e-6)
    assert [k / p for k, p in zip(of.coefficients.a, plain.coefficients.a, strict=True)] == pytest.approx(
        [0.8 / swing for swing in plain.swings]
    )
    rows, last = of.structure.stepped(of.coefficients)
    size, states = 10.0 ** (of.amplitudes[np.nanargmax(np.array(of.simulated, float))] / 20.0), [np.zeros(4)]
    for n in range(2000):
        u = size * math.sin(2.0 * math.pi * 5.0 * n / 2048.0)  # the odd number of periods next to a fifth of the band
        v = 1.0 if last[:5] @ [*states[-1], u] >= 0.0 else -1.0
        states.append(rows @ [*states[-1], u, v])
    assert np.abs(states).max(axis=0) == pytest.approx(0.8, abs=0.2)


@pytest.mark.parametrize(
    ("key", "options"),
    [
        ("order", {"order": 9}),
        ("oversampling", {"oversampling": 1.5}),
        ("gain", {"gain": 9.0}),
        ("gain", {"gain": 1.0}),
        ("zeros", {"zeros": "optimized"}),
        ("form", {"form": "CRBF"}),
        ("form", {"form": "CIFB", "order": 4, "centre": 0.25}),
        ("centre", {"centre": 0.25}),
        ("centre", {"centre": 0.499, "order": 4}),
        ("levels", {"levels": 1}),
        ("feeds", {"feeds": "last"}),
        ("feeds", {"feeds": "all", "pulse": (0.0, 1.0)}),
        ("pulse", {"pulse": (0.5, 1.5)}),
        ("samples", {"samples": 10}),
        ("samples", {"samples": 0}),
        ("samples", {"oversampling": 150, "samples": 1024}),
        ("oversampling", {"oversampling": 1e6}),
    ],
)
def test_what_cannot_be_designed_is_refused(key: str, options: dict[str, object]) -> None:
    with pytest.raises(ModelError) as refused:
        design_modulator(**{"order": 3, "oversampling": 64, **options})
    (problem,) = refused.value.problems
    assert problem.key == key
    assert problem.got
    assert problem.expected or problem.hint


@pytest.mark.defect(
    "S1101",
    before="at an oversampling of 2048 each simulated ratio was 'overload', states were scaled by the least amplitude",
    after="a run as long as the band needs: 75 to 110 dB at -20 dB, and the first state swings by 1 at the peak",
)
@pytest.mark.exhaustive
def test_a_narrow_band_has_longer_runs() -> None:
    of = design_modulator(1, 2048, gain=1.9)
    ratios = dict(zip(of.amplitudes, of.simulated, strict=True))
    assert ratios[-20.0] is not None
    assert 75.0 < ratios[-20.0] < 110.0
    rows, last = of.structure.stepped(of.coefficients)
    size, x, most = 10.0 ** (of.peak[0] / 20.0), 0.0, 0.0
    for n in range(4096):
        u = size * math.sin(2.0 * math.pi * n / 4096.0)
        x = rows[0] @ [x, u, 1.0 if last[:2] @ [x, u] >= 0.0 else -1.0]
        most = max(most, abs(x))
    assert most == pytest.approx(1.0, rel=0.02)


def test_a_run_is_as_long_as_the_band_needs() -> None:
    of = design_modulator(1, 64, gain=1.9, samples=1024)
    assert enough_samples(16_384, of.band) == 16_384
    assert enough_samples(16_384, replace(of, oversampling=2048.0).band) == 65_536
    source = replace(of, oversampling=20_000.0).graph().blocks["input"]
    assert source.frequency / 1e6 < 0.5 / 20_000.0, "the tone lies in the band"


@pytest.mark.defect("H941", before="peak nan dB at nan dB of full scale", after="peak none: overload at each amplitude")
def test_a_loop_that_is_lost_at_each_amplitude_has_no_peak() -> None:
    of = design_modulator(5, 64, gain=6.0, samples=2048)
    assert of.simulated == (None,) * len(of.amplitudes)
    assert np.isnan(of.swings).all(), "states of a lost loop scale nothing"
    lines = modulator_text(of).splitlines()
    assert "  peak              none: overload at each amplitude, by simulation" in lines
    assert any(line.split() == ["swing", *["-"] * 5] for line in lines)


def test_a_pulse_of_half_a_period_has_no_graph() -> None:
    with pytest.raises(ModelError, match="pulse: has no graph"):
        design_modulator(2, 64, pulse=(0.5, 1.0), samples=1024).graph()


def test_overload_is_predicted() -> None:
    """A loop of order 6 with much gain is lost at a smaller amplitude than one with little."""
    limits = [predicted(synthesised(6, 64, gain), (0.0, 1 / 128), (0.1,), 2)[1] for gain in (1.3, 1.5, 1.8)]
    assert sorted(limits, reverse=True) == limits
    assert limits[0] - limits[2] > 0.1
