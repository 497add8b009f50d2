"""Overflow and rounding of digital graphs: loops, delays, two rates, what is not affine, inputs, text and files."""

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, Probe
from proofmass.blocks import (
    Constant,
    FixedDelay,
    FixedDifference,
    FixedFiniteImpulseResponse,
    FixedGain,
    FixedIntegrator,
    FixedPID,
    FixedProduct,
    FixedQuantiser,
    FixedSum,
    FixedToNumber,
    PiecewiseConstant,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.runner.command_line import main
from proofmass.runner.design.proof.digital_proof import DigitalProof
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.run.simulate import simulate
from proofmass.runner.verification.certificates import certificate
from tests.by_hand.integer_sections import Section

WORD = Fixed(12, 4)


def after_quantiser(*wires: str, rates: Any = None, format: Fixed = WORD, **blocks: Any) -> Graph:
    """A graph of blocks behind a quantiser of the signal source.output."""
    return Graph(
        name="digital",
        rate=1000,
        blocks={"source": Constant(value=0.0), "quantiser": FixedQuantiser(output_format=format), **blocks},
        wires=["source.output -> quantiser.input", *wires],
        rates=rates or {},
    )


def about(graph: Graph, ends: Any = (-1.0, 1.0), **more: Any) -> Proofs:
    return prove(graph, input_ranges={"source.output": ends} if ends else {}, **more)


def overflow(graph: Graph, ends: Any = (-1.0, 1.0)) -> DigitalProof:
    return about(graph, ends, no_overflow=True).digital[0]


def rounding(graph: Graph, output: str, ends: Any = (-1.0, 1.0)) -> DigitalProof:
    return about(graph, ends, rounding={output: ""}).digital[0]


def delays(gain: float = 0.5, ticks: int = 3) -> Graph:
    """y[n] = u[n] + gain y[n - ticks], of which the product alone is rounded."""
    return after_quantiser(
        "quantiser.output -> sum.first",
        "gain.output -> sum.second",
        "sum.output -> delay.input",
        "delay.output -> gain.input",
        sum=FixedSum(input_format=WORD, output_format=WORD),
        delay=FixedDelay(format=WORD, ticks=ticks),
        gain=FixedGain(gain=gain, input_format=WORD, output_format=WORD),
    )


@pytest.mark.exhaustive("40")
@pytest.mark.parametrize("ticks", [1, 3, 40])
def test_a_loop_with_a_delay(ticks: int) -> None:
    """h[n] = g^(n / ticks) every so many ticks: the sum is 1 / (1 - |g|), whatever the delay."""
    graph = delays(0.75, ticks)
    assert rounding(graph, "sum.output").error == pytest.approx((-2.0 / 16.0, 2.0 / 16.0), rel=1e-6)
    found = overflow(graph, (-31.9, 31.9))
    assert found.status == "proved"
    fullest = next(room for room in found.rooms if room.at.startswith("sum"))
    assert fullest.high == pytest.approx(4.0 * 510.0 + 2.0, rel=1e-6)
    assert overflow(graph, (-32.1, 32.1)).status == "refuted"


def test_what_drops_nothing_has_no_error() -> None:
    graph = after_quantiser(
        "quantiser.output -> gain.input",
        "gain.output -> delay.input",
        gain=FixedGain(gain=2.0, input_format=WORD, output_format=Fixed(16, 4)),
        delay=FixedDelay(format=Fixed(16, 4), ticks=5),
    )
    found = rounding(graph, "delay.output")
    assert (found.status, found.limit, found.error) == ("proved", 0.0, (0.0, 0.0))
    assert about(graph, rounding={"delay.output": 0.0}).proved
    # a register that goes on for ever, though nothing is dropped on the way to it
    endless = after_quantiser(
        "quantiser.output -> filter.input",
        filter=Section(64, -64, 0, 6, 12).graph().blocks["filter"],
        format=Fixed(12, 0),
    )
    assert rounding(endless, "filter.output").error == (0.0, 0.0)


@pytest.mark.exhaustive
def test_a_loop_that_does_not_decay_is_open_or_refuted() -> None:
    growing = delays(-1.25)
    assert overflow(growing).status == "refuted"
    found = rounding(growing, "sum.output")
    assert (found.status, found.error) == ("open", None)
    assert "do not decay" in found.why
    integrating = after_quantiser("quantiser.output -> sum.input", sum=FixedIntegrator(input_format=WORD))
    assert overflow(integrating).status == "refuted"
    still = overflow(integrating, (0.0, 0.0))
    assert still.status == "proved"  # nothing moves


def test_an_integrator_beside_has_no_part_in_it() -> None:
    graph = after_quantiser(
        "quantiser.output -> gain.input",
        "quantiser.output -> sum.input",
        gain=FixedGain(gain=0.3, input_format=WORD, output_format=WORD),
        sum=FixedIntegrator(input_format=WORD),
    )
    found = rounding(graph, "gain.output")
    assert (found.status, found.limit) == ("proved", pytest.approx(0.5 / 16.0))


def loop(proportional: float) -> Graph:
    """A controller and an integrator that close a loop in fixed point, with a coarse output."""
    fine, coarse = Fixed(32, 28), Fixed(17, 12)
    return after_quantiser(
        "quantiser.output -> error.first",
        "integrator.output -> error.second",
        "error.output -> controller.error",
        "controller.output -> integrator.input",
        "integrator.output -> number.input",
        format=Fixed(16, 12),
        error=FixedDifference(output_format=coarse),
        controller=FixedPID(proportional=proportional, integral=0.0, derivative_gain=0.0, input_format=coarse),
        integrator=FixedIntegrator(gain="500 1/s", output_unit="1", sum_format=fine),
        number=FixedToNumber(),
    )


def test_a_loop_of_a_controller_and_an_integrator() -> None:
    graph = loop(1.5)
    found = about(graph, (-2.0, 2.0), no_overflow=True, rounding={"number.output": ""})
    assert [one.status for one in found.digital] == ["proved", "proved"]
    # steps of 2^-12 of the number and of the controller: the loop has a pole of 1/4
    assert 0.5 * 2.0**-12 <= found.digital[1].limit <= 4.0 * 2.0**-12
    rng = random.Random(3)
    values = tuple(rng.choice((-2.0, 2.0)) for _ in range(300))
    played = graph.changed(
        blocks={**graph.blocks, "source": PiecewiseConstant(times=tuple(0.001 * n for n in range(300)), values=values)},
        probes=(("number.output", 1, ""),),
    )
    played = Graph(
        name="played",
        rate=1000,
        blocks=dict(played.blocks),
        wires=[str(wire) for wire in graph.wires],
        probes=["number.output", "quantiser.output"],
    )
    run = simulate(played, samples=300)
    assert not any(run.overflows.values())
    exact, largest = 0.0, 0.0
    for given, number in zip(run["quantiser.output"].values, run["number.output"].values, strict=True):
        largest = max(largest, abs(number - exact))
        exact += 0.5 * 1.5 * (given - exact)
    assert 0.0 < largest <= found.digital[1].limit
    assert overflow(loop(1.5), (-8.0, 8.0)).status == "refuted"


def test_two_rates() -> None:
    """A slow accumulator of a fast signal, and a fast reader of a slow one: every value in the period counts."""
    graph = after_quantiser(
        "quantiser.output -> filter.input",
        "filter.output -> slow.input",
        "slow.output -> fast.input",
        format=Fixed(12, 0),
        rates={"slow": 250},
        filter=Section(64, -48, 0, 6, 14).graph().blocks["filter"],
        slow=FixedGain(gain=0.5, input_format=Fixed(14, 0), output_format=Fixed(14, 0), rounding="floor"),
        fast=FixedGain(gain=3.0, input_format=Fixed(14, 0), output_format=Fixed(16, 0)),
    )
    found = about(graph, (-100.0, 100.0), no_overflow=True, rounding={"fast.output": ""})
    assert [one.status for one in found.digital] == ["proved", "proved"]
    # 2 steps of the filter, halved, and a half of the floor, three times
    assert found.digital[1].error == pytest.approx((-3.0 * (1.0 + 0.5), 3.0 * 1.0), rel=1e-6)
    rooms = {room.at: room.high for room in found.digital[0].rooms}
    assert rooms["fast.output"] == pytest.approx(3.0 * 0.5 * (400.0 + 2.0), rel=1e-6)


def test_an_input_of_one_sign_and_a_start_that_counts() -> None:
    """The largest and the least over all times, those of the start with them."""
    graph = after_quantiser(
        "quantiser.output -> filter.input",
        format=Fixed(12, 0),
        filter=Section(64, -32, 0, 6, 12).graph().blocks["filter"],
    )
    (room,) = [room for room in overflow(graph, (10.0, 20.0)).rooms if room.at == "filter.output"]
    assert (room.low, room.high) == (pytest.approx(9.5), pytest.approx(41.0))
    started = after_quantiser(
        "quantiser.output -> difference.first",
        "integrator.output -> difference.second",
        "difference.output -> integrator.input",
        format=Fixed(8, 0),
        difference=FixedDifference(input_format=Fixed(8, 0), output_format=Fixed(9, 0)),
        integrator=FixedIntegrator(
            gain=500.0,
            initial=100.0,
            input_format=Fixed(9, 0),
            sum_format=Fixed(16, 4),
            output_format=Fixed(8, 0),
            output_unit="1",
        ),
    )
    found = overflow(started, (-10.0, 10.0))
    assert found.status == "proved"
    assert max(room.high for room in found.rooms if room.at == "integrator.output") == pytest.approx(100.5, abs=0.6)


def test_a_filter_without_feedback() -> None:
    """Sum of |c|, and an input that has their signs."""
    taps = (0.25, -0.5, 0.75, 0.875, -0.25)
    graph = after_quantiser(
        "quantiser.output -> filter.input",
        filter=FixedFiniteImpulseResponse(taps=taps, input_format=WORD, output_format=WORD),
    )
    assert overflow(graph, (-48.0, 48.0)).status == "proved"
    found = overflow(graph, (-49.5, 49.5))
    assert found.status == "refuted"
    assert found.run is not None
    (values,) = found.run.inputs.values()
    assert [abs(np.sign(value)) for value in values] == [1.0] * len(values)


def squared(width: int, gain: float = 0.5) -> Graph:
    """Return half of the square of an input, in a register of so many bits."""
    square, half = Fixed(width, 8), Fixed(24, 8)
    return after_quantiser(
        "quantiser.output -> square.first",
        "quantiser.output -> square.second",
        "square.output -> gain.input",
        square=FixedProduct(first_format=WORD, second_format=WORD, output_format=square),
        gain=FixedGain(gain=gain, input_format=square, output_format=half),
    )


def test_what_is_not_affine_is_open_with_the_reason() -> None:
    found = about(squared(20), no_overflow=True, rounding={"gain.output": ""})
    assert [one.status for one in found.digital] == ["open", "open"]
    assert all("square.output has no exact linear form: a product of two signals" in one.why for one in found.digital)


def test_what_cannot_overflow_by_its_formats_may_give_anything() -> None:
    found = overflow(squared(24))
    assert (found.status, [given.signal for given in found.inputs]) == ("proved", ["square.output"])
    (room,) = [room for room in found.rooms if room.at == "gain.output"]
    assert (room.low, room.high) == (pytest.approx(-(2.0**22), abs=1.0), pytest.approx(2.0**22, abs=1.0))
    assert overflow(squared(24), (-200.0, 200.0)).status == "refuted"  # which the quantiser does not hold
    assert overflow(squared(24, gain=1.5)).status == "open"  # which no square of 1 overflows
    assert rounding(squared(24), "gain.output").status == "open"


def test_a_rounding_error_is_open_where_something_may_overflow() -> None:
    found = rounding(delays(0.75), "sum.output", ends=(-60.0, 60.0))
    assert found.status == "open"
    assert "while nothing overflows, but delay.output gets from" in found.why
    assert about(delays(0.75), rounding={"sum.output": 0.1}).digital[0].why == "at most 0.1251 is proved"


def test_a_quantiser_that_overflows_by_itself() -> None:
    found = overflow(delays(0.5), (-1.0, 200.0))
    assert found.status == "refuted"
    assert found.run is not None
    assert set(found.run.overflows) >= {"quantiser"}


def test_a_run_that_refutes_keeps_all_ranges() -> None:
    """The sum of two inputs holds the range of one and what the graph has at the other, not both ranges at once."""
    graph = Graph(
        name="two inputs",
        rate=1000,
        blocks={
            "loud": Constant(value=1000.0),
            "one": Constant(value=0.0),
            "first": FixedQuantiser(output_format=Fixed(8, 0)),
            "second": FixedQuantiser(output_format=Fixed(12, 0)),
            "third": FixedQuantiser(output_format=Fixed(12, 0)),
            "widened": FixedGain(input_format=Fixed(8, 0), output_format=Fixed(12, 0)),
            "sum": FixedSum(input_format=Fixed(12, 0), output_format=Fixed(10, 0)),
        },
        wires=[
            "one.output -> first.input",
            "loud.output -> second.input",
            "one.output -> third.input",
            "first.output -> widened.input",
            "widened.output -> sum.first",
            "second.output -> sum.second",
            "third.output -> sum.third",
        ],
    )
    ranges = {"one.output": [-200.0, 200.0], "loud.output": [-1.0, 5.0]}
    found = prove(graph, no_overflow=True, input_ranges=ranges).digital[0]
    assert (found.status, found.run and found.run.overflows) == ("refuted", {"first": 1})
    assert found.run is not None
    again = simulate(found.run.graph.changed(probes=(Probe("second.output"), Probe("third.output"))))
    assert again["second.output"].values.tolist() == [0.0]
    assert again["third.output"].values.tolist() == [200.0]
    quieter = {"one.output": [-127.0, 127.0], "loud.output": [-1.0, 5.0]}
    assert prove(graph, no_overflow=True, input_ranges=quieter).digital[0].status == "proved"


def test_a_quantiser_that_refuses_is_refuted_with_what_the_run_says() -> None:
    graph = delays(0.75)
    blocks = {**graph.blocks, "sum": FixedSum(input_format=WORD, output_format=WORD, overflow="refuse")}
    found = overflow(graph.changed(blocks=blocks), (-60.0, 60.0))
    assert found.status == "refuted"
    assert found.run is not None
    assert found.run.refused


def test_without_a_range_an_input_is_all_that_its_format_holds() -> None:
    found = overflow(delays(0.25), None)
    assert found.status == "refuted"
    assert [(given.signal, given.low, given.high, given.stated) for given in found.inputs] == [
        ("quantiser.output", -128.0, 127.9375, False)
    ]


def test_a_signal_that_the_digital_part_feeds_back_refutes_nothing_unless_its_range_is_stated() -> None:
    graph = Graph(
        name="back",
        rate=1000,
        blocks={
            "quantiser": FixedQuantiser(output_format=Fixed(8, 4)),
            "sum": FixedSum(input_format=Fixed(8, 4), output_format=Fixed(8, 4)),
            "delay": FixedDelay(format=Fixed(8, 4)),
            "number": FixedToNumber(input_format=Fixed(8, 4)),
        },
        wires=[
            "number.output -> quantiser.input",
            "quantiser.output -> sum.first",
            "quantiser.output -> sum.second",
            "sum.output -> delay.input",
            "delay.output -> number.input",
        ],
    )
    assert prove(graph, no_overflow=True).digital[0].status == "open"
    assert prove(graph, no_overflow=True, input_ranges={"number.output": "-5..5"}).digital[0].status == "refuted"
    assert prove(graph, no_overflow=True, input_ranges={"quantiser.output": "-3..3"}).digital[0].status == "proved"


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"no_overflow": True, "input_ranges": {"source.output": "1"}}, "two limits"),
        ({"no_overflow": True, "input_ranges": {"source.output": "1.."}}, "two ends"),
        ({"no_overflow": True, "input_ranges": {"source.output": "2..1"}}, "no value lies"),
        ({"no_overflow": True, "input_ranges": {"source.output": "-1 V..1 V"}}, "V"),
        ({"no_overflow": True, "input_ranges": {"sum.output": "-1..1"}}, "does not enter the digital part"),
        ({"no_overflow": True, "input_ranges": {"quantiser.output": "0.01..0.02"}}, "no value of quantiser.output"),
        ({"no_overflow": True, "input_ranges": {"nothing.output": "-1..1"}}, "nothing"),
        ({"input_ranges": {"source.output": "-1..1"}}, "there is none"),
        ({"rounding": {"source.output": ""}}, "not an output of the digital part"),
        ({"rounding": {"sum.output": "-1"}}, "zero or above"),
        ({"rounding": {"sum.output": "1 V"}}, "V"),
    ],
)
def test_what_is_wrong_is_a_problem(more: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        prove(delays(), **more)


def test_a_graph_without_fixed_point_is_a_problem() -> None:
    with pytest.raises(ModelError, match="no block in fixed point"):
        prove("library:template", no_overflow=True)


def test_text_and_data_of_what_is_refuted_have_no_certificate() -> None:
    found = about(delays(0.75), (-60.0, 60.0), no_overflow=True, rounding={"sum.output": ""})
    assert not found.proofs
    text = proofs_text(found)
    assert "digital part, with any source.output from −60 to 60" in text
    data = json.loads(json.dumps(found.as_data()))
    assert data["digital"][0]["counterexample"]["overflows"]["sum"] == 1
    assert not data["proved"]
    written = json.loads(certificate(found))
    assert written["claims"] == written["digital"] == []


def test_the_command_writes_a_graph_that_overflows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "loop.toml").write_text(write_graph(delays(0.75)))
    command = ["prove", str(tmp_path / "loop.toml"), "--no-overflow", "--rounding", "sum.output=0.13", "--quiet"]
    assert main([*command, "--input-range", "source.output=-1..1"]) == 0
    target = tmp_path / "overflow.toml"
    assert main([*command, "--input-range", "source.output=-60..60", "--counterexample", str(target)]) == 1
    assert "refuted" in capsys.readouterr().out
    again = simulate(read_graph_text(target.read_text()))
    assert again.overflows["sum"] == 1
