"""Proofs about loops in continuous time: closed forms, exact fractions, and runs that grow.

L = k / ((s + a) (s + b) (s + c)) is at its limit where k = (a + b) (b + c) (c + a) (Routh). L = k / s has no gain
margin, a phase margin of 90 deg, a delay margin of pi / (2 k), a disk margin of 2, since |(1 - L) / (1 + L)| = 1, and
decays by k.
"""

import math
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass import blocks
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.prove import Proofs, prove, prove_margin
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.run.simulate import simulate
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import check_certificate
from tests.by_hand.amounts import amounts, chosen
from tests.runner.design.proof.test_prove import status

INTEGRATOR = """
name = "k / s"
rate = "1 kHz"
samples = 400
wires = ["plant.output -> back.input", "back.output -> plant.input"]
probes = ["back.output"]
[loops.main]
open_at = "back.output"
[blocks.plant]
kind = "Integrator"
output_unit = "1"
gain = 3.0
[blocks.back]
kind = "Gain"
gain = -1.0
"""
GRAPH = read_graph_text(INTEGRATOR)
MOST, LEAST = 3.3, 2.7  # of k, within 10 %


def proofs(part: float, **more: Any) -> Proofs:
    """What comes of limits that are parts of the least there are."""
    limits: dict[str, Any] = {
        "phase_margin": f"{90.0 * part} deg", "disk_margin": f"{min(2.0 * part, 1.99)}",
        "delay_margin": f"{0.5 * math.pi / MOST * part} s", "decay_rate": f"{LEAST * part} 1/s",
    }  # fmt: skip
    return prove(GRAPH, tolerances={"plant.gain": "10 %"}, gain_margin="120 dB", **limits, **more)


@pytest.fixture(scope="module")
def integrating() -> Proofs:
    return proofs(0.9)


@pytest.mark.parametrize("part", amounts(0.9, 0.99))
def test_an_integrator_is_proved_up_to_its_closed_forms(part: float, integrating: Proofs) -> None:
    found = integrating if part == 0.9 else proofs(part)
    assert status(found) == ["proved"] * 6
    lines = check_certificate(certificate(found))
    assert lines[4].startswith(
        f"main, delay margin of at least {0.5 * math.pi / MOST * part:.6g} s in continuous time: "
    )
    assert "opened at back.output, in continuous time" in proofs_text(found)


@pytest.mark.exhaustive
def test_an_integrator_is_refuted_beyond_its_closed_forms() -> None:
    beyond = proofs(1.001)
    assert status(beyond) == ["proved", "proved", "refuted", "proved", "refuted", "refuted"]
    (decay,) = [one for one in beyond.proofs if one.claim.kind == "decay rate"]
    assert decay.value < decay.claim.limit


@pytest.mark.exhaustive
def test_a_search_goes_on_from_its_certificate(integrating: Proofs) -> None:
    known = known_proofs(certificate(integrating), graph_digest(GRAPH))
    again = proofs(0.9, known=known, seconds=0.0)
    assert status(again) == ["proved"] * 6
    assert check_certificate(certificate(again)) == check_certificate(certificate(integrating))


THREE = """
name = "three low passes"
rate = "1 kHz"
samples = 4000
wires = ["gain.output -> one.input", "one.output -> two.input", "two.output -> three.input",
         "three.output -> gain.input"]
probes = ["three.output"]
[loops.main]
open_at = "gain.output"
[blocks.gain]
kind = "Gain"
gain = -2.0
[blocks.one]
kind = "LowPass"
corner_frequency = "10 Hz"
[blocks.two]
kind = "LowPass"
corner_frequency = "10 Hz"
[blocks.three]
kind = "LowPass"
corner_frequency = "10 Hz"
"""
CORNERS = ["one.corner_frequency", "two.corner_frequency", "three.corner_frequency"]


def routh(k: float, a: float, b: float, c: float) -> float:
    """The gain margin of k a b c / ((s + a) (s + b) (s + c)), in dB."""
    return 20.0 * math.log10((a + b) * (b + c) * (c + a) / (k * a * b * c))


