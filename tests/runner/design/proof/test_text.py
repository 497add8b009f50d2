"""What people read of proofs, line by line, from results that were written by hand."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from proofmass.runner.design.proof.attempt import MarginProof
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.digital_inputs import DigitalInput
from proofmass.runner.design.proof.digital_proof import NO_OVERFLOW, ROUNDING, DigitalProof
from proofmass.runner.design.proof.least_found import LeastFound
from proofmass.runner.design.proof.prove import Proofs
from proofmass.runner.design.proof.search import Searched
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.design.worst.ranges import Range

MASS = Range("sensor.mass", "sensor.mass", "kg", 5e-8, 4.51234567e-8, 5.51234567e-8)
GAIN = Range("gain.gain", "gain.gain", "1", 2.0, 2.0, 2.0)
PROVED = Searched("proved", (), 1, 1.0)
OPEN = Searched("open", (), 1200, 0.12345, why="there was no time left")
LOST = Searched("open", (), 0, 0.0, why="no norm was found")
REFUTED = Searched("refuted", (), 3, 0.0)


def proof(kind: str, searched: Searched, limit: float = 0.0, loop: str = "main", at: str = "main", **more: Any) -> Any:
    facts = {name: more.pop(name) for name in ("counterexample", "shown", "least") if name in more}
    return MarginProof(Claim(loop, at, kind, limit, 1e-3, **more), searched, 2.25, **facts)


def text(*proofs: MarginProof, **more: Any) -> list[str]:
    facts = {"graph": None, "ranges": (MASS, GAIN), "interrupted": False, "left_out": {}}
    return proofs_text(Proofs(proofs=proofs, **{**facts, **more})).splitlines()  # type: ignore[arg-type]


WITH = "with sensor.mass from 45.1235 \N{MICRO SIGN}g to 55.1235 \N{MICRO SIGN}g"
SENSORS = f"for every sensor, at the start of the run, {WITH}"


def test_claims_about_loops_with_what_came_of_them() -> None:
    least = LeastFound(6.54321, {"sensor.mass": 5.5e-8, "gain.gain": 2.0})
    breaks = {"sensor.mass": 4.5e-8}
    lines = text(
        proof("stable", PROVED),
        proof("gain margin", PROVED, 6.0, least=least),
        proof("phase margin", OPEN, 45.0),
        proof("decay rate", LOST, 50.0, at="dac.code", continuous=True),
        proof("disk margin", REFUTED, 0.5, at="dac.code", continuous=True, shown="0.4", counterexample=breaks),
        interrupted=True,
        left_out={"slow": "it has no point of rest"},
        lost_workers=2,
    )
    continuous = "loop main, opened at dac.code, in continuous time: what discrete blocks give is held"
    assert lines == [
        "interrupted: what was proved until then",
        f"{SENSORS}, gain.gain = 2",
        "loop main",
        "stable                           proved  1 region, 2.2 s",
        "gain margin of at least 6 dB     proved  1 region, 2.2 s; 6.543 dB found",
        "phase margin of at least 45 deg  open    12.3 % of the tolerances proved, 1,200 regions, 2.2 s;"
        " there was no time left",
        continuous,
        "decay rate of at least 50 1/s  open     no norm was found",
        "disk margin of at least 0.5    refuted  0.4 at the sensor below",
        "not in it: slow, since it has no point of rest",
        "2 workers ended early; others did their part",
        "gain margin of 6.543 dB, of main: see it by",
        '  proofmass margins GRAPH --at "0 s" --loop main --set "sensor.mass=5.5e-08 kg" --set "gain.gain=2.0"',
        "not disk margin of at least 0.5, of main: see it by",
        '  proofmass margins GRAPH --at "0 s" --loop main --set "sensor.mass=4.5e-08 kg"',
    ]


def test_claims_about_outputs_at_rest() -> None:
    """Constant values of sources are told, not set; what has no finite worst is not shown."""
    bias = LeastFound(-0.00123456789, {"source.value": 0.5, "sensor.mass": 5e-8})
    quiet, nothing = LeastFound(2e-4, {"sensor.mass": 5e-8}), LeastFound(math.inf, {"a": 1.0})
    source = Range("source.value", "source.value", "V", 0.5, 0.25, 0.5)
    about: Any = {"unit_of_quantity": "V", "at_rest": True}
    lines = text(
        proof("bias", PROVED, -0.002, "", "out.output", least=bias, **about),
        proof("peak", REFUTED, 2.0, "in.output", "out.output", most=True, shown="2.5 V", **about),
        proof("noise", PROVED, 1e-3, "", "out.output", most=True, least=quiet, **about),
        proof("peak", PROVED, 3.0, "in.output", "out.output", most=True, least=nothing, **about),
        ranges=(MASS, source),
        constants=frozenset({"source.value"}),
        rates=(1e-9, 0.0),
        lost_workers=1,
    )
    assert lines[0] == (
        f"for every sensor, at rest, {WITH}, which changes by at most 1 \N{MICRO SIGN}g in a second,"
        " source.value from 250 mV to 500 mV"
    )
    assert lines[1] == "at out.output"
    assert lines[4] == "from in.output to out.output"
    assert lines[2:4] == [
        "bias of at least \N{MINUS SIGN}2 mV         proved  1 region, 2.2 s; \N{MINUS SIGN}1.2345679 mV found",
        "noise of at most 1 mV at rest  proved  1 region, 2.2 s; 200 \N{MICRO SIGN}V found",
    ]
    assert lines[5:7] == [
        "peak of at most 2 V at rest  refuted  2.5 V",
        "peak of at most 3 V at rest  proved   1 region, 2.2 s",
    ]
    assert lines[7:] == [
        "1 worker ended early; others did their part",
        "bias of \N{MINUS SIGN}1.2345679 mV, of out.output, where source.value = 0.5 V: see it by",
        '  proofmass run GRAPH --probe out.output --set "sensor.mass=5e-08 kg"',
        "noise of 200 \N{MICRO SIGN}V, of out.output: see it by",
        '  proofmass noise GRAPH --output out.output --set "sensor.mass=5e-08 kg"',
    ]
    shown = proof("peak", REFUTED, 2.0, "in.output", "out.output", counterexample={"sensor.mass": 5e-8}, **about)
    assert text(shown)[-1] == (
        '  proofmass response GRAPH in.output out.output --at settled --set "sensor.mass=5e-08 kg"'
    )


def test_where_sensors_are_and_that_nothing_varies() -> None:
    nothing = 'nothing varies: this is the sensor as it is; --tolerance "BLOCK.PARAMETER=5 %" lets a parameter vary'
    rest = proof("stable", PROVED, at_rest=True)
    both = "at the start of the run, or at rest where it is said"
    assert text(rest, ranges=())[0] == f"at rest; {nothing}"
    assert text(proof("bias", PROVED, 1.0), ranges=())[0] == f"at rest; {nothing}"
    assert text(rest, proof("stable", PROVED), ranges=())[0] == f"{both}; {nothing}"
    assert text(proof("stable", PROVED), ranges=())[0] == f"at the start of the run; {nothing}"
    assert text(ranges=()) == []


def test_claims_about_the_digital_part() -> None:
    given = DigitalInput(("adc", "code"), "sensor.voltage", -1.00000049, 2.5, "V", True, (-8, 7), (-8, 7), True)
    run: Any = SimpleNamespace(ticks=12, overflows={"filter.sum": 3, "gain.output": 1}, refused="")
    refused: Any = SimpleNamespace(ticks=2, overflows={}, refused="a number is too large")
    kept = DigitalProof(NO_OVERFLOW, "", 0.0, "", "proved", "it is so", inputs=(given,))
    close = DigitalProof(ROUNDING, "filter.output", 0.002, "V", "refuted", "no", inputs=(given,), run=run)
    alone = replace(close, inputs=(), status="open", limit=math.inf, output="", run=refused)
    assert text(digital=(kept, close, alone)) == [
        "digital part, with any sensor.voltage from \N{MINUS SIGN}1 V to 2.5 V",
        f"{NO_OVERFLOW}                                       proved   it is so",
        f"{ROUNDING} of at most 2 mV, of filter.output  refuted  no",
        "digital part, without inputs",
        f"{ROUNDING} without a bound  open  no",
        "overflow in tick 11 of filter.sum, gain.output: see it by",
        "  proofmass prove GRAPH ... --counterexample overflow.toml; proofmass run overflow.toml",
        "overflow in tick 1 of a number is too large: see it by",
        "  proofmass prove GRAPH ... --counterexample overflow.toml; proofmass run overflow.toml",
    ]


def test_proofs_as_data() -> None:
    graph: Any = SimpleNamespace(name="g")
    made = Proofs(graph, (GAIN,), (proof("stable", PROVED),), False, {})
    assert made.proved
    data = made.as_data()
    assert data["ranges"] == {"gain.gain": {"nominal": 2.0, "low": 2.0, "high": 2.0, "unit": "1"}}
    assert [key for key in data if key in ("rates", "lost_workers")] == []
    more = replace(made, rates=(0.5,), lost_workers=3, proofs=(proof("stable", OPEN),)).as_data()
    assert (more["rates"], more["lost_workers"], more["proved"]) == ([0.5], 3, False)
    assert not replace(made, digital=(DigitalProof(NO_OVERFLOW, "", 0.0, "", "open"),)).proved
    one = proof("peak", OPEN, math.inf, most=True, least=LeastFound(-math.inf, {})).as_data()
    assert (one["limit"], one["side"], one["least_found"]) == (None, "at most", {"margin": None, "at": {}})
    assert (one["part"], one["boxes"], one["seconds"]) == (0.12345, 1200, 2.25)
