"""Loops among continuous blocks: what parameters do to their margins, and several of them at once; closed forms."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import proofmass
from proofmass.blocks import Constant, Difference, Gain, LowPass, Product, Sum, TransferFunction, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.analysis.margins.sensitivity import margin_sensitivities
from proofmass.runner.analysis.several.together import margins_together
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan

INTEGRAL = {"numerator": (1.0,), "denominator": (1.0, 0.0)}  # 1 / s without a unit


def slopes(graph: Graph, wire: str, at: str = "auto") -> dict[str, dict[str, float]]:
    """Derivatives of the margins by the parameters."""
    planned = plan(graph)
    points = OperatingPoints(planned, at)
    node = node_of(planned, wire)
    found = margin_sensitivities(
        planned, margins_of(points.loop(node), "main", wire), points.loop(node, by_parameters=True)
    )
    return {one.quantity.removeprefix("main: "): {e.parameter: e.derivative for e in one.effects} for one in found}


def servo(corner: float = 2.0, gain: float = 3.0, **parts: tuple[float, ...]) -> Graph:
    """L = gain / s w / (s + w) with w = 2 pi corner, times the transfer function of the parts."""
    blocks: dict[str, Block] = {
        "error": Difference(),
        "amplifier": Gain(gain=gain),
        "integral": TransferFunction(**INTEGRAL),
        "lag": LowPass(corner_frequency=corner),
        "set": Constant(value=0.3),
    }
    wires = [
        "set.output -> error.first",
        "lag.output -> error.second",
        "error.output -> amplifier.input",
        "amplifier.output -> integral.input",
    ]
    if parts:
        blocks["more"] = TransferFunction(**parts)
        wires += ["integral.strictly_proper_part -> more.input", "more.strictly_proper_part -> lag.input"]
    else:
        wires += ["integral.strictly_proper_part -> lag.input"]
    return Graph(name="servo", rate=1000, blocks=blocks, wires=wires)


def test_phase_and_delay_margin_of_a_servo_of_second_order() -> None:
    """|L| = 1 at the root of w^4 + a^2 w^2 = (k a)^2, where 180 deg + arg L = 90 deg - atan(w / a)."""
    k, a = 3.0, 4.0 * math.pi

    def values(k: float, a: float) -> tuple[float, float]:
        w = math.sqrt(0.5 * (math.sqrt(a**4 + 4.0 * (k * a) ** 2) - a * a))
        lag = 0.5 * math.pi - math.atan(w / a)
        return math.degrees(lag), lag / w

    found = slopes(servo(), "error.output")
    for number, name in enumerate(("phase margin", "delay margin")):
        by_gain = (values(k + 1e-5, a)[number] - values(k - 1e-5, a)[number]) / 2e-5
        by_corner = (values(k, a + 1e-5)[number] - values(k, a - 1e-5)[number]) / 2e-5 * 2.0 * math.pi
        assert found[name]["amplifier.gain"] == pytest.approx(by_gain, rel=1e-7)
        assert found[name]["lag.corner_frequency"] == pytest.approx(by_corner, rel=1e-7)
    assert "gain margin" not in found, "two poles leave any gain"


def test_gain_margin_of_a_servo_of_third_order() -> None:
    """k a / (s (s + a)(s + b)) is real at w^2 = a b: the margin is (a + b) b / (k c) with a DC gain c / b behind k."""
    a, b, c, k = 4.0 * math.pi, 7.0, 5.0, 3.0
    found = slopes(servo(numerator=(c,), denominator=(1.0, b)), "amplifier.output")["gain margin"]
    db = 20.0 / math.log(10.0)
    assert found["amplifier.gain"] == pytest.approx(-db / k, rel=1e-9)
    assert found["lag.corner_frequency"] == pytest.approx(db / (a + b) * 2.0 * math.pi, rel=1e-9)
    assert found["more.numerator[0]"] == pytest.approx(-db / c, rel=1e-9)
    assert found["more.denominator[1]"] == pytest.approx(db * (1.0 / (a + b) + 1.0 / b), rel=1e-9)


@pytest.mark.exhaustive
def test_the_operating_point_moves_with_the_parameters() -> None:
    """x' = w (v - x^2 - x) rests at x = (sqrt(1 + 4 v) - 1) / 2; L = 2 x w / (s + w) with w = 2 pi.

    |L| = 1 at w sqrt(4 x^2 - 1), where 180 deg + arg L = 180 deg - atan(sqrt(4 x^2 - 1)).
    """
    blocks: dict[str, Block] = {
        "set": Constant(value=2.0),
        "error": Difference(),
        "lag": LowPass(corner_frequency=1.0),
        "square": Product(),
    }
    wires = [
        "set.output -> error.first",
        "square.output -> error.second",
        "error.output -> lag.input",
        "lag.output -> square.first",
        "lag.output -> square.second",
    ]
    graph = Graph(name="square", rate=1000, blocks=blocks, wires=wires)
    v, x = 2.0, 1.0
    root = math.sqrt(4.0 * x * x - 1.0)
    by_x = -4.0 * x / root / (4.0 * x * x)  # of the phase: -d atan(root) / dx
    expected = math.degrees(by_x / math.sqrt(1.0 + 4.0 * v))
    found = slopes(graph, "square.output", at="settled")
    assert found["phase margin"]["set.value"] == pytest.approx(expected, rel=1e-6)


def satellite() -> Graph:
    """Doyle's spinning satellite: x' = 10 y + u, y' = -10 x + v, measured x + 10 y and y - 10 x."""
    blocks: dict[str, Block] = {
        "x": TransferFunction(**INTEGRAL),
        "y": TransferFunction(**INTEGRAL),
        "turn_x": Gain(gain=10.0),
        "turn_y": Gain(gain=-10.0),
        "rate_x": Sum(),
        "rate_y": Sum(),
        "seen_x": Sum(),
        "seen_y": Sum(),
        "back_x": Gain(gain=-1.0),
        "back_y": Gain(gain=-1.0),
    }
    wires = [
        "rate_x.output -> x.input",
        "rate_y.output -> y.input",
        "y.strictly_proper_part -> turn_x.input",
        "x.strictly_proper_part -> turn_y.input",
        "turn_x.output -> rate_x.first",
        "turn_y.output -> rate_y.first",
        "x.strictly_proper_part -> seen_x.first",
        "turn_x.output -> seen_x.second",
        "y.strictly_proper_part -> seen_y.first",
        "turn_y.output -> seen_y.second",
        "seen_x.output -> back_x.input",
        "seen_y.output -> back_y.input",
        "back_x.output -> rate_x.second",
        "back_y.output -> rate_y.second",
    ]
    loops = {"x": {"open_at": "back_x.output"}, "y": {"open_at": "back_y.output"}}
    return Graph(name="satellite", rate=1000, blocks=blocks, wires=wires, loops=loops)