@pytest.mark.exhaustive
@pytest.mark.parametrize("corners", chosen([(10.0, 10.0, 10.0)], [(1.0, 10.0, 100.0)]))
def test_a_gain_margin_is_proved_up_to_that_of_routh(corners: tuple[float, float, float]) -> None:
    """Of two given corners it is least where the third is sqrt(b c), within the box if it is: 8 / k of equal ones."""
    first, *others = corners
    graph = read_graph_text(THREE).with_parameters(dict(zip(CORNERS, corners, strict=True)))
    ends = [0.9 * first, 1.1 * first]
    worst = min(routh(2.1, at, *others) for at in (*ends, min(max(math.sqrt(math.prod(others)), ends[0]), ends[1])))
    within = {CORNERS[0]: "10 %", "gain.gain": "5 %"}
    for off, expected in ((-0.5, "proved"), (0.02, "refuted")):
        found = prove(graph, tolerances=within, gain_margin=f"{worst + off} dB", phase_margin="1 deg", seconds=60.0)
        assert status(found)[:2] == ["proved", expected]
        assert len(check_certificate(certificate(found))) == status(found).count("proved")
    at = found.proofs[1].counterexample
    assert at is not None
    factor = 10.0 ** ((worst + 0.1) / 20.0)
    grown = graph.with_parameters(dict(at)).with_parameters({"gain.gain": at["gain.gain"] * factor})
    values = np.abs(simulate(_pushed(grown))["three.output"].values)
    assert values[-1000:].max() > 1.05 * values[1000:2000].max()


def _pushed(graph: Graph) -> Graph:
    """The loop with a step added at its wire."""
    wires = ["gain.output -> total.first", "push.output -> total.second", "total.output -> one.input"]
    wires += [f"{wire.source} -> {wire.target}" for wire in graph.wires if wire.target != "one.input"]
    own = {"push": blocks.Step(unit="1"), "total": blocks.Sum()}
    return Graph(
        name="pushed", rate="1 kHz", samples=4000, blocks={**graph.blocks, **own}, wires=wires, probes=["three.output"]
    )


# -- exact fractions ---------------------------------------------------------------------------------------------------

CHAIN = """
name = "chain"
rate = "1 kHz"
samples = 16
wires = ["i3.output -> i2.input", "i2.output -> i1.input", "i1.output -> p0.input", "i2.output -> p1.input",
         "i3.output -> p2.input", "p0.output -> some.first", "p1.output -> some.second", "some.output -> all.first",
         "p2.output -> all.second", "all.output -> minus.input", "minus.output -> i3.input"]
probes = ["minus.output"]
[loops.main]
open_at = "minus.output"
[blocks.minus]
kind = "Negation"
[blocks.some]
kind = "Sum"
[blocks.all]
kind = "Sum"
""" + "".join(
    f'[blocks.i{i}]\nkind = "Integrator"\noutput_unit = "1"\n[blocks.p{i - 1}]\nkind = "Gain"\n' for i in (1, 2, 3)
)  # s^3 + p2 s^2 + p1 s + p0, stable where all are positive and p2 p1 > p0
BORDERS = [
    Fraction(sign * mantissa, 10**digits) for digits in (1, 3, 6, 9, 12, 15) for sign in (-1, 1) for mantissa in (1, 3)
]
NEAR = (Fraction(3, 10), Fraction(-1, 1000), Fraction(-1, 10**9))


