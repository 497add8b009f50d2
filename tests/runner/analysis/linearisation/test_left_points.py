"""Noise and responses of graphs that move on from their start: a gain of 1 + 2 (1 - exp(-t / T)) warms up."""

import math
from dataclasses import replace

import pytest

from proofmass import Graph, linearise, margins, noise, response
from proofmass.blocks import (
    Constant,
    Difference,
    DiscreteTransferFunction,
    Gain,
    Integrator,
    LookUpTable,
    LowPass,
    Sine,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block

BEFORE, AFTER = "1.79 times too little, without a note", "1.79 times what the start has, with a note on the end"
PERIOD, DECAY = 1e-2, 0.9


def warming_up(constant: float) -> Graph:
    """Noise through an amplifier that warms up, and y' = 0.9 y + 0.1 u."""
    return Graph(
        name="warming up",
        rate="100 Hz",
        duration="10 s",
        blocks={
            "two": Constant(value=2.0),
            "heat": LowPass(corner_frequency=1.0 / (2.0 * math.pi * constant)),
            "one": Constant(value=1.0),
            "gain": Sum(),
            "hiss": WhiteNoise(density=1e-3),
            "amplifier": Gain(),
            "lag": DiscreteTransferFunction(numerator=(1.0 - DECAY, 0.0), denominator=(1.0, -DECAY)),
        },
        wires=[
            "two.output -> heat.input",
            "heat.output -> gain.first",
            "one.output -> gain.second",
            "gain.output -> amplifier.gain",
            "hiss.output -> amplifier.input",
            "amplifier.output -> lag.input",
        ],
    )


ANALOG_BEFORE = "a gain margin of 25.1, that at the start, without a note"


def analog_loop(drive: dict[str, Block], gain: str, rate: float, seconds: float) -> Graph:
    """An integrator and two low-passes of 20 Hz in continuous time, with a gain that moves."""
    return Graph(
        name="analog",
        rate=rate,
        duration=seconds,
        blocks={
            **drive,
            "level": Constant(value=0.1),
            "error": Difference(),
            "amplifier": Gain(),
            "plant": Integrator(gain=10.0, output_unit="1"),
            "first": LowPass(corner_frequency=20.0),
            "second": LowPass(corner_frequency=20.0),
        },
        wires=[
            *(f"{a} -> {b}" for a, b in WIRES_OF[gain]),
            f"{gain}.output -> amplifier.gain",
            "level.output -> error.first",
            "second.output -> error.second",
            "error.output -> amplifier.input",
            "amplifier.output -> plant.input",
            "plant.output -> first.input",
            "first.output -> second.input",
        ],
        loops={"main": {"open_at": "second.output"}},
    )


WIRES_OF = {
    "table": [("one.output", "time.input"), ("time.output", "table.input")],
    "sum": [("two.output", "heat.input"), ("heat.output", "sum.first"), ("one.output", "sum.second")],
}


def margin_of(gain: float) -> float:
    """Gain margin of 10 gain / (s (1 + s / w)^2), whose phase is -180 deg at w: 2 w / (10 gain)."""
    return 2.0 * 2.0 * math.pi * 20.0 / (10.0 * gain)


@pytest.mark.defect("S832", before=ANALOG_BEFORE, after="6.28, that at the end of the run")
def test_an_analog_loop_that_stands_on_a_plateau_is_that_at_its_end() -> None:
    """The gain is 1 for half a second, and 4 from a second on."""
    drive: dict[str, Block] = {
        "one": Constant(value=1.0),
        "time": Integrator(gain=1.0, output_unit="1"),
        "table": LookUpTable(breakpoints=(0.0, 0.5, 1.0, 3.0), values=(1.0, 1.0, 4.0, 4.0)),
    }
    found = margins(analog_loop(drive, "table", 1000.0, 2.0))
    assert found.gain_margin == pytest.approx(margin_of(4.0), rel=1e-9)
    assert found.system.map.told.startswith("the end of the run")


@pytest.mark.defect("S832", before=ANALOG_BEFORE, after="21.1, that at the end of the run")
def test_an_analog_loop_that_warms_up_slowly_is_that_at_its_end() -> None:
    """From tick to tick it changes by less than a millionth."""
    drive: dict[str, Block] = {
        "one": Constant(value=1.0),
        "two": Constant(value=2.0),
        "heat": LowPass(corner_frequency=1.0 / (2.0 * math.pi * 300.0)),
        "sum": Sum(),
    }
    found = margins(analog_loop(drive, "sum", 10_000.0, 30.0))
    gain = 1.0 + 2.0 * (1.0 - math.exp(-30.0 / 300.0))
    assert found.gain_margin == pytest.approx(margin_of(gain), rel=1e-4)


def gain_at_end(constant: float) -> float:
    return 1.0 + 2.0 * (1.0 - math.exp(-10.0 / constant))


@pytest.mark.defect("S825", before=BEFORE, after=AFTER)
@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("constant", [20.0, 100.0])
def test_noise_is_that_at_the_end_of_a_run_that_leaves_its_start(constant: float) -> None:
    budget = noise(warming_up(constant), "lag.output")
    alone = 1e-3 * math.sqrt(0.5 / PERIOD) * math.sqrt((1.0 - DECAY) / (1.0 + DECAY))
    assert budget.rms == pytest.approx(alone * gain_at_end(constant), rel=2e-3)
    assert "the end of the run, 10.01 s" in budget.notes[0]


@pytest.mark.defect("S825", before=BEFORE, after=AFTER)
@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("constant", [20.0, 100.0])
def test_a_response_is_that_at_the_end_of_a_run_that_leaves_its_start(constant: float) -> None:
    graph = warming_up(constant)
    answer = response(graph, "hiss.output", "lag.output")
    assert answer.at_rest == pytest.approx(gain_at_end(constant), rel=2e-3)
    assert "the end of the run, 10.01 s" in answer.notes[0]
    system = linearise(graph, ["hiss.output"], ["lag.output"])
    assert float(system.dcgain()) == pytest.approx(gain_at_end(constant), rel=2e-3)


@pytest.mark.defect("S825", before="1.6 times too little, without a note", after="the same, with a note")
def test_settled_says_that_the_run_moves_on() -> None:
    """Without a loop nothing need come to rest."""
    budget = noise(warming_up(20.0), "lag.output", at="settled")
    assert any("what holds at its end is another" in note for note in budget.notes)


def test_a_time_that_is_named_is_taken() -> None:
    answer = response(warming_up(20.0), "hiss.output", "lag.output", at="2.5 s")
    assert answer.at_rest == pytest.approx(1.0 + 2.0 * (1.0 - math.exp(-0.125)), rel=2e-3)


def test_what_hardly_moves_is_told_at_the_start() -> None:
    """Within 2 % at its end."""
    answer = response(warming_up(1e4), "hiss.output", "lag.output")
    assert answer.time == pytest.approx(PERIOD)
    assert answer.notes == ()


def test_an_orbit_of_two_ticks_is_not_left() -> None:
    """The gain is 2 and 0 in turn."""
    graph = warming_up(1.0)
    graph = replace(graph, blocks=graph.blocks | {"two": Sine(frequency=50.0, phase=math.pi / 2.0), "heat": Gain()})
    answer = response(graph, "hiss.output", "lag.output")
    assert answer.at_rest == pytest.approx(1.0)
    assert answer.time == pytest.approx(PERIOD)
    assert answer.notes == ("linearised over 20 ms, in which the orbit closes, not over the 10 ms of the schedule",)
