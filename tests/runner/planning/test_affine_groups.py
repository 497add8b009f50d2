"""Groups whose rates are linear but for a constant: held exactly, whatever their outputs are."""

import itertools
import math
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest

from proofmass import Block, Graph, Input, Study, fit, param, run_study, simulate, worst
from proofmass.blocks import (
    Constant,
    Difference,
    DuffingSpring,
    LoopFilter,
    LowPass,
    MassSpringDamper,
    PhaseMixer,
    Product,
    Ramp,
    Sine,
    Step,
    Sum,
    VoltageControlledOscillator,
)
from proofmass.runner.continuous.exact_hold import MANY_COLUMNS
from proofmass.runner.plan.rates import assemble
from proofmass.runner.plan.stages import Stages
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.engine_table import EngineName
from tests.by_hand.lanes_alone import assert_lanes_are_runs

ENGINES: list[EngineName] = ["python", "compiled"]


def alone(source: Block, vco: Any = None, drive: Block | None = None, every: int = 1, **integration: Any) -> Graph:
    """An oscillator and what controls it, and what may drive its frequency."""
    blocks = {"source": source, "vco": vco or VoltageControlledOscillator(frequency=54321.1, gain=999.0)}
    return Graph(
        name="alone",
        rate="10 kHz",
        blocks=blocks | ({"drive": drive} if drive else {}),
        wires=["source.output -> vco.control", *(["drive.output -> vco.frequency"] if drive else [])],
        probes=[{"signal": f"vco.{port}", "every": every} for port in ("sine", "phase")],
        integration=integration,
    )


def method(graph: Graph) -> str:
    (solver,) = plan(graph).solvers
    return solver.method


# -- closed forms ----------------------------------------------------------------------------------


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("ticks", [2_000, 184_100])
def test_a_million_turns_against_mpmath(ticks: int) -> None:
    graph = alone(Constant(value=0.1, unit="V"), every=100)
    found = simulate(graph, samples=ticks + 1)["vco.sine"].values
    with mpmath.workdps(40):
        turns = (mpmath.mpf(54321.1) + 999 * mpmath.mpf(0.1)) / 10_000
        expected = [float(mpmath.sin(2 * mpmath.pi * n * turns)) for n in range(0, ticks + 1, 100)]
    assert np.abs(found - expected).max() < 2.0 * math.pi * ticks * 6.0 * 2.0**-53


def test_a_ramp_between_ticks_is_integrated_exactly() -> None:
    graph = alone(Ramp(slope=40.0, unit="V"), sources="first_order_hold")
    assert method(graph) == "exact"
    t = np.arange(301) / 10e3
    phase = 2.0 * np.pi * (54321.1 * t + 999.0 * 40.0 * t * t / 2.0)
    assert simulate(graph, samples=301)["vco.phase"].values == pytest.approx(phase, rel=1e-13, abs=1e-11)


def test_a_held_sine_against_the_sum_of_its_values() -> None:
    graph = alone(Sine(amplitude=0.5, frequency=700.0, unit="V"))
    n, w = np.arange(301), 2.0 * np.pi * 700.0 / 10e3
    held = 0.5 * np.sin(0.5 * n * w) * np.sin(0.5 * (n - 1) * w) / np.sin(0.5 * w)  # of sines 0 to n - 1
    phase = 2.0 * np.pi * (54321.1 * n + 999.0 * held) / 10e3
    assert simulate(graph, samples=301)["vco.phase"].values == pytest.approx(phase, rel=1e-13, abs=1e-11)


def test_a_sine_that_is_looked_at_within_steps_is_stepped() -> None:
    """A function of the time is not linear: the integral keeps the accuracy."""
    graph = alone(Sine(amplitude=0.5, frequency=700.0, unit="V"), sources="continuous")
    assert method(graph) == "dormand_prince"
    t, w = np.arange(101) / 10e3, 2.0 * np.pi * 700.0
    phase = 2.0 * np.pi * (54321.1 * t + 999.0 * 0.5 * (1.0 - np.cos(w * t)) / w)
    assert simulate(graph, samples=101)["vco.phase"].values == pytest.approx(phase, rel=1e-9)