@pytest.mark.parametrize("off", chosen(NEAR, [one for one in BORDERS if one not in NEAR]), ids=str)
def test_a_box_that_ends_at_the_border_is_proved_where_all_of_it_is_stable(off: Fraction) -> None:
    """The poles of the worst corner lie as near to the axis as the border is: a part of 1e-15 to 0.3."""
    draw = random.Random(off.numerator)
    p1, p2 = draw.uniform(1.0, 9.0), draw.uniform(1.0, 9.0)
    least = float(Fraction(p1) * Fraction(9, 10)), float(Fraction(p2) * Fraction(9, 10))
    end = float(Fraction(least[0]) * Fraction(least[1]) * (1 - off))
    graph = read_graph_text(CHAIN).with_parameters({"p0.gain": 0.9 * end, "p1.gain": p1, "p2.gain": p2})
    within = {"p0.gain": [0.8 * end, end], "p1.gain": [least[0], 1.1 * p1], "p2.gain": [least[1], 1.1 * p2]}
    seconds = 40.0 if off <= Fraction(-1, 1000) or off >= Fraction(1, 10) else 3.0
    proof = prove_margin(graph, "main", "stable", 0.0, within, seconds=seconds)
    all_stable = Fraction(least[0]) * Fraction(least[1]) > Fraction(end)
    assert all_stable == (off > 0)
    if proof.status == "proved":
        assert all_stable
    if proof.status == "refuted":
        at = {name: Fraction(value) for name, value in (proof.counterexample or {}).items()}
        assert at["p2.gain"] * at["p1.gain"] <= at["p0.gain"]
    if off >= Fraction(1, 10):
        assert proof.status == "proved"
    if off <= Fraction(-1, 1000):
        assert proof.status == "refuted"


@pytest.mark.parametrize("off", chosen((-1e-9,), [0.05, 1e-9, 1e-3, -1e-3, 1e-12, -1e-12, 1e-15, -1e-15]))
def test_a_loop_of_second_order_is_stable_with_any_damping_above_zero(off: float) -> None:
    """s^2 + p2 s + p1: without the integrator of p0, stable where p2 > 0."""
    text = CHAIN.replace('"i2.output -> i1.input", "i1.output -> p0.input", ', '"i2.output -> p0.input", ')
    text = text.replace('[blocks.i1]\nkind = "Integrator"\noutput_unit = "1"\n', "")
    graph = read_graph_text(text).with_parameters({"p0.gain": 0.0, "p1.gain": 1.0, "p2.gain": 0.5})
    (proof, *_) = prove(graph, tolerances={"p2.gain": [off, 1.0], "p1.gain": "10 %"}, seconds=10.0).proofs
    assert proof.status != "refuted" if off > 0.0 else proof.status != "proved"
    if proof.status == "refuted":
        assert (proof.counterexample or {})["p2.gain"] <= 0.0
    if off == 0.05:
        assert proof.status == "proved"


# -- what changes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("more", chosen([{"any_change": True}], [{"slow_change": "10 %/s"}]), ids=" ".join)
def test_what_has_one_norm_may_change_at_any_time(more: dict[str, Any]) -> None:
    """x'' + 2 d x' + k x has one for all k from 1 - w to 1 + w where w < 2 d sqrt(1 - d^2), and for no more.

    It is that of the circle criterion: 1 / w is the largest of |1 / (s^2 + 2 d s + 1)| on the axis.
    """
    text = CHAIN.replace('"i2.output -> i1.input", "i1.output -> p0.input", ', '"i2.output -> p0.input", ')
    text = text.replace('[blocks.i1]\nkind = "Integrator"\noutput_unit = "1"\n', "")
    damping = 0.1
    widest = 2.0 * damping * math.sqrt(1.0 - damping**2)
    graph = read_graph_text(text).with_parameters({"p0.gain": 0.0, "p1.gain": 1.0, "p2.gain": 2.0 * damping})
    for part, expected in ((1.02, "open"), (0.98, "proved")):
        within = {"p1.gain": f"{100.0 * part * widest} %"}
        found = prove(graph, tolerances=within, gain_margin="0.01 dB", seconds=5.0, **more)
        assert found.proofs[0].status == expected
        assert expected == "proved" or "all of the tolerances at once" in found.proofs[0].searched.why
    (line, *_) = check_certificate(certificate(found))
    kind, end = ("slow", "by at most 0.1 a second") if "slow_change" in more else ("any", "")
    assert line.startswith(f"main, stable in continuous time under {kind} change: 1 box, ")
    assert line.endswith(end)