@pytest.mark.exhaustive
def test_the_spinning_satellite() -> None:
    """Each loop alone has any gain and 90 deg, both at once next to nothing (Zhou, 1996, section 9.6).

    diskmargin of the Robust Control Toolbox gives 0.0997. With s = j w the disk's largest value is that of
    (s - 1) / (s + 1) / 2 and -10 / (s + 1), a rotation: |(j w - 1) / 2 + 10 j| / |1 + j w|.
    """
    found = margins_together(satellite())
    w = np.linspace(0.0, 0.2, 200_001)
    exact = 1.0 / np.max(np.abs((1j * w - 1.0) / 2.0 + 10j) / np.abs(1.0 + 1j * w))
    assert found.verdict == "stable"
    assert found.margin == pytest.approx(exact, rel=1e-6)
    assert found.margin == pytest.approx(0.0997, abs=1e-4)
    assert found.alone == pytest.approx((2.0, 2.0), rel=1e-6)
    assert found.frequency == pytest.approx(0.05 / (2.0 * math.pi), rel=0.1)
    assert found.reached == pytest.approx(exact, rel=1e-6)
    for name in found.loops:
        alone = proofmass.margins(satellite(), name)
        assert (alone.gain_margin, alone.disk_margin) == (None, pytest.approx(2.0, rel=1e-6))
        assert alone.phase_margin == pytest.approx(0.5 * math.pi, rel=1e-9)


