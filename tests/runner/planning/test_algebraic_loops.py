"""Loops without delay solved by Newton's method: closed forms, brentq, numpy.linalg, matrix exponentials; same bits."""

import math
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from proofmass.blocks import Constant, Difference, Gain, Ramp, Saturation, Sine, Sum, TransferFunction
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunError, simulate

ENGINES: list[EngineName] = ["python", "compiled"]
NEWTON = {"algebraic_loops": "newton"}


class Shape(Block):
    """A test block: some function of the input."""

    input = Input("1", "Input.")


class Cosine(Shape):
    """Cosine."""


@Cosine.output("1")
def cosine(p: Any, input: float) -> float:
    """Cosine of the input."""
    return math.cos(input)


class Sign(Shape):
    """A jump."""


@Sign.output("1")
def sign(p: Any, input: float) -> float:
    """One with the sign of the input."""
    return 1.0 if input > 0.0 else -1.0


class Root(Shape):
    """Square root."""


@Root.output("1")
def root(p: Any, input: float) -> float:
    """The square root of the input."""
    return math.sqrt(input)


class Diode(Block):
    """Shockley's equation, which overflows above 18 V."""

    saturation_current: float = param("A", "Saturation current.", default=1e-12)

    voltage = Input("V", "Voltage.")


@Diode.output("A")
def current(p: Any, voltage: float) -> float:
    """Current."""
    return p.saturation_current * (math.exp(voltage / 0.025) - 1.0)  # type: ignore[no-any-return]


def graph_of(blocks: dict[str, Block], wires: list[str], probes: list[str], **more: Any) -> Graph:
    integration = {**NEWTON, **more.pop("integration", {})}
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=probes, integration=integration, **more)


def both(graph: Graph, samples: int) -> Result:
    """A result of the reference engine that the compiled loop has given too, bit for bit."""
    python, compiled = (simulate(graph, samples=samples, engine=engine) for engine in ENGINES)
    for signal in python:
        assert python[signal].values.tobytes() == compiled[signal].values.tobytes(), signal
    return python


def feedback(gain: float, source: Block, inner: Block | None = None) -> Graph:
    """y = source + gain y, or y = inner(source + gain y)."""
    blocks: dict[str, Block] = {"source": source, "sum": Sum(), "back": Gain(gain=gain)}
    wires = ["source.output -> sum.first", "back.output -> sum.second"]
    if inner is None:
        return graph_of(blocks, [*wires, "sum.output -> back.input"], ["sum.output"])
    port = next(iter(type(inner).outputs))
    wires += ["sum.output -> inner.input", f"inner.{port} -> back.input"]
    return graph_of({**blocks, "inner": inner}, wires, [f"inner.{port}"])


def sine_of(times: Any, amplitude: float = 1.0) -> Any:
    return amplitude * np.sin(2.0 * np.pi * 50.0 * times)