BENT = """
name = "a level that drains by its square"
rate = "1 kHz"
samples = 400
wires = ["push.output -> error.first", "square.value -> error.second", "error.output -> level.input",
         "level.output -> square.temperature"]
probes = ["level.output"]
[loops.main]
open_at = "error.output"
[blocks.push]
kind = "Step"
unit = "1"
amplitude = 2.0
[blocks.error]
kind = "Difference"
[blocks.level]
kind = "Integrator"
output_unit = "1"
gain = 100.0
[blocks.square]
kind = "PolynomialModel"
temperature_unit = "1"
unit = "1"
c1 = 1.0
c2 = 0.5
"""


@pytest.mark.exhaustive("refuted")
@pytest.mark.parametrize(("part", "expected"), [(0.99, "proved"), (1.01, "refuted")])
def test_a_loop_that_bends_has_its_rate_where_it_rests(part: float, expected: str) -> None:
    """x + c x^2 = p at rest, where it decays by g (1 + 2 c x) = g sqrt(1 + 4 c p), of the least g, c and p."""
    least = 95.0 * math.sqrt(1.0 + 4.0 * 0.475 * 1.9)
    found = prove(
        read_graph_text(BENT),
        tolerances={"level.gain": "5 %", "square.c2": "5 %", "push.amplitude": "5 %"},
        decay_rate=f"{part * least} 1/s",
    )
    assert status(found) == ["proved", "proved", "proved", expected]
    assert str(found.proofs[0].claim) == "stable at rest"
    assert check_certificate(certificate(found))[0].startswith("main, stable at rest in continuous time: ")


@pytest.mark.exhaustive
def test_a_loop_that_moves_on_is_that_of_the_start_where_it_is_asked_for() -> None:
    """A source that goes on leaves no point of rest; at the start the level is zero and decays by g."""
    text = BENT.replace(
        'kind = "Step"\nunit = "1"\namplitude', 'kind = "Sine"\nunit = "1"\nfrequency = "3 Hz"\namplitude'
    )
    graph = read_graph_text(text)
    found = prove(graph, decay_rate="99 1/s")
    assert status(found) == ["open"] * 4
    assert "changes after the start" in found.proofs[0].searched.why
    assert "--constant" in found.proofs[0].searched.why
    assert status(prove(graph, decay_rate="99 1/s", at="0 s")) == ["proved"] * 4
    assert status(prove(graph, decay_rate="101 1/s", at="0 s"))[3] == "refuted"


def test_a_wire_in_the_analog_part_of_a_sampled_loop_has_the_claims_of_its_margins() -> None:
    """The controller's output is held: what is left is 100 / s with a gain of one about it, opened there."""
    text = (
        BENT.replace("PolynomialModel", "Gain")
        .replace("square.value", "square.output")
        .replace(".temperature", ".input")
    )
    text = (
        text.split("temperature_unit")[0]
        .replace("push.output ->", "held.output ->")
        .replace("wires = [", 'wires = ["level.output -> adc.voltage", "adc.number -> held.input", ')
        .replace('[blocks.push]\nkind = "Step"\nunit = "1"\namplitude = 2.0\n', "")
    )
    text = text.replace('output_unit = "1"\ngain = 100.0', 'output_unit = "V"\ngain = 100.0')
    text += 'input_unit = "V"\n[blocks.adc]\nkind = "AnalogToDigital"\n[blocks.held]\nkind = "Gain"\ngain = -0.03\n'
    graph = read_graph_text(text)
    found = margins(graph, "square.output")
    assert "held" in " ".join(found.system.map.notes)
    limit = math.degrees(found.phase_margin or 0.0)
    for part, expected in ((0.99, "proved"), (1.01, "refuted")):
        proofs = prove(graph, "square.output", phase_margin=f"{part * limit} deg", gain_margin="40 dB")
        assert status(proofs) == ["proved", "proved", expected]
        assert proofs.proofs[0].claim.continuous
    alone = prove(graph, "adc.number", gain_margin="1 dB", phase_margin="1 deg")
    assert status(alone) == ["proved"] * 3
    assert not alone.proofs[0].claim.continuous
