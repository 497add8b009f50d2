"""Random loops against polynomials of their own numbers, and what lies at the end of the frequency axis."""

import json
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import proofmass
from proofmass.blocks import Constant, Difference, Gain, TransferFunction
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.rational import transfer
from proofmass.runner.analysis.margins.axis import CertifiedAxis
from proofmass.runner.analysis.margins.delays import is_at_least
from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.analysis.margins.plot import plot_margins
from proofmass.runner.analysis.margins.scalar import figures_of
from proofmass.runner.command_line import main
from tests.by_hand.lifted_loops import MOST_DELAYED
from tests.by_hand.polynomial_loops import Truth, analog_loop, ringed_loop, sampled_loop
from tests.by_hand.turning_loops import drawn, turning_loop

_NAMES = ("gain_margin", "gain_reduction", "phase_margin", "delay_margin", "disk_margin", "sensitivity_peak")
_SAMPLE = 5  # loops in a test


def first_order(numerator: float, corner: float) -> Graph:
    """L = numerator / (s + corner)."""
    return Graph(
        name="first order",
        rate="1 kHz",
        duration="10 ms",
        blocks={
            "zero": Constant(value=0.0),
            "error": Difference(),
            "plant": TransferFunction(numerator=(numerator,), denominator=(1.0, corner)),
            "gain": Gain(gain=1.0),
        },
        wires=[
            "zero.output -> error.first",
            "gain.output -> error.second",
            "error.output -> plant.input",
            "plant.strictly_proper_part -> gain.input",
        ],
        loops={"main": {"open_at": "gain.output"}},
    )


