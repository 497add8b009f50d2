"""Graphs whose algebraic loops Newton's method solves, linearised: closed forms, and the same graphs without a loop."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    Constant,
    DiscreteTransferFunction,
    Gain,
    Negation,
    Product,
    Sum,
    TransferFunction,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.linearise import linearise, node_of
from proofmass.runner.analysis.margins.sensitivity import Sensitivity, transfer_sensitivities
from proofmass.runner.planning.plan import plan
from tests.runner.planning.test_algebraic_loops import FILTER, NEWTON, Cosine, closed, coupled, feedback

BACK = -3.0


def direct(graph: Graph, source: str, target: str) -> Any:
    return linearise(graph, [source], [target]).D


@pytest.mark.parametrize("gain", [-1e3, -3.0, 0.5, 0.999, 7.0])
def test_a_linear_loop_is_its_closed_form(gain: float) -> None:
    found = direct(feedback(gain, Constant(value=1.0)), "source.output", "sum.output")
    assert found == pytest.approx(1.0 / (1.0 - gain), rel=1e-12)


def test_the_slope_of_an_implicit_function() -> None:
    """y = cos(s + y / 2): dy/ds = -sin / (1 + sin / 2)."""
    y = float(proofmass.simulate(feedback(0.5, Constant(value=0.7), Cosine()), samples=1)["inner.cosine"].values[0])
    sine = math.sin(0.7 + 0.5 * y)
    found = direct(feedback(0.5, Constant(value=0.7), Cosine()), "source.output", "inner.cosine")
    assert found == pytest.approx(-sine / (1.0 + 0.5 * sine), rel=1e-12)


def test_coupled_loops_are_a_matrix_inverse() -> None:
    matrix = np.random.default_rng(3).normal(size=(3, 3)) * 2.0
    names = range(3)
    system = linearise(
        coupled(matrix.tolist()), [f"source_{i}.output" for i in names], [f"a_{i}.output" for i in names]
    )
    assert pytest.approx(np.linalg.inv(np.eye(3) - matrix), rel=1e-10) == system.D


def test_derivatives_by_parameters_of_loops() -> None:
    """y = s / (1 - g): the scale factor's derivative by g is 1 / (1 - g)^2. y = s - y^2: mixed second derivatives."""
    scale, _ = _sensitivities(feedback(BACK, Constant(value=1.0)), "source.output", "sum.output")
    assert _slope(scale, "back.gain") == pytest.approx(1.0 / (1.0 - BACK) ** 2, rel=1e-12)
    square = Graph(
        name="square",
        rate="1 kHz",
        blocks={"source": Constant(value=2.0), "sum": Sum(), "square": Product(), "back": Gain(gain=-1.0)},
        wires=[
            "source.output -> sum.first",
            "sum.output -> square.first",
            "sum.output -> square.second",
            "square.output -> back.input",
            "back.output -> sum.second",
        ],
        integration=NEWTON,
    )
    scale, _ = _sensitivities(square, "source.output", "sum.output")
    root = math.sqrt(1.0 + 4.0 * 2.0)  # y = (-1 + sqrt(1 + 4 k s)) / (2 k) with k = -gain; dy/ds = 1 / sqrt(1 + 4 k s)
    assert scale.value == pytest.approx(1.0 / root, rel=1e-12)
    assert _slope(scale, "back.gain") == pytest.approx(2.0 * 2.0 / root**3, rel=1e-10)
    assert _slope(scale, "source.value") == pytest.approx(-2.0 / root**3, rel=1e-10)


def _sensitivities(graph: Graph, source: str, target: str) -> tuple[Sensitivity, Sensitivity]:
    planned = plan(graph)
    return transfer_sensitivities(linearised(planned), node_of(planned, source), node_of(planned, target))


def _slope(found: Sensitivity, parameter: str) -> float:
    return next(effect.derivative for effect in found.effects if effect.parameter == parameter)


def controlled(inner: dict[str, Block], wires: list[str], entry: str, out: str) -> Graph:
    """A digital loop of negative feedback around some blocks, with a sample of delay."""
    blocks: dict[str, Block] = {
        "minus": Negation(),
        "controller": DiscreteTransferFunction(numerator=(0.05, 0.0), denominator=(1.0, -1.0)),
        "delay": UnitDelay(),
    }
    wires = [
        *wires,
        f"{out} -> minus.input",
        "minus.output -> controller.input",
        "controller.output -> delay.input",
        f"delay.output -> {entry}",
    ]
    rates = {"minus": 1000}  # works at ticks, not within the continuous group
    return Graph(name="", rate="1 kHz", blocks={**blocks, **inner}, wires=wires, rates=rates, integration=NEWTON)


LOOP = ["sum.output -> inner.input", "back.output -> sum.second"]


@pytest.mark.parametrize("method", ["auto", "runge_kutta_4"])
def test_margins_through_a_loop_within_a_continuous_group(method: str) -> None:
    """The filter with its feedback is one transfer function, whose loop has the same margins and poles."""
    around: dict[str, Block] = {"sum": Sum(), "inner": FILTER, "back": Gain(gain=BACK)}
    looped = controlled(around, [*LOOP, "inner.output -> back.input"], "sum.first", "inner.output")
    looped = replace(looped, integration={**NEWTON, "method": method})
    numerator, denominator = closed(BACK)
    one: dict[str, Block] = {"plant": TransferFunction(numerator=(*numerator,), denominator=(*denominator,))}
    plain = controlled(one, [], "plant.input", "plant.output")
    assert plan(looped).schedule.loops
    assert not plan(plain).schedule.loops
    _same_margins(looped, plain)


def test_margins_through_a_loop_within_a_tick() -> None:
    around: dict[str, Block] = {"sum": Sum(), "inner": Gain(gain=4.0), "back": Gain(gain=BACK)}
    looped = controlled(around, [*LOOP, "inner.output -> back.input"], "sum.first", "inner.output")
    plain = controlled({"gain": Gain(gain=4.0 / 13.0)}, [], "gain.input", "gain.output")
    _same_margins(looped, plain)


def _same_margins(looped: Graph, plain: Graph) -> None:
    found, expected = (proofmass.margins(graph, "delay.output") for graph in (looped, plain))
    assert found.stable
    assert np.sort(np.abs(found.poles)) == pytest.approx(np.sort(np.abs(expected.poles)), abs=1e-12)
    for name in ("gain_margin", "phase_margin", "delay_margin", "sensitivity_peak", "bandwidth"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-9), name


@pytest.mark.exhaustive
def test_an_output_that_is_solved_with_others_cannot_be_moved() -> None:
    for signal in ("sum.output", "back.output"):
        with pytest.raises(ModelError, match="its value follows from the others"):
            linearise(feedback(BACK, Constant(value=1.0)), [signal], ["sum.output"])


def test_a_loop_without_a_solution_is_named() -> None:
    """y = s + y has none."""
    with pytest.raises(ModelError, match="cannot be linearised"):
        linearise(feedback(1.0, Constant(value=1.0)), ["source.output"], ["sum.output"])