def test_the_critical_factors_make_it_unstable() -> None:
    """The eigenvalues of the two states by hand, with the factors found: on the axis; a little inside: stable."""
    found = margins_together(satellite())
    turn, seen = np.array([[0.0, 10.0], [-10.0, 0.0]]), np.array([[1.0, 10.0], [-10.0, 1.0]])
    poles = np.linalg.eigvals(turn - np.diag(found.factors) @ seen)
    assert np.max(poles.real) == pytest.approx(0.0, abs=1e-6)
    inside = [1.0 + 0.98 * (factor - 1.0) for factor in found.factors]
    assert np.max(np.linalg.eigvals(turn - np.diag(inside) @ seen).real) < 0.0


@pytest.mark.defect("S857", before="0.227, the room of the other loop", after="0.0510")
def test_a_narrow_resonance_beside_another_loop_is_not_passed_over() -> None:
    """k w^2 / (s^2 + 2 z w s + w^2) of 1 kHz moves a servo that leaves 0.227 alone, and is not moved back."""
    k, z, w = 0.04, 1e-3, 2000.0 * math.pi
    blocks: dict[str, Block] = {
        "x": TransferFunction(numerator=(w * w,), denominator=(1.0, 2.0 * z * w, w * w)),
        "y": TransferFunction(numerator=(50.0,), denominator=(1.0, 11.0, 10.0, 0.0)),
        "back_x": Gain(gain=-k),
        "back_y": Gain(gain=-1.0),
        "sum": Sum(),
    }
    wires = [
        "back_x.output -> x.input",
        "x.strictly_proper_part -> back_x.input",
        "x.strictly_proper_part -> sum.first",
        "back_y.output -> sum.second",
        "sum.output -> y.input",
        "y.strictly_proper_part -> back_y.input",
    ]
    found = margins_together(
        Graph(name="two", rate=1000, blocks=blocks, wires=wires), ["back_x.output", "back_y.output"]
    )
    s = 1j * w * np.linspace(1.0, 1.05, 50_001)
    loop = k * w * w / (s * s + 2.0 * z * w * s + w * w)
    assert found.margin == pytest.approx(1.0 / np.max(np.abs(1.0 / (1.0 + loop) - 0.5)), rel=1e-6)


@pytest.mark.exhaustive
def test_a_sampled_and_a_continuous_loop_are_refused_together() -> None:
    graph = satellite()
    blocks = {**graph.blocks, "held": UnitDelay(), "outer": Gain(gain=-0.1), "lag": LowPass(), "plus": Sum()}
    wires = [str(w) for w in graph.wires]
    wires += ["held.output -> outer.input", "outer.output -> lag.input", "lag.output -> plus.first"]
    wires += ["set.output -> plus.second", "plus.output -> held.input"]
    blocks["set"] = Constant()
    both = Graph(name="both", rate=1000, blocks=blocks, wires=wires)
    with pytest.raises(ModelError) as caught:
        margins_together(both, ["back_x.output", "held.output"])
    (problem,) = caught.value.problems
    assert problem.message == "loop held.output is opened where signals are sampled, loop back_x.output is not"
    assert problem.hint == "open all of them at sampled or held outputs"


@pytest.mark.exhaustive
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, picture = tmp_path / "satellite.toml", tmp_path / "satellite.svg"
    path.write_text(write_graph(satellite()))
    assert main(["margins", str(path), "--together", "--json", "--plot", str(picture)]) == 0
    assert json.loads(capsys.readouterr().out)["disk_margin"] == pytest.approx(0.0997, abs=1e-4)
    assert picture.stat().st_size > 5_000
    assert main(["margins", str(path), "--together"]) == 0
    assert "0.0997" in capsys.readouterr().out