def fed_back(port: str, unit: str) -> Graph:
    """An oscillator whose own output controls it."""
    return Graph(
        name="fed back",
        rate="1 kHz",
        blocks={
            "goal": Constant(value=20.0, unit=unit),
            "apart": Difference(unit=unit),
            "vco": VoltageControlledOscillator(frequency=3.0, gain=5.0, control_unit=unit),
        },
        wires=["goal.output -> apart.first", f"vco.{port} -> apart.second", "apart.output -> vco.control"],
        probes=["vco.phase"],
    )


def test_a_phase_that_is_fed_back_is_an_exponential() -> None:
    graph = fed_back("phase", "rad")
    assert method(graph) == "exact"
    t = np.arange(301) / 1e3
    end, rate = 20.0 + 3.0 / 5.0, 2.0 * math.pi * 5.0
    assert simulate(graph, samples=301)["vco.phase"].values == pytest.approx(end * -np.expm1(-rate * t), rel=1e-12)


def test_a_sine_that_is_fed_back_makes_the_group_nonlinear() -> None:
    """It is x' = a - b sin x with a > b, whose tangent of x / 2 is known in closed form."""
    graph = fed_back("sine", "V")
    assert method(graph) == "dormand_prince"
    a, b = 2.0 * math.pi * (3.0 + 5.0 * 20.0), 2.0 * math.pi * 5.0
    root, t = math.sqrt(a * a - b * b), np.arange(9) / 1e3
    tangent = b / a + root / a * np.tan(0.5 * root * t + math.atan(-b / root))
    apart = 2.0 * np.arctan(tangent) - simulate(graph, samples=9)["vco.phase"].values
    assert np.abs(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi))).max() < 1e-8


def test_a_locked_loop_against_an_integration_of_its_own() -> None:
    """A sampled detector and filter by hand, and SciPy's integration between ticks."""
    from scipy.integrate import solve_ivp

    ticks, period, natural, gain = 60, 1e-5, 2.0 * math.pi * 300.0, 1000.0
    graph = Graph(
        name="locked",
        rate="100 kHz",
        blocks={
            "signal": Sine(frequency=20.3e3),
            "mixer": PhaseMixer(second_unit="V"),
            "loop": LoopFilter(natural_frequency=300.0, oscillator_gain=gain, output_unit="V"),
            "vco": VoltageControlledOscillator(frequency=20e3),
        },
        wires=[
            "signal.output -> mixer.first",
            "vco.cosine -> mixer.second",
            "mixer.phase -> loop.error",
            "loop.control -> vco.control",
        ],
        probes=["vco.phase"],
    )
    assert method(graph) == "exact"
    turns, integral, expected = 0.0, 0.0, [0.0]
    whole = 2.0 * math.pi * gain
    for n in range(ticks):
        error = 2.0 * math.sin(2.0 * math.pi * 20.3e3 * n * period) * math.cos(2.0 * math.pi * turns)
        integral += natural**2 / whole * period * error
        control = math.sqrt(2.0) * natural / whole * error + integral
        moved = solve_ivp(lambda _, x, u=control: [20e3 + gain * u], (0.0, period), [turns], rtol=1e-12, atol=1e-14)
        turns = float(moved.y[0, -1])
        expected.append(2.0 * math.pi * turns)
    found = simulate(graph, samples=ticks + 1, engine="python")["vco.phase"].values
    assert found == pytest.approx(expected, abs=1e-11)


# -- own blocks ------------------------------------------------------------------------------------


class Warm(NamedTuple):
    temperature: float


class Housing(Block):
    """Temperature that a constant, another parameter and an input move."""

    ambient: float = param("1", "Temperature outside.", default=0.0)
    power = Input("1", "Heating.", default=2.0)


@Housing.output("1")
def temperature(p: Housing, x: Warm) -> float:
    """The temperature."""
    return x.temperature


@Housing.output("1")
def square(p: Housing, x: Warm) -> float:
    """The square of it: an output that is not linear."""
    return x.temperature * x.temperature