def test_a_linear_loop_is_the_closed_form() -> None:
    trace = both(feedback(-3.0, Sine(frequency="50 Hz")), 60)["sum.output"]
    np.testing.assert_allclose(trace.values, sine_of(trace.times) / 4.0, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("gain", [0.5, 0.999, -0.999, 1.001, -1.0, 7.0, -1e3, -1e9, 1e6])
def test_linear_loops_of_any_gain(gain: float) -> None:
    trace = simulate(feedback(gain, Ramp(slope=-3e3, offset=2.0)), samples=20, engine="python")["sum.output"]
    np.testing.assert_allclose(trace.values, (2.0 - 3e3 * trace.times) / (1.0 - gain), rtol=2e-15 * (1e3 + abs(gain)))


def test_the_cosine_of_itself() -> None:
    trace = both(feedback(0.5, Ramp(slope=100.0), Cosine()), 100)["inner.cosine"]
    expected = [brentq(lambda y, t=t: math.cos(100.0 * t + 0.5 * y) - y, -2, 2, xtol=1e-15) for t in trace.times]
    np.testing.assert_allclose(trace.values, expected, rtol=0, atol=3e-15)


def test_a_diode_and_a_resistor_at_voltages_where_whole_steps_overflow() -> None:
    blocks = {
        "source": Sine(frequency="50 Hz", amplitude=40.0, phase="90 deg", unit="V"),
        "across": Difference(unit="V"),
        "diode": Diode(),
        "resistor": Gain(gain=1e3, input_unit="A", output_unit="V"),
    }
    wires = ["source.output -> across.first", "across.output -> diode.voltage", "diode.current -> resistor.input"]
    graph = graph_of(blocks, [*wires, "resistor.output -> across.second"], ["across.output"])
    trace = both(graph, 60)["across.output"]

    def left(voltage: float, source: float) -> float:
        return source - 1e3 * 1e-12 * (math.exp(voltage / 0.025) - 1.0) - voltage

    sources = 40.0 * np.cos(2.0 * np.pi * 50.0 * trace.times)
    expected = [brentq(left, -41.0, 1.0, args=(source,), xtol=1e-15) for source in sources]
    np.testing.assert_allclose(trace.values, expected, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize("gain", [-2.0, -100.0, -1e5])
def test_a_saturated_amplifier_whose_iterations_without_damping_go_to_and_fro(gain: float) -> None:
    trace = both(feedback(gain, Sine(frequency="90 Hz", amplitude=3.0 * abs(gain)), Saturation()), 60)["inner.output"]
    sources = 3.0 * abs(gain) * np.sin(2.0 * np.pi * 90.0 * trace.times)
    np.testing.assert_allclose(trace.values, np.clip(sources / (1.0 - gain), -1.0, 1.0), rtol=1e-9, atol=1e-12)


def coupled(matrix: list[list[float]], diode: bool = False) -> Graph:
    """y_i = source_i + sum_j matrix_ij y_j."""
    blocks: dict[str, Block] = {}
    wires = []
    entries = ("first", "second", "third", "fourth")
    for i, row in enumerate(matrix):
        blocks |= {f"source_{i}": Ramp(slope=10.0 * (i + 1), offset=1.0 - i), f"a_{i}": Sum()}
        wires.append(f"source_{i}.output -> a_{i}.first")
        for j, gain in enumerate(row):
            blocks[f"gain_{i}_{j}"] = Gain(gain=gain)
            wires += [f"a_{j}.output -> gain_{i}_{j}.input", f"gain_{i}_{j}.output -> a_{i}.{entries[j + 1]}"]
    return graph_of(blocks, wires, [f"a_{i}.output" for i in range(len(matrix))])


@pytest.mark.parametrize("n", [2, 3])
def test_coupled_loops(n: int) -> None:
    matrix = np.random.default_rng(n).normal(size=(n, n)) * 2.0
    graph = coupled(matrix.tolist())
    (loop,) = plan(graph).schedule.loops
    assert loop.tears == tuple((f"a_{i}", "output") for i in range(n))
    result = both(graph, 10)
    found = np.array([result[f"a_{i}.output"].values for i in range(n)])
    times = result["a_0.output"].times
    sources = np.array([1.0 - i + 10.0 * (i + 1) * times for i in range(n)])
    np.testing.assert_allclose(found, np.linalg.solve(np.eye(n) - matrix, sources), rtol=1e-12)


def test_random_coupled_loops() -> None:
    draw = np.random.default_rng(0)
    for _ in range(25):
        n = int(draw.integers(1, 4))
        matrix = draw.normal(size=(n, n)) * 10.0 ** draw.integers(-2, 4)
        result = simulate(coupled(matrix.tolist()), samples=1, engine="python")
        expected = np.linalg.solve(np.eye(n) - matrix, [1.0 - i for i in range(n)])
        found = [result[f"a_{i}.output"].values[0] for i in range(n)]
        condition = np.linalg.cond(np.eye(n) - matrix)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * condition * np.abs(expected).max())


# -- inside continuous groups --------------------------------------------------------------------------------------

FILTER = TransferFunction(numerator=(0.5, 40.0, 9e4), denominator=(1.0, 100.0, 1e5))


def closed(gain: float) -> tuple[Any, Any]:
    """Numerator and denominator of H / (1 - gain H)."""
    numerator, denominator = np.array(FILTER.numerator), np.array(FILTER.denominator)
    return numerator, denominator - gain * numerator


def step_response(numerator: Any, denominator: Any, times: Any) -> Any:
    """Of b(s)/a(s) of order two, in controllable canonical form, by the matrix exponential."""
    b, a = numerator / denominator[0], denominator / denominator[0]
    matrix = np.array([[0.0, 1.0, 0.0], [-a[2], -a[1], 1.0], [0.0, 0.0, 0.0]])
    row = np.array([b[2] - b[0] * a[2], b[1] - b[0] * a[1], b[0]])
    return np.array([row @ (expm(matrix * t) @ [0.0, 0.0, 1.0]) for t in times])


@pytest.mark.exhaustive("runge_kutta_4-1e-08", "dormand_prince-1e-08", "radau-1e-08")
@pytest.mark.parametrize(
    ("method", "error"),
    [("auto", 1e-12), ("runge_kutta_4", 1e-8), ("dormand_prince", 1e-8), ("radau", 1e-8)],
)
def test_a_filter_in_a_loop_is_the_closed_loop_transfer_function(method: str, error: float) -> None:
    graph = replace(feedback(-3.0, Constant(value=1.0), FILTER), integration={**NEWTON, "method": method})
    solver = plan(graph).solvers[0]
    assert solver.exact == (method == "auto")
    assert len(solver.group.loops) == 1
    trace = both(graph, 40)["inner.output"]
    np.testing.assert_allclose(trace.values, step_response(*closed(-3.0), trace.times), rtol=0, atol=error)


@pytest.mark.parametrize("method", ["auto", "runge_kutta_4"])
def test_filters_in_loops_that_cross_are_the_loops_of_their_sum_and_difference(method: str) -> None:
    """y = s + M H y with M = [[a, b], [b, a]]: sum and difference of the signals do not see each other."""
    a, b, levels = -3.0, 1.25, (1.0, 0.25)
    blocks: dict[str, Block] = {}
    wires = []
    for here, level in enumerate(levels):
        blocks |= {f"source_{here}": Constant(value=level), f"sum_{here}": Sum(), f"filter_{here}": FILTER}
        blocks |= {f"own_{here}": Gain(gain=a), f"other_{here}": Gain(gain=b)}
        wires += [f"source_{here}.output -> sum_{here}.first", f"sum_{here}.output -> filter_{here}.input"]
        wires += [f"filter_{here}.output -> own_{here}.input", f"own_{here}.output -> sum_{here}.second"]
        wires += [f"filter_{1 - here}.output -> other_{here}.input", f"other_{here}.output -> sum_{here}.third"]
    probes = [f"filter_{here}.output" for here in range(2)]
    graph = graph_of(blocks, wires, probes, integration={**NEWTON, "method": method})
    (loop,) = plan(graph).solvers[0].group.loops
    assert len(loop.tears) == 2
    result = both(graph, 20)
    times = result["filter_0.output"].times
    of_sum, of_difference = (step_response(*closed(gain), times) for gain in (a + b, a - b))
    together, apart = (levels[0] + levels[1]) / 2.0 * of_sum, (levels[0] - levels[1]) / 2.0 * of_difference
    np.testing.assert_allclose(result["filter_0.output"].values, together + apart, rtol=1e-8)
    np.testing.assert_allclose(result["filter_1.output"].values, together - apart, rtol=1e-8)


def test_a_loop_gain_that_a_signal_moves_is_assembled_anew_in_every_tick() -> None:
    graph = feedback(-3.0, Constant(value=1.0), FILTER)
    graph = replace(
        graph,
        blocks={**graph.blocks, "drift": Ramp(slope=-100.0, offset=-3.0)},
        wires=[*graph.wires, "drift.output -> back.gain"],
    )
    (solver,) = plan(graph).solvers
    assert solver.exact
    assert solver.driven
    trace = both(graph, 30)["inner.output"]
    b = np.array(FILTER.numerator)
    a = np.array(FILTER.denominator)
    x, expected = np.zeros(2), []
    for tick in range(30):
        gain = -3.0 - 100.0 * tick * 1e-3
        direct = b[0] / (1.0 - gain * b[0])  # of the source on y, by hand: y = x_1 + b_0 u, u = 1 + gain y
        expected.append((x[0] + b[0]) / (1.0 - gain * b[0]))
        observable = np.array([[-a[1], 1.0], [-a[2], 0.0]])
        entry = np.array([b[1] - b[0] * a[1], b[2] - b[0] * a[2]])
        full = np.zeros((3, 3))
        full[:2, :2] = observable + np.outer(entry, [gain / (1.0 - gain * b[0]), 0.0])
        full[:2, 2] = entry * (1.0 + gain * direct)
        x = (expm(full * 1e-3) @ [*x, 1.0])[:2]
    np.testing.assert_allclose(trace.values, expected, rtol=1e-12)


@pytest.mark.exhaustive("radau")
@pytest.mark.parametrize("method", ["runge_kutta_4", "dormand_prince", "radau"])
def test_a_loop_that_saturates_inside_a_group(method: str) -> None:
    """x' = -200 x + 100 u, y = x + u / 2, u = 1 + limited(-3 y) in +-0.5."""
    inner = TransferFunction(numerator=(0.5, 200.0), denominator=(1.0, 200.0))
    base = feedback(-3.0, Constant(value=1.0), inner)
    graph = replace(
        base,
        blocks={**base.blocks, "limit": Saturation(lowest=-0.5, highest=0.5)},
        wires=[
            *(wire for wire in base.wires if str(wire) != "back.output -> sum.second"),
            "back.output -> limit.input",
            "limit.output -> sum.second",
        ],
        integration={**NEWTON, "method": method, "accuracy": 1e-10},
    )
    assert plan(graph).solvers[0].group.loops
    trace = simulate(graph, samples=20, engine="python")["inner.output"]

    def output(x: float) -> float:
        left = lambda y: x + 0.5 * (1.0 + min(max(-3.0 * y, -0.5), 0.5)) - y  # noqa: E731
        return float(brentq(left, -100.0, 100.0, xtol=1e-14))

    def rates(t: float, x: Any) -> Any:
        u = 2.0 * (output(x[0]) - x[0])
        return [-200.0 * x[0] + 100.0 * u]

    solution = solve_ivp(rates, (0.0, trace.times[-1]), [0.0], rtol=1e-10, atol=1e-12, t_eval=trace.times)
    np.testing.assert_allclose(trace.values, [output(x) for x in solution.y[0]], rtol=0, atol=1e-7)


def test_a_loop_through_a_block_with_a_rate_of_its_own_is_solved_at_ticks_alone() -> None:
    """What such a block gives is held over the tick, so that nothing is left to solve within it."""
    graph = feedback(-3.0, Constant(value=1.0), TransferFunction(numerator=(0.5, 200.0), denominator=(1.0, 200.0)))
    graph = replace(graph, rates={"back": "1 kHz"})
    planned = plan(graph)
    assert len(planned.schedule.loops) == 1
    assert planned.solvers[0].group.loops == ()
    trace = both(graph, 20)["inner.output"]
    x, expected, decay = 0.0, [], math.exp(-0.2)
    for _ in range(20):
        y = (x + 0.5) / (1.0 + 1.5)
        expected.append(y)
        x = decay * x + (1.0 - decay) * 0.5 * (1.0 - 3.0 * y)
    np.testing.assert_allclose(trace.values, expected, rtol=1e-12)


# -- loops without a solution ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
def test_a_loop_without_a_solution_ends_the_run_and_names_wire_and_tick(engine: EngineName) -> None:
    graph = feedback(1.0, Ramp(start_time=0.0205))
    with pytest.raises(RunError) as caught:
        simulate(graph, samples=100, engine=engine)
    assert (
        str(caught.value)
        == """\
back.output: failed in tick 21, t = 0.021 s
  got:      NoSolutionError: Newton's method finds no solution of the algebraic loop
  hint:     the loop may be unstable, or a parameter of the wrong size; probe what drives it: input = sum.output"""
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("inner", "port"), [(Sign(), "sign"), (Root(), "root")])
def test_jumps_and_roots_of_negative_numbers(inner: Block, port: str, engine: EngineName) -> None:
    graph = feedback(-1.0, Constant(value=0.25 if port == "sign" else -1.0), inner)
    with pytest.raises(RunError, match=r"back.output: failed in tick 0.*\n.*no solution"):
        simulate(graph, samples=3, engine=engine)


@pytest.mark.exhaustive("dormand_prince-python", "radau-python")
@pytest.mark.parametrize(
    ("method", "engine"),
    [("runge_kutta_4", "python"), ("dormand_prince", "python"), ("radau", "python"), ("runge_kutta_4", "compiled")],
)
def test_a_loop_that_loses_its_solution_within_a_tick(method: str, engine: EngineName) -> None:
    """r^2 = 1/4 - x + r/2 has a solution while x <= 5/16, with x = 40/s t: until 7.8 ms."""
    blocks = {"push": Constant(value=40.0), "x": TransferFunction(numerator=(1.0,), denominator=(1.0, 1e-9))}
    blocks |= {
        "less": Sum(),
        "root": Root(),
        "back": Gain(gain=0.5),
        "bias": Constant(value=0.25),
        "minus": Gain(gain=-1.0),
    }
    wires = [
        "push.output -> x.input",
        "x.strictly_proper_part -> minus.input",
        "minus.output -> less.first",
        "back.output -> less.second",
        "bias.output -> less.third",
        "less.output -> root.input",
        "root.root -> back.input",
        "root.root -> y.input",
    ]
    blocks["y"] = TransferFunction(numerator=(1.0,), denominator=(1.0, 1.0))
    graph = graph_of(blocks, wires, ["y.output"], integration={"method": method})
    with pytest.raises(RunError, match=r"back.output: failed in tick 7.*\n.*no solution"):
        simulate(graph, samples=30, engine=engine)


# -- order of declaration --------------------------------------------------------------------------------------------


@pytest.mark.exhaustive
def test_the_order_of_declaration_changes_no_bit() -> None:
    graph = coupled(np.random.default_rng(5).normal(size=(3, 3)).tolist())
    reference, draw = simulate(graph, samples=5, engine="python"), random.Random(0)
    for _ in range(10):
        blocks, wires = list(graph.blocks.items()), list(graph.wires)
        draw.shuffle(blocks)
        draw.shuffle(wires)
        other = simulate(replace(graph, blocks=dict(blocks), wires=wires), samples=5, engine="python")
        assert all(other[signal].values.tobytes() == reference[signal].values.tobytes() for signal in reference)
