"""Systems of python-control and SciPy as blocks: they do in a run what their own libraries say."""

from typing import Any

import control
import numpy as np
import pytest
from scipy import signal

from proofmass import Graph, ModelError, from_control, from_scipy, simulate
from proofmass.blocks import (
    DiscreteMatrixStateSpace,
    DiscreteStateSpace,
    Gain,
    MatrixStateSpace,
    StateSpace,
    Step,
    TransferFunction,
)
from proofmass.blocks.declaration.declare import Block

RATE, TICKS = 1000.0, 60
STEP_BEGINS = 5


def answered(block: Block, port: str = "output", entry: str = "input", unit: str = "1") -> Any:
    """The answer of a block to a step of 1 in tick 5."""
    step = Step(amplitude=1.0, unit=unit, start_time=STEP_BEGINS / RATE)
    graph = Graph(
        name="a step into a system",
        rate=RATE,
        samples=TICKS,
        blocks={"step": step, "system": block},
        wires=[f"step.output -> system.{entry}"],
        probes=[f"system.{port}"],
    )
    return simulate(graph, engine="python")[f"system.{port}"].values


def stepped(a: Any, b: Any, c: Any, d: Any) -> Any:
    """The same by the recursion of a discrete system, in plain NumPy."""
    x, rows = np.zeros(len(a)), []
    for tick in range(TICKS):
        u = 1.0 if tick >= STEP_BEGINS else 0.0
        rows.append(float(c @ x + d * u))
        x = a @ x + b * u
    return np.array(rows)


@pytest.mark.parametrize("order", [1, 3, 4])
def test_a_continuous_system_answers_as_python_control_says(order: int) -> None:
    rng = np.random.default_rng(order)
    poles = -rng.uniform(20.0, 400.0, order)
    system = control.ss(np.diag(poles) + np.triu(rng.normal(size=(order, order)), 1), rng.normal(size=(order, 1)),
                        rng.normal(size=(1, order)), [[0.3]])  # fmt: skip
    block = from_control(system)
    assert isinstance(block, StateSpace)
    times = np.arange(TICKS - STEP_BEGINS) / RATE
    _, expected = control.step_response(system, times)
    assert answered(block)[STEP_BEGINS:] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    fraction = from_control(control.tf(system))
    assert isinstance(fraction, TransferFunction)
    assert answered(fraction)[STEP_BEGINS:] == pytest.approx(expected, rel=1e-7, abs=1e-9)


def test_a_system_of_order_six_without_a_direct_part_is_a_matrix_block() -> None:
    numerator, denominator = signal.butter(6, 300.0, analog=True)
    block = from_control(control.ss(control.tf(numerator, denominator)))
    assert isinstance(block, MatrixStateSpace)
    times = np.arange(TICKS - STEP_BEGINS) / RATE
    _, expected = signal.step(signal.lti(numerator, denominator), T=times)
    assert answered(block, "one", "first")[STEP_BEGINS:] == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("way", [from_control, from_scipy])
def test_a_discrete_system_answers_as_its_recursion(way: Any) -> None:
    rng = np.random.default_rng(7)
    a, b, c = 0.3 * rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=3)
    parts = a, b[:, None], c[None, :], np.array([[0.7]])
    system = control.ss(*parts, 1.0 / RATE) if way is from_control else signal.dlti(*parts, dt=1.0 / RATE)
    block = way(system, rate="1 kHz")
    assert isinstance(block, DiscreteStateSpace)
    assert answered(block) == pytest.approx(stepped(a, b, c, 0.7), rel=1e-12, abs=1e-15)


def test_zeros_and_poles_of_scipy_become_a_fraction() -> None:
    system = signal.dlti([0.5], [0.9, 0.2], 2.0, dt=0.001)
    block = from_scipy(system, rate="1 kHz", input_unit="V", output_unit="V")
    _, (expected,) = signal.dstep(system, n=TICKS - STEP_BEGINS)
    answer = answered(block, unit="V")[STEP_BEGINS:]
    assert answer == pytest.approx(expected[:, 0], rel=1e-12, abs=1e-15)


def test_a_system_without_states_is_a_gain() -> None:
    assert from_control(control.tf([6.0], [4.0])) == Gain(gain=1.5)
    assert from_scipy(signal.lti([5.0], [2.0])) == Gain(gain=2.5)


@pytest.mark.parametrize(
    ("system", "rate", "message", "hint"),
    [
        (control.tf([1.0], [1.0, 0.5], 1e-3), None, "right at one rate only", 'rate="1 kHz"'),
        (control.tf([1.0], [1.0, 0.5], 1 / 48000), None, "right at one rate only", 'rate="48 kHz"'),
        (control.tf([1.0], [1.0, 0.5], 1e-3), "2 kHz", "not for 2 kHz", "sample the system anew"),
        (control.tf([1.0], [1.0, 0.5]), "2 kHz", "has no rate", "leave the rate out"),
        (control.tf([1.0, 0.0], [1.0]), None, "more zeros than poles", "add poles"),
        (control.tf([1.0], np.ones(6)), None, "of order 5", "as factors"),
        (control.ss(-np.eye(5), np.ones((5, 1)), np.ones((1, 5)), 1.0), None, "direct part", "Gain of D"),
        (control.tf([[[1.0], [1.0]]], [[[1.0, 1.0], [1.0, 2.0]]]), None, "several inputs or outputs", "control.ss"),
        ("1/(s+1)", None, "not a linear system", "linearise"),
    ],
)
def test_what_no_block_holds_is_refused_with_a_cure(system: Any, rate: Any, message: str, hint: str) -> None:
    with pytest.raises(ModelError) as caught:
        from_control(system, rate=rate)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert hint in problem.hint


def test_bare_coefficients_are_refused() -> None:
    for numbers in (signal.butter(2, 0.1), signal.butter(2, 0.1, output="sos")):
        with pytest.raises(ModelError, match="only numbers"):
            from_scipy(numbers)


def test_a_system_without_a_time_step_of_its_own_runs_at_any_rate() -> None:
    assert isinstance(from_control(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], True)), DiscreteStateSpace)


def test_a_direct_part_alone_is_a_gain() -> None:
    system = control.ss(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[2.5]])
    assert from_control(system, input_unit="m", output_unit="V") == Gain(gain=2.5, input_unit="m", output_unit="V")


def test_a_discrete_system_of_several_ports_keeps_its_matrices() -> None:
    a, b, c, d = [[0.5, 0.1], [0.0, 0.8]], [[1.0, 2.0], [3.0, 4.0]], [[5.0, 6.0], [7.0, 8.0]], [[0.0, 9.0], [1.0, 0.0]]
    system = control.ss(a, b, c, d, 1e-3)
    block = from_control(system, rate="1 kHz")
    assert isinstance(block, DiscreteMatrixStateSpace)
    assert (block.order, block.input_size, block.output_size) == (2, 2, 2)
    rows = [tuple(np.ravel(matrix)) for matrix in (a, b, c, d)]
    assert [block.transition, block.entry, block.readout, block.direct] == rows
    with pytest.raises(ModelError, match="several inputs or outputs, for which a block has no units") as caught:
        from_control(system, rate="1 kHz", input_unit="m")
    assert "leave the units out" in str(caught.value)
