"""Random loops against polynomials of their own numbers, and what lies at the end of the frequency axis."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import proofmass
from proofmass.blocks import Constant, Difference, Gain, TransferFunction
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.rational import transfer
from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.analysis.margins.plot import plot_margins
from proofmass.runner.analysis.margins.scalar import figures_of
from proofmass.runner.command_line import main
from tests.by_hand.polynomial_loops import Truth, analog_loop, ringed_loop, sampled_loop

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
    return figures_of(loop, False, 0.0, True)


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
        assert found.stable == (truth.outside < 0.0)
    ends = [end for interval in found.stable_gains for end in interval]
    assert ends == pytest.approx([end for interval in truth.stable_gains for end in interval], rel=1e-6)
    if found.stable:
        assert amounts(found) == pytest.approx(amounts(truth), rel=1e-6)


def amounts(of: Figures | Truth) -> dict[str, float]:
    return {name: math.inf if (value := getattr(of, name)) is None else value for name in _NAMES}


@pytest.mark.defect("S401", before="only the interval of stable gains about 1", after="all of them")
@pytest.mark.parametrize("first", range(0, 50, _SAMPLE))
@pytest.mark.parametrize("loop", [analog_loop, sampled_loop, ringed_loop])
def test_random_loops(loop: Callable[[int], tuple[Graph, Truth]], first: int) -> None:
    for number in range(first, first + _SAMPLE):
        check(loop, number)


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(50, 550, 50))
@pytest.mark.parametrize("loop", [analog_loop, sampled_loop, ringed_loop])
def test_a_thousand_random_loops(loop: Callable[[int], tuple[Graph, Truth]], first: int) -> None:
    for number in range(first, first + 50):
        check(loop, number)
