"""Sequences and gates that follow the time alone, where no number shows it at the ends of periods.

A signal at rest is zero on both sides of a gate, so that nothing tells when the gate opens but the gate itself.
"""

import math

import numpy as np
import pytest

from proofmass import Block, Graph, Input, margins, noise, param, response
from proofmass.blocks import (
    Constant,
    Decimator,
    Delay,
    Difference,
    DiscreteIntegrator,
    Product,
    RepeatingSequence,
    Sine,
    UnitDelay,
    WhiteNoise,
)
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.planning.plan import plan
from tests.by_hand.amounts import chosen

RATE = 80_000
WHITE = WhiteNoise(density=math.sqrt(2.0 / RATE))  # of variance one


class Gate(Block):
    """Gate that is shut in one of some ticks."""

    length: int = param("1", "Ticks.", default=4)
    shut: int = param("1", "The one in which nothing passes.", default=0)
    input = Input("1", "Signal.")


@Gate.output("1")
def gated(p: Gate, input: float, tick: int) -> float:
    """The input, or zero."""
    return 0.0 if tick % p.length == p.shut else input


class TurnedSign(Block):
    """Chopper that turns the sign of its input every `half` ticks."""

    half: int = param("1", "Ticks.", default=4)
    input = Input("1", "Signal.")


@TurnedSign.output("1")
def turned(p: TurnedSign, input: float, tick: int) -> float:
    """The input or its negative."""
    return input if tick // p.half % 2 == 0 else -input


@pytest.mark.defect("S813", before="rms 0.71, of windows in which nothing is shut", after="the mean of all windows")
@pytest.mark.parametrize("shut", chosen([0, 3], [1, 2]))
def test_windows_of_two_ticks_of_a_sequence_of_four(shut: int) -> None:
    """The mean of two is zero and one, or one and one, in turn: variances 1/4 and 1/2."""
    values = tuple(0.0 if n == shut else 1.0 for n in range(4))
    blocks = {"x": WHITE, "s": RepeatingSequence(values=values), "gate": Product(), "mean": Decimator(ratio=2)}
    wires = ["x.output -> gate.first", "s.output -> gate.second", "gate.output -> mean.input"]
    graph = Graph(name="windows", rate=RATE, blocks=blocks, wires=wires, samples=64)
    assert noise(graph, "mean.mean").rms == pytest.approx(math.sqrt(3.0 / 8.0))


@pytest.mark.exhaustive(but=3)
@pytest.mark.defect("S814", before="1, the rms of a gate that is open", after="that of all its ticks")
@pytest.mark.parametrize(("length", "shut"), [(4, 3), (7, 0), (12, 11), (300, 299), (300, 150)])
def test_a_gate_of_ones_own_that_reads_the_clock(length: int, shut: int) -> None:
    graph = Graph(
        name="gated", rate=RATE, blocks={"x": WHITE, "gate": Gate(length=length, shut=shut)},
        wires=["x.output -> gate.input"], samples=64,
    )  # fmt: skip
    assert noise(graph, "gate.gated").rms == pytest.approx(math.sqrt(1.0 - 1.0 / length))


def largest_gain(half: int) -> float:
    """The gain at which a turn of z[n+1] = z[n] + g s[n] u[n], u[n+1] = -s[n] z[n] has a value of size one."""

    def grows(gain: float) -> bool:
        turn = np.eye(2)
        for sign in (1.0, -1.0):
            turn = np.linalg.matrix_power(np.array([[1.0, gain * sign], [-sign, 0.0]]), half) @ turn
        return bool(np.max(np.abs(np.linalg.eigvals(turn))) > 1.0)

    low, high = 0.5, 1.5
    for _ in range(50):
        low, high = (low, 0.5 * (low + high)) if grows(0.5 * (low + high)) else (0.5 * (low + high), high)
    return low


@pytest.mark.exhaustive("10")
@pytest.mark.defect("S814", before="a limit of 266.7, that of no chopper", after="245 and 261, that of a turn")
@pytest.mark.parametrize("half", [10, 40])
def test_choppers_of_ones_own_about_a_delay(half: int) -> None:
    blocks = {
        "error": Difference(), "up": TurnedSign(half=half), "late": UnitDelay(), "down": TurnedSign(half=half),
        "sum": DiscreteIntegrator(gain=300.0, output_unit="1"), "x": WHITE,
    }  # fmt: skip
    wires = [
        "x.output -> error.first", "sum.output -> error.second", "error.output -> up.input", "up.turned -> late.input",
        "late.output -> down.input", "down.turned -> sum.input",
    ]  # fmt: skip
    graph = Graph(
        name="chopped", rate=RATE, blocks=blocks, wires=wires, samples=64, loops={"main": {"open_at": "sum.output"}}
    )
    assert margins(graph).gain_margin == pytest.approx(largest_gain(half) * RATE / 300.0, rel=1e-6)


@pytest.mark.defect("S816", before="the row that was asked for first, whatever was held", after="one for each question")
def test_a_gate_with_its_signal_held_is_not_taken_for_one_that_runs_alone() -> None:
    """Its signal is zero: it leaves zeros, but something where that is held away from zero."""
    graph = Graph(
        name="gated", rate=RATE, blocks={"rest": Constant(value=0.0), "gate": Gate(length=4, shut=0)},
        wires=["rest.output -> gate.input"], samples=64,
    )  # fmt: skip
    onward, nodes = Course(plan(graph)).onward(0), [("gate", "gated")]
    held = onward.wires(nodes, 8, frozenset(), {"gate"}, ())[:, 0]
    assert (held != 0.0).tolist() == [False, True, True, True] * 2
    assert not onward.wires(nodes, 8, {"rest", "gate"}, frozenset(), ()).any()


@pytest.mark.exhaustive(but=4)
@pytest.mark.defect("S817", before="1, the gain of the first tick", after="the mean of all ticks")
@pytest.mark.parametrize("source", [Constant(value=0.0), Sine(frequency=20_000.0, amplitude=0.0), WHITE])
@pytest.mark.parametrize(("length", "shut"), [(4, 3), (7, 5), (300, 150)])
def test_the_response_of_a_gate_right_behind_a_source_at_rest(source: Block, length: int, shut: int) -> None:
    graph = Graph(
        name="gated", rate=RATE, blocks={"x": source, "gate": Gate(length=length, shut=shut)},
        wires=["x.output -> gate.input"], samples=64,
    )  # fmt: skip
    assert response(graph, "x.output", "gate.gated", frequencies=[10.0]).gain[0] == pytest.approx(1.0 - 1.0 / length)


@pytest.mark.defect(
    "S818", before="1, what passes in the first tick: later than 18 ticks nothing was compared", after="0"
)
@pytest.mark.parametrize("ticks", chosen([18, 40], [1, 17]))
def test_the_response_of_a_chopper_and_a_delay(ticks: int) -> None:
    """A sign that turns every three ticks leaves nothing of the input at its own frequency."""
    blocks = {"x": Constant(value=1.0), "sign": TurnedSign(half=3), "late": Delay(ticks=ticks)}
    wires = ["x.output -> sign.input", "sign.turned -> late.input"]
    graph = Graph(name="chopped", rate=RATE, blocks=blocks, wires=wires, samples=64)
    assert abs(response(graph, "x.output", "late.output", frequencies=[10.0]).gain[0]) < 1e-12
