"""Clock offsets: when blocks tick, what a loop with a late controller does, and what is refused."""

import cmath
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Decimator,
    Difference,
    FixedGain,
    FixedQuantiser,
    Gain,
    Integrator,
    MassSpringDamper,
    Sine,
    WhiteNoise,
)
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.studies.study_reader import read_variants
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.response.response import response
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.run.simulate import simulate

ENGINES = ("python", "compiled")


def interleaved() -> Graph:
    """Two converters of 10 kHz half a period apart, and one of 20 kHz, on a ringing sensor."""
    converter = AnalogToDigital(bits=16, reference=1.0)
    return Graph(
        name="interleaved",
        rate="20 kHz",
        rates={"even": "10 kHz", "odd": "10 kHz", "mean": "10 kHz"},
        offsets={"odd": "50 us", "mean": "50 us"},
        duration="20 ms",
        blocks={
            "push": Constant(value=1e-6, unit="N"),
            "sensor": MassSpringDamper(),
            "volts": Gain(gain=1e6, input_unit="m", output_unit="V"),
            "even": converter,
            "odd": converter,
            "all": converter,
            "mean": Decimator(ratio=4),
        },
        wires=[
            "push.output -> sensor.force",
            "sensor.displacement -> volts.input",
            "volts.output -> even.voltage",
            "volts.output -> odd.voltage",
            "volts.output -> all.voltage",
            "odd.number -> mean.input",
        ],
        probes=["even.code", "odd.code", "all.code", "mean.mean"],
        measures={"count": {"signal": "odd.number", "statistic": "mean", "from": "5 ms"}},
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_interleaved_converters_are_one_of_twice_the_rate(engine: str) -> None:
    result = simulate(interleaved(), engine=engine)
    even, odd, both = (result[f"{name}.code"] for name in ("even", "odd", "all"))
    assert (even.values == both.values[::2]).all()
    assert (odd.values == both.values[1::2]).all()
    assert len(odd.values) == 200
    assert odd.times[:2] == pytest.approx([50e-6, 150e-6], rel=1e-15)
    assert (odd.times == both.times[1::2]).all()
    assert result["mean.mean"].times[0] == odd.times[0]
    numbers = both.values[1::2]
    assert result["mean.mean"].values[1] == pytest.approx(np.mean(numbers[:4]) / 1.0, rel=1e-12)
    assert result.measures["count"].value == pytest.approx(np.mean(numbers[50:]), rel=1e-12)


def test_engines_agree_bit_by_bit() -> None:
    python, compiled = (simulate(interleaved(), engine=engine) for engine in ENGINES)
    assert python.digest == compiled.digest


def test_noise_keeps_its_deviates_and_sines_their_time() -> None:
    blocks = {"noise": WhiteNoise(), "sine": Sine(frequency=123.0)}
    early, late = (
        simulate(
            Graph(
                name="late",
                rate="1 kHz",
                offsets=offsets,
                samples=samples,
                seed=5,
                blocks=blocks,
                probes=["noise.output", "sine.output"],
            )
        )
        for offsets, samples in (({}, 50), ({"noise": "0.25 ms", "sine": "0.25 ms"}, 200))
    )
    assert (early["noise.output"].values == late["noise.output"].values).all()
    times = np.arange(50) * 1e-3 + 0.25e-3
    assert late["sine.output"].values == pytest.approx(np.sin(2.0 * math.pi * 123.0 * times), abs=1e-12)


def test_an_output_is_zero_before_its_first_tick() -> None:
    graph = Graph(
        name="held",
        rate="1 kHz",
        offsets={"late": "0.5 ms"},
        samples=6,
        blocks={"late": Constant(value=2.0), "reader": Gain()},
        wires=["late.output -> reader.input"],
        probes=["reader.output"],
    )
    assert simulate(graph)["reader.output"].values.tolist() == [0.0, 2.0, 2.0]


LATE, PERIOD, GAIN = 30e-6, 100e-6, 3000.0


def late_loop(offset: float = LATE, gain: float = GAIN) -> Graph:
    """An integrator 1 / s, sampled at 10 kHz, whose controller answers some time after the sample."""
    return Graph(
        name="late loop",
        rate="10 kHz",
        rates={"error": "10 kHz", "controller": "10 kHz"},
        offsets={"controller": offset},
        duration="3 ms",
        blocks={
            "wanted": Constant(value=1.0),
            "plant": Integrator(output_unit="1"),
            "error": Difference(),
            "controller": Gain(gain=gain),
        },
        wires=[
            "wanted.output -> error.first",
            "plant.output -> error.second",
            "error.output -> controller.input",
            "controller.output -> plant.input",
        ],
        probes=["error.output", "controller.output"],
        loops={"main": {"open_at": "controller.output"}},
    )


def by_hand(offset: float, gain: float, samples: int) -> list[float]:
    """The error: y[n+1] = y[n] + offset u[n-1] + (T - offset) u[n], u = gain (1 - y)."""
    y = held = 0.0
    errors = []
    for _ in range(samples):
        errors.append(1.0 - y)
        u = gain * errors[-1]
        y += offset * held + (PERIOD - offset) * u
        held = u
    return errors


@pytest.mark.parametrize("engine", ENGINES)
def test_a_late_controller_moves_the_plant_late(engine: str) -> None:
    result = simulate(late_loop(), engine=engine)
    expected = by_hand(LATE, GAIN, len(result["error.output"].values))
    assert result["error.output"].values == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert result["controller.output"].values == pytest.approx(GAIN * np.array(expected[:30]), rel=1e-12, abs=1e-11)
    assert result["controller.output"].times[0] == LATE


@pytest.mark.parametrize("offset", [0.0, 10e-6, LATE, 99e-6])
def test_margins_against_the_delayed_hold(offset: float) -> None:
    """L(z) = gain ((T - offset) z + offset) / (z (z - 1)): Franklin, Powell and Workman, 4.3.4."""

    def loop(angle: float) -> complex:
        z = cmath.exp(1j * angle)
        return GAIN * ((PERIOD - offset) * z + offset) / (z * (z - 1.0))

    crossover = optimize.brentq(lambda angle: abs(loop(angle)) - 1.0, 1e-3, math.pi)
    inside = offset > PERIOD / 4.0  # else the phase crossover is at half the rate
    turn = optimize.brentq(lambda angle: cmath.phase(-loop(angle)), 1e-3, math.pi - 1e-9) if inside else math.pi
    found = margins(late_loop(offset))
    assert found.phase_margin == pytest.approx(cmath.phase(-loop(crossover)), rel=1e-9)
    assert found.gain_margin == pytest.approx(1.0 / abs(loop(turn)), rel=1e-9)


def test_a_response_counts_the_time_between_two_clocks() -> None:
    """From the error to the answer, in the closed loop at its input: L / (1 + L) as seen 30 us later."""
    f = np.array([100.0, 700.0, 3000.0])
    found = response(late_loop(gain=2.0), "wanted.output", "controller.output", frequencies=f.tolist())
    z = np.exp(2j * math.pi * f * PERIOD)
    plant = 2.0 * ((PERIOD - LATE) * z + LATE) / (z * (z - 1.0))
    assert found.gain == pytest.approx(2.0 / (1.0 + plant) * np.exp(-2j * math.pi * f * LATE), rel=1e-9)


@pytest.mark.parametrize(
    ("block", "offset", "said"),
    [("controller", 100e-6, "too long"), ("plant", 10e-6, "no clock"), ("controller", "1/30000007 s", "meets no tick")],
)
def test_what_is_no_offset_is_refused_with_its_place(block: str, offset: object, said: str) -> None:
    graph = late_loop().changed(offsets={block: Fraction(str(offset).removesuffix(" s"))})
    problems = [problem for problem in check(graph) if not problem.note]
    assert [said in problem.message for problem in problems] == [True]
    assert problems[0].key == f"blocks.{block}.clock_offset"


def test_files_have_it_beside_the_rate_and_parts_add_theirs() -> None:
    text = """
name = "late"
rate = "1 kHz"
samples = 9
wires = ["part.output -> last.input"]
probes = ["last.output"]

[blocks.last]
kind = "Gain"
clock_offset = "0.25 ms"

[blocks.part]
clock_offset = "100 us"
exports = { output = "ramp.output" }
blocks.ramp = { kind = "Ramp", clock_offset = "400 us" }
"""
    graph = read_graph_text(text)
    assert dict(flatten(graph).offsets) == {"last": Fraction(1, 4000), "part.ramp": Fraction(1, 2000)}
    again = read_graph_text(write_graph(graph))
    assert again == graph
    assert flatten(again).offsets == flatten(graph).offsets
    assert simulate(graph)["last.output"].times[0] == 0.25e-3


def test_hardware_of_one_clock_refuses_it() -> None:
    blocks = {"zero": Constant(), "word": FixedQuantiser(), "gain": FixedGain()}
    graph = Graph(
        name="late word",
        rate="1 kHz",
        offsets={"gain": "0.5 ms"},
        samples=4,
        blocks=blocks,
        wires=["zero.output -> word.input", "word.output -> gain.input"],
        probes=["gain.output"],
    )
    with pytest.raises(ModelError, match="has a clock offset, and cannot become hardware"):
        compose(plan(graph))


FORMULA_OF_A_VALUE = """
name = "late"
rate = "10 kHz"
duration = "10 ms"
wires = ["tone.output -> early.voltage", "tone.output -> late.voltage"]
probes = ["early.number", "late.number"]
[values]
part = 0.25
[measures]
mean = { signal = "late.number", statistic = "mean" }
[blocks]
tone = { kind = "Sine", rate = "1 MHz", frequency = "130 Hz", unit = "V" }
early = { kind = "AnalogToDigital", bits = 24, reference = "2 V" }
late = { kind = "AnalogToDigital", clock_offset = "= part * 100 us", bits = 24, reference = "2 V" }
"""


def sampled(late: float) -> np.ndarray:
    """The tone at the ticks of the converter, in its codes."""
    t = np.arange(100) * 1e-4 + late
    return np.round(np.sin(2.0 * np.pi * 130.0 * np.floor(t * 1e6 + 1e-6) / 1e6) * 2.0**22)


@pytest.mark.parametrize("engine", ENGINES)
def test_an_offset_may_be_a_formula_of_a_value(engine: str) -> None:
    graph = read_graph_text(FORMULA_OF_A_VALUE)
    assert graph.offsets == {"late": Fraction(25, 10**6)}
    assert read_graph_text(write_graph(graph)).offsets == graph.offsets
    assert "= part * 100 us" in write_graph(graph)
    for changes, late in (
        ({}, 25e-6),
        ({"part": 0.5}, 50e-6),
        ({"late.clock_offset": "10 us"}, 10e-6),
        ({"part": 0.0}, 0.0),
        ({"late.clock_offset": "= 3 * part * 10 us"}, 7.5e-6),
    ):
        found = simulate(graph.with_parameters(changes), engine=engine)["late.number"].values
        assert found[:100] == pytest.approx(sampled(late), abs=1.0), changes


@pytest.mark.parametrize(
    ("offset", "words"),
    [
        ("= part * 2 V", "is V, not s"),
        ("= -part * 1 us", "must be at least zero"),
        ("= part * 1 s", "the clock offset is too long"),
    ],
)
def test_a_formula_that_is_no_offset_is_refused(offset: str, words: str) -> None:
    try:
        problems = check(read_graph_text(FORMULA_OF_A_VALUE.replace("= part * 100 us", offset)))
    except ModelError as error:
        problems = list(error.problems)
    assert [words in str(problem) for problem in problems] == [True]
    assert "late.clock_offset" in str(problems[0])


@pytest.mark.parametrize(
    ("key", "values", "offsets", "rates"),
    [
        ("late.clock_offset", ["0 us", "10 us"], [Fraction(0), Fraction(1, 10**5)], [None, None]),
        ("part", [0.1, 0.5], [Fraction(1, 10**5), Fraction(1, 20_000)], [None, None]),
        ("early.rate", ["5 kHz", "2 kHz"], [Fraction(25, 10**6)] * 2, [Fraction(5000), Fraction(2000)]),
    ],
)
def test_studies_sweep_offsets_and_rates(
    tmp_path: Path, key: str, values: list[object], offsets: list[Fraction], rates: list[Fraction | None]
) -> None:
    path = tmp_path / "late.toml"
    path.write_text(f'{FORMULA_OF_A_VALUE}[study]\nruns = 2\nsweep = {{ "{key}" = {values} }}\n', encoding="utf-8")
    studies = read_variants(path)
    assert len(studies) == 2
    graphs = [study.graph for study in studies.values()]
    assert [one.offsets.get("late", Fraction(0)) for one in graphs] == offsets
    assert [one.rates.get("early") for one in graphs] == rates
    for one in graphs:
        assert not [problem for problem in check(one) if not problem.note]