@pytest.mark.exhaustive
@pytest.mark.defect("C400", before="k / s ends margins in ZeroDivisionError", after="sensitivity peak 1, disk margin 2")
def test_an_integrator(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = proofmass.margins(first_order(9.0, 0.0))
    assert found.stable
    assert (found.gain_margin, found.stable_gains) == (None, ((0.0, math.inf),))
    assert found.phase_margin == pytest.approx(0.5 * math.pi, rel=1e-12)
    assert found.delay_margin == pytest.approx(0.5 * math.pi / 9.0, rel=1e-12)
    assert found.bandwidth == pytest.approx(9.0 / (2.0 * math.pi), rel=1e-12)
    assert (found.sensitivity_peak, found.disk_margin, found.distance) == (1.0, 2.0, 1.0)
    assert found.sensitivity_peak_frequency == math.inf
    plot_margins(found)
    file = tmp_path / "loop.toml"
    file.write_text(write_graph(first_order(9.0, 0.0)))
    assert main(["margins", str(file), "--json"]) == 0
    (loop,) = json.loads(capsys.readouterr().out)["loops"]
    assert (loop["sensitivity_peak_db"], loop["sensitivity_peak_frequency_hz"]) == (0.0, None)
    assert main(["margins", str(file)]) == 0
    assert "0.00 dB, in the limit of high frequencies" in capsys.readouterr().out


@pytest.mark.defect("S400", before="peak -20 dB, disk margin 2.5, distance 10", after="0 dB, 2 and 1")
def test_a_first_order_lag() -> None:
    """L = 900 / (s + 100): S rises to 1, and S - T from -0.8 to 1."""
    found = proofmass.margins(first_order(900.0, 100.0))
    assert (found.sensitivity_peak, found.disk_margin, found.distance) == (1.0, 2.0, 1.0)


def through(direct: float) -> Figures:
    """L = direct + 1 / (s + 1) in continuous time."""
    loop = transfer(np.array([[-1.0]]), np.array([1.0]), np.array([1.0]), direct)
    assert loop is not None
    return figures_of(CertifiedAxis(loop, False), 0.0, True)


def test_loops_with_a_direct_path() -> None:
    """L reaches its direct part at infinite frequency: there a pole passes, and no delay is small enough beyond 1."""
    found = through(-0.5)
    assert (found.gain_margin, found.gain_margin_frequency) == (2.0, math.inf)
    assert found.phase_crossovers == ()
    assert found.sensitivity_peak == 2.0
    assert through(2.0).delay_margin == 0.0
    assert through(2.0).delay_margin_frequency == math.inf
    assert through(0.5).delay_margin == pytest.approx((math.pi - _lag(0.5)) / _crossover(0.5), rel=1e-12)


def _crossover(direct: float) -> float:
    """Return where |direct + 1 / (1 + j w)| = 1."""
    return math.sqrt(((1.0 + direct) ** 2 - 1.0) / (1.0 - direct**2))


def _lag(direct: float) -> float:
    value = direct + 1.0 / complex(1.0, _crossover(direct))
    return -math.atan2(value.imag, value.real)


def test_a_loop_that_a_lower_gain_makes_unstable() -> None:
    """s^3 + f (s + 1)^2 is stable above f = 1/2, by Routh."""
    graph = first_order(1.0, 0.0)
    blocks = {**graph.blocks, "plant": TransferFunction(numerator=(1.0, 2.0, 1.0), denominator=(1.0, 0.0, 0.0, 0.0))}
    found = proofmass.margins(graph.bare(blocks=blocks))
    assert found.stable_gains == ((pytest.approx(0.5, rel=1e-12), math.inf),)


def check(loop: Callable[[int], tuple[Graph, Truth]], number: int) -> None:
    graph, truth = loop(number)
    found = proofmass.margins(graph, "main")
    if abs(truth.outside) > 1e-12:
        assert found.stable == (truth.outside < 0.0), number
    ends = [end for interval in found.stable_gains for end in interval]
    assert ends == pytest.approx([end for interval in truth.stable_gains for end in interval], rel=1e-6), number
    if found.stable:
        expected = {name: value for name, value in amounts(truth).items() if not math.isnan(value)}
        delay = amounts(found)["delay_margin"]
        if is_at_least(found.system, found.gain_crossovers, delay):
            assert expected.pop("delay_margin") >= delay, number
        elif found.system.per_period > 1 and math.isinf(truth.delay_margin or 0.0):
            assert expected.pop("delay_margin") >= delay >= MOST_DELAYED * found.sample, number
        assert {name: amounts(found)[name] for name in expected} == pytest.approx(expected, rel=1e-6), number


def amounts(of: Figures | Truth) -> dict[str, float]:
    return {name: math.inf if (value := getattr(of, name)) is None else value for name in _NAMES}


@pytest.mark.exhaustive(but=3)
@pytest.mark.exhaustive(
    "analog_loop-40",
    "sampled_loop-45",
    "ringed_loop-0",
    "ringed_loop-5",
    "ringed_loop-10",
    "ringed_loop-15",
    "ringed_loop-20",
    "ringed_loop-25",
    "ringed_loop-30",
    "analog_loop-0",
    "analog_loop-5",
    "analog_loop-15",
    "analog_loop-20",
    "analog_loop-25",
    "analog_loop-30",
    "sampled_loop-10",
    "sampled_loop-20",
    "ringed_loop-35",
    "ringed_loop-40",
    "ringed_loop-45",
    "analog_loop-10",
    "analog_loop-35",
    "sampled_loop-5",
    "sampled_loop-35",
)
@pytest.mark.defect("S401", before="only the interval of stable gains about 1", after="all of them")
@pytest.mark.parametrize("first", range(0, 50, _SAMPLE))
@pytest.mark.parametrize("loop", [analog_loop, sampled_loop, ringed_loop])
def test_random_loops(loop: Callable[[int], tuple[Graph, Truth]], first: int) -> None:
    for number in range(first, first + _SAMPLE):
        check(loop, number)


@pytest.mark.exhaustive(but=3)
@pytest.mark.exhaustive(
    "1004",
    "1017",
    "1037",
    "1026",
    "1028",
    "1029",
    "1035",
    "1036",
    "1024",
    "1011",
    "1019",
    "1030",
    "1032",
    "1010",
    "1033",
    "1034",
    "1039",
)
@pytest.mark.parametrize("number", [1004, 1008, *range(1010, 1013), 1014, 1017, 1019, *range(1024, 1040)])
def test_random_loops_that_turn(number: int) -> None:
    check(partial(turning_loop, longest=6), number)


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(50, 550, 50))
@pytest.mark.parametrize("loop", [analog_loop, sampled_loop, ringed_loop, turning_loop])
def test_two_thousand_random_loops(loop: Callable[[int], tuple[Graph, Truth]], first: int) -> None:
    for number in range(first, first + 50):
        check(loop, number)


@pytest.mark.exhaustive
@pytest.mark.defect("S671", before="the period of a counter, not of the mean too: stable", after="unstable")
@pytest.mark.parametrize("number", [93, 207])
def test_a_mean_beside_a_counter_is_back_after_the_periods_of_both(number: int) -> None:
    check(turning_loop, number)


@pytest.mark.exhaustive
@pytest.mark.defect("S672", before="narrow peaks of lifted loops too high by 2e-6 and 3e-5", after="right to 1e-9")
@pytest.mark.parametrize("number", [76, 79])
def test_narrow_peaks_of_several_values(number: int) -> None:
    check(turning_loop, number)


@pytest.mark.exhaustive
@pytest.mark.defect("S673", before="64 values at most, also where any delay is stable", after="70, 131 and no limit")
@pytest.mark.parametrize("number", [31, 72, 53])
def test_long_delays_of_several_values(number: int) -> None:
    check(turning_loop, number)


@pytest.mark.exhaustive
@pytest.mark.defect("C670", before="an error of its own where nothing moves but a place", after="an answer")
def test_a_mean_at_the_end_of_a_long_period() -> None:
    check(turning_loop, 96)


@pytest.mark.defect("C671", before="an error of its own: two poles at 1, one of them hidden", after="marginal")
def test_a_hidden_pole_at_one_that_is_not() -> None:
    graph, _ = drawn(212)
    assert proofmass.margins(graph, "main").verdict == "marginal"