@Housing.derivative(linear=True)
def warmed(p: Housing, x: Warm, power: float) -> Warm:
    return Warm(power - 3.0 * (x.temperature - p.ambient))


def test_an_own_block_with_a_constant_and_an_input_that_is_not_connected() -> None:
    """T' = 2 - 3 (T - 300)."""
    graph = Graph(name="own", rate="10 Hz", blocks={"own": Housing(ambient=300.0)}, probes=["own.square"])
    assert method(graph) == "exact"
    t, end = np.arange(50) / 10.0, 300.0 + 2.0 / 3.0
    found = simulate(graph, samples=50)["own.square"].values
    assert found == pytest.approx((end * np.expm1(-3.0 * t)) ** 2, rel=1e-12)


def test_a_square_that_feeds_another_rate_is_stepped() -> None:
    graph = Graph(
        name="two",
        rate="10 Hz",
        blocks={"first": Housing(ambient=1.0), "second": Housing()},
        wires=["first.square -> second.power"],
        probes=["second.temperature"],
    )
    assert method(graph) == "dormand_prince"


def test_a_small_gain_beside_a_large_constant_keeps_its_digits() -> None:
    """A slope from rates for an input of one would be off by 5e-8."""
    planned = plan(alone(Constant(unit="V"), vco=VoltageControlledOscillator(frequency=1e9, gain=1e-3)))
    (solver,) = planned.solvers
    stages = Stages(planned.blocks, planned.schedule, solver.group, planned.block_period)
    _, entry = assemble(stages, planned.constants, 1e-4, None, True)
    assert entry[0] == pytest.approx([1e-7, 1e5], rel=3e-16)


# -- numbers that change ---------------------------------------------------------------------------


@pytest.mark.defect(
    "S868",
    before="a constant, a cubic spring that a wire drives, and zero as set: taken for linear, and 0.0 for 3.0",
    after="a parameter that is driven is other than zero where a group is looked at",
)
@pytest.mark.parametrize("as_set", [0.0, 1.0])
def test_a_driven_constant_that_is_zero_as_set(as_set: float) -> None:
    graph = Graph(
        name="driven",
        rate="10 Hz",
        blocks={"drive": Constant(value=3.0), "off": Constant(value=0.0), "own": Housing(ambient=as_set)},
        wires=["drive.output -> own.ambient", "off.output -> own.power"],
        probes=["own.temperature"],
    )
    trace = simulate(graph, samples=50)["own.temperature"]
    assert trace.values == pytest.approx(-3.0 * np.expm1(-3.0 * trace.times), rel=1e-12)


def sprung(cubic: float, driven: bool = False) -> Graph:
    """A mass on a spring of third order that a force presses on."""
    return Graph(
        name="sprung",
        rate="10 kHz",
        samples=20,
        blocks={
            "force": Constant(value=1e-5, unit="N"),
            "total": Sum(unit="N"),
            "mass": MassSpringDamper(),
            "spring": DuffingSpring(cubic=cubic),
            **({"drive": Constant(value=1e14, unit="N/m^3")} if driven else {}),
        },
        wires=[
            "force.output -> total.first",
            "spring.force -> total.second",
            "total.output -> mass.force",
            "mass.displacement -> spring.displacement",
            *(["drive.output -> spring.cubic"] if driven else []),
        ],
        probes=["mass.displacement"],
        measures={"last": {"signal": "mass.displacement", "statistic": "last"}},
    )


@pytest.mark.defect("S868", before="the spring was taken for linear: 1e-19 m", after="it is stepped")
def test_a_driven_spring_that_is_zero_as_set() -> None:
    driven, still = simulate(sprung(0.0, driven=True)), simulate(sprung(1e14))
    assert driven["mass.displacement"].values == pytest.approx(still["mass.displacement"].values, rel=1e-9)


ABOUT_ZERO = pytest.mark.defect(
    "S869",
    before="a study, fit or search that moved a spring of third order away from zero took it for linear: 1e-19 m",
    after="methods hold for all that is varied: 1.9e-7 m",
)


@ABOUT_ZERO
@pytest.mark.parametrize("engine", ENGINES)
def test_a_study_about_zero(engine: EngineName) -> None:
    springs = [0.0, 1e14]
    found = run_study(Study(sprung(0.0), runs=1, seed=1, sweep={"spring.cubic": springs}), engine=engine)
    expected = [simulate(sprung(cubic), engine="python").measures["last"].value for cubic in springs]
    assert found["last"] == pytest.approx(expected, rel=1e-9)


@ABOUT_ZERO
@pytest.mark.exhaustive
def test_a_fit_from_zero() -> None:
    measured = simulate(sprung(3e13), engine="python")["mass.displacement"]
    data = {"time": measured.times, "place": measured.values}
    free = {"spring.cubic": {"at_least": 0.0, "at_most": "1e14 N/m^3"}}
    (found,) = fit(sprung(0.0), data, outputs={"mass.displacement": "place"}, free=free).estimates
    assert found.value == pytest.approx(3e13, rel=1e-6)


@ABOUT_ZERO
@pytest.mark.exhaustive
def test_the_worst_of_tolerances_about_zero() -> None:
    tolerances = {"spring.cubic": ["0 N/m^3", "1e14 N/m^3"]}
    lowest = worst(sprung(0.0), {"last": {"measure": "last"}}, tolerances=tolerances, samples=2).cases[0]
    assert lowest.worst == pytest.approx(simulate(sprung(1e14)).measures["last"].value, rel=1e-9)


# -- engines ---------------------------------------------------------------------------------------


def in_both(graph: Graph, samples: int) -> bool:
    python, compiled = (simulate(graph, samples=samples, engine=engine) for engine in ENGINES)
    return all(python[s].values.tobytes() == compiled[s].values.tobytes() for s in python)


def test_the_same_bits_with_ramps_and_driven_numbers() -> None:
    drive = Sine(amplitude=100.0, frequency=50.0, unit="Hz")
    driven = alone(Ramp(slope=40.0, unit="V"), drive=drive, sources="first_order_hold")
    (solver,) = plan(driven).solvers
    assert solver.affine
    assert in_both(driven, 90)


def test_the_same_bits_of_more_columns_than_are_written_out() -> None:
    filters = {f"filter_{i:02}": LowPass(corner_frequency=100.0 + i) for i in range(MANY_COLUMNS)}
    names = [*filters]
    graph = Graph(
        name="many",
        rate="1 kHz",
        blocks={"step": Step(), **filters, "vco": VoltageControlledOscillator(control_unit="1")},
        wires=[
            f"step.output -> {names[0]}.input",
            *(f"{one}.output -> {other}.input" for one, other in itertools.pairwise(names)),
            f"{names[-1]}.output -> vco.control",
        ],
        probes=["vco.sine"],
    )
    assert method(graph) == "exact"
    assert in_both(graph, 30)


def test_a_constant_beside_a_factor() -> None:
    """T' = w T - 3 (T - 300) for a held w: the column of the factor has the constant."""
    graph = Graph(
        name="factor",
        rate="10 Hz",
        blocks={"w": Sine(frequency=1.0), "times": Product(), "own": Housing(ambient=300.0)},
        wires=["w.output -> times.first", "own.temperature -> times.second", "times.output -> own.power"],
        probes=["own.temperature"],
    )
    (solver,) = plan(graph).solvers
    assert (solver.factors, solver.affine) == ((("w", "output"),), False)
    assert in_both(graph, 30)


def test_lanes_have_the_bits_of_each_run_alone() -> None:
    frequencies = [0.0, 20e3, 20.1e3, -7.0]
    graph = alone(Sine(amplitude=0.5, frequency=700.0, unit="V"), vco=VoltageControlledOscillator(frequency=0.0))
    planned = plan(graph.changed(probes=()), free=["vco.frequency"])
    given = {("vco", "frequency"): np.array(frequencies)}
    plans = [varied(planned, {"vco": VoltageControlledOscillator(frequency=f)}) for f in frequencies]
    assert_lanes_are_runs(planned, given, plans, "vco")
