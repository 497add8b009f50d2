"""Proofs at the point of rest, and of biases: closed forms, brute force over random points, what has no rest."""

import itertools
import json
import math
import random
from functools import cache
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.run.simulate import simulate
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.by_hand.amounts import amounts, chosen
from tests.by_hand.resting_loops import (
    PLATE,
    PULL_IN,
    QUADRATIC,
    SPRING,
    STIFFNESS,
    plate_rest,
    quadratic_loop,
    quadratic_rest,
    spring_rest,
)
from tests.runner.design.proof.test_prove import status

WITHIN = {"level.value": "10 %", "gain.gain": "10 %"}
LEAST, MOST = quadratic_rest(1.8), quadratic_rest(2.2)
LOOP = quadratic_loop()


def bias(limits: Any, graph: Graph = LOOP, output: str = "plant.output", **more: Any) -> Proofs:
    given: dict[str, Any] = {"tolerances": WITHIN} | more
    return prove(graph, bias={output: limits}, **given)


@cache
def near_its_ends() -> Proofs:
    return bias([0.999 * LEAST, 1.001 * MOST], gain_margin="17.5 dB", phase_margin="45 deg")


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return near_its_ends()


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_a_bias_is_proved_up_to_its_closed_form(proved: Proofs) -> None:
    assert status(proved) == ["proved"] * 5
    assert [str(one.claim)[:17] for one in proved.proofs[3:]] == ["bias of at least ", "bias of at most 1"]
    found = bias([1.001 * LEAST, 0.999 * MOST])
    assert status(found) == ["refuted", "refuted"]
    for proof, end in zip(found.proofs, (1.8, 2.2), strict=True):
        assert (proof.counterexample or {})["level.value"] == pytest.approx(end)
    assert [proof.value for proof in found.proofs] == pytest.approx([LEAST, MOST], rel=1e-12)


@pytest.mark.exhaustive
def test_bounds_of_a_bias_come_near_its_ends_and_do_not_pass_them() -> None:
    least, most = bias("").proofs
    assert (least.status, most.status) == ("proved", "proved")
    assert 0.995 * LEAST < least.claim.limit < LEAST
    assert MOST < most.claim.limit < 1.005 * MOST


@pytest.mark.parametrize(("off", "said"), [(-0.01, "proved"), (0.01, "refuted")])
def test_a_gain_margin_at_rest_is_that_of_the_slope_there(off: float, said: str) -> None:
    """The loop bears 2 / (g T (1 + x)): least at 110 /s and a level of 2.2."""
    limit = 20.0 * math.log10(2.0 / (0.11 * (1.0 + MOST))) + off
    found = prove(LOOP, tolerances=WITHIN, gain_margin=f"{limit} dB", phase_margin="30 deg")
    assert status(found) == ["proved", said, "proved"]
    assert all(proof.claim.at_rest for proof in found.proofs)


def test_the_start_is_another_point_of_which_there_is_no_proof() -> None:
    found = prove(LOOP, tolerances=WITHIN, at="0 s")
    assert set(status(found)) == {"open"}
    assert "changes after the start" in found.proofs[0].searched.why
    with pytest.raises(ModelError, match="start of a run or a point of rest"):
        prove(LOOP, at="20 ms")


@pytest.mark.exhaustive
def test_a_scale_factor_a_peak_and_a_decay_rate_at_rest() -> None:
    """dx/du = 1 / (1 + x), which is also the peak; the pole is 1 - g T (1 + x)."""
    factors = [0.99 / (1.0 + MOST), 1.01 / (1.0 + LEAST)]
    rate = -math.log(1.0 - 0.09 * (1.0 + LEAST)) / 1e-3
    found = prove(
        LOOP, "main", tolerances=WITHIN, input="level.output", scale_factor={"plant.output": factors},
        peak={"plant.output": factors[1]}, decay_rate=f"{0.999 * rate} 1/s", seconds=30.0, at="settled",
    )  # fmt: skip
    assert set(status(found)) == {"proved"}
    wrong = prove(
        LOOP, "main", tolerances=WITHIN, input="level.output",
        scale_factor={"plant.output": [1.001 / (1.0 + MOST), 0.999 / (1.0 + LEAST)]}, decay_rate=f"{1.001 * rate} 1/s",
        at="settled",
    )  # fmt: skip
    assert status(wrong)[3:] == ["refuted", "refuted", "refuted"]


@pytest.mark.parametrize("cubic", amounts(0.0, 0.05))
def test_a_continuous_part_that_is_not_linear_rests_where_its_forces_cancel(cubic: float) -> None:
    ends = [
        spring_rest(2e-5 * (1.0 - s * 0.05), 3e14 * (1.0 + s * cubic), STIFFNESS * (1.0 + s * 0.05))
        for s in (1.0, -1.0)
    ]
    within = {"push.value": "5 %", "mass.stiffness": "5 %"} | ({"spring.cubic": "5 %"} if cubic else {})
    graph = read_graph_text(SPRING)
    near = bias([0.97 * ends[0], 1.03 * ends[1]], graph, "pickoff.output", tolerances=within)
    assert status(near) == ["proved", "proved"]
    assert len(check_certificate(certificate(near))) == 2
    beyond = bias([1.001 * ends[0], 0.999 * ends[1]], graph, "pickoff.output", tolerances=within)
    assert status(beyond) == ["refuted", "refuted"]
    assert [proof.value for proof in beyond.proofs] == pytest.approx(ends, rel=1e-9)


@pytest.mark.exhaustive
def test_a_plate_has_a_bias_up_to_where_it_is_pulled_in() -> None:
    graph = read_graph_text(PLATE)
    for voltage, width in ((30.0, 0.02), (0.97 * PULL_IN, 0.005)):
        ends = [plate_rest(voltage * (1.0 + s * width), STIFFNESS) for s in (-1.0, 1.0)]
        found = bias(
            [0.999 * ends[0], 1.001 * ends[1]], graph.with_parameters({"plate.bias": voltage}), "mass.displacement",
            tolerances={"plate.bias": f"{100.0 * width} %"},
        )  # fmt: skip
        assert status(found) == ["proved", "proved"]
    graph = graph.with_parameters({"plate.bias": 0.98 * PULL_IN})
    for high in (1.001, 1.02):
        wide = {"plate.bias": [f"{part * PULL_IN} V" for part in (0.97, high)]}
        assert "proved" not in status(bias([-1.0, 1.0], graph, "mass.displacement", tolerances=wide, seconds=4.0))


@pytest.mark.exhaustive
def test_a_slower_controller_behind_a_spring_rests_where_both_do() -> None:
    """An integrator at a tenth of the rate takes the pickoff to a level: x = level / 1e6, whatever the spring."""
    wires = (
        '"servo.output -> total.first", "pickoff.output -> error.second", "level.output -> error.first",'
        ' "error.output -> servo.input"'
    )
    text = SPRING.replace('"push.output -> total.first"', wires)
    text = (
        text.replace('[blocks.push]\nkind = "Constant"\nunit = "N"\nvalue = 2e-5\n', "")
        + """
[blocks.level]
kind = "Constant"
unit = "V"
value = 0.2
[blocks.error]
kind = "Difference"
unit = "V"
[blocks.servo]
kind = "DiscreteIntegrator"
input_unit = "V"
output_unit = "N"
gain = 2e-2
rate = "10 kHz"
[loops.main]
open_at = "servo.output"
"""
    )
    graph, within = read_graph_text(text), {"level.value": "1 %"}
    assert status(prove(graph, tolerances=within, gain_margin="6 dB", phase_margin="30 deg")) == ["proved"] * 3
    found = bias([0.1981, 0.2019], graph, "pickoff.output", tolerances=within, seconds=4.0)
    assert status(found) == ["refuted", "refuted"]
    assert [proof.value for proof in found.proofs] == pytest.approx([0.198, 0.202], rel=1e-9)
    force = [STIFFNESS * x * 1e-6 + 3e14 * (x * 1e-6) ** 3 for x in (0.198, 0.202)]
    found = bias([1.001 * force[0], 0.999 * force[1]], graph, "servo.output", tolerances=within, seconds=4.0)
    assert [proof.value for proof in found.proofs] == pytest.approx(force, rel=1e-9)


# -- random loops ------------------------------------------------------------------------------------------------------


def _random_graph(draw: random.Random) -> tuple[Graph, dict[str, float], Any]:
    """A loop through a delay and a cubic curve, its parameters, and its rest by bisection in plain numbers."""
    ticks, linear, cubic = draw.randint(1, 4), draw.uniform(0.3, 1.5), draw.uniform(0.1, 0.5)
    values = {
        "level.value": draw.uniform(-2.0, 2.0), "gain.gain": draw.uniform(5.0, 90.0),
        "curve.c1": linear, "curve.c3": cubic, "curve.c0": draw.uniform(-0.5, 0.5),
    }  # fmt: skip
    text = QUADRATIC.replace(
        '"plant.output -> curve.temperature"', '"plant.output -> late.input", "late.output -> curve.temperature"'
    )
    text = text.replace("c1 = 1.0\nc2 = 0.5\n", "") + f'[blocks.late]\nkind = "Delay"\nticks = {ticks}\n'

    def rest(v: dict[str, float]) -> float:
        low, high = -100.0, 100.0
        for _ in range(200):
            x = 0.5 * (low + high)
            below = v["curve.c0"] + v["curve.c1"] * x + v["curve.c3"] * x**3 < v["level.value"]
            low, high = (x, high) if below else (low, x)
        return low

    def poles(v: dict[str, float]) -> float:
        """The largest pole of z^ticks (z - 1) + g T (c1 + 3 c3 x^2)."""
        import numpy as np

        slope = v["gain.gain"] * 1e-3 * (v["curve.c1"] + 3.0 * v["curve.c3"] * rest(v) ** 2)
        return float(max(abs(np.roots([1.0, -1.0, *[0.0] * (ticks - 1), slope]))))

    return read_graph_text(text).with_parameters(values), values, (rest, poles)


@pytest.mark.parametrize("seed", chosen((1,), (0, *range(2, 60))))
def test_no_proof_and_no_refutation_is_false(seed: int) -> None:
    """All corners and 200 random places of a box."""
    draw = random.Random(seed)
    graph, values, (rest, poles) = _random_graph(draw)
    names = draw.sample(sorted(values), draw.randint(1, 3))
    widths = {name: draw.uniform(0.01, 0.3) * max(abs(values[name]), 0.1) for name in names}
    places = [*itertools.product((-1.0, 1.0), repeat=len(names))]
    places += [tuple(draw.uniform(-1.0, 1.0) for _ in names) for _ in range(200)]
    sensors = [
        values | {n: values[n] + w * x for (n, w), x in zip(widths.items(), place, strict=True)} for place in places
    ]
    found = [rest(v) for v in sensors]
    room = max(max(found) - min(found), 1e-3)
    off = draw.choice((0.3, 0.1, 0.03, -0.05, -0.2))
    proofs = prove(
        graph, "main", tolerances={n: [str(values[n] - w), str(values[n] + w)] for n, w in widths.items()},
        bias={"plant.output": [min(found) - off * room, max(found) + off * room]}, seconds=12.0, at="settled",
    )  # fmt: skip
    stable, *_, least, most = proofs.proofs
    largest = max(map(poles, sensors))
    assert stable.status != "proved" or largest < 1.0 + 1e-12
    assert stable.status != "refuted" or poles(values | dict(stable.counterexample or {})) > 1.0 - 1e-6
    for proof in (least, most):
        limit, sign = proof.claim.limit, proof.claim.sign
        if proof.status == "proved":
            assert all(sign * (x - limit) > -1e-12 for x in found)
            assert largest < 1.0 + 1e-12
        if proof.status == "refuted":
            assert sign * (rest(values | dict(proof.counterexample or {})) - limit) < 1e-12
    if any(proof.status == "proved" for proof in proofs.proofs):
        assert check_certificate(certificate(proofs))


# -- several points of rest, converters, constants ---------------------------------------------------------------------


@pytest.mark.exhaustive
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_of_several_points_of_rest_it_is_that_of_the_run(side: float) -> None:
    """A spring of -k / 10 beside k (x/d)^2: two wells, at the ends of which a small force decides."""
    text = SPRING.replace("cubic = 3e14", f"cubic = 3e14\nlinear = {-1.2 * STIFFNESS}")
    graph = read_graph_text(text).with_parameters({"push.value": side * 1e-7})
    well = math.sqrt(0.2 * STIFFNESS / 3e14) * 1e6
    found = bias("", graph, "pickoff.output", tolerances={"spring.cubic": "3 %"}, seconds=20.0)
    assert status(found) == ["proved", "proved"]
    low, high = (proof.claim.limit for proof in found.proofs)
    assert low < high
    for end in (low, high):
        assert end * side == pytest.approx(well, rel=0.05)


def test_a_converter_is_ideal_in_the_proof_and_within_its_step_in_a_run() -> None:
    text = QUADRATIC.replace(
        '"gain.output -> plant.input"',
        '"gain.output -> adc.voltage", "adc.number -> scale.input", "scale.output -> plant.input"',
    )
    text += '[blocks.adc]\nkind = "AnalogToDigital"\nbits = 12\nreference = "400 V"\n[blocks.scale]\nkind = "Gain"\n'
    graph = read_graph_text(
        text.replace('[blocks.gain]\nkind = "Gain"', '[blocks.gain]\nkind = "Gain"\noutput_unit = "V"')
    )
    unit = 800.0 / 4096
    graph = graph.with_parameters({"scale.gain": unit})
    assert status(bias([0.999 * LEAST, 1.001 * MOST], graph)) == ["proved", "proved"]
    slope = 1.0 / (90.0 * (1.0 + LEAST))  # of the rest by what the converter is off
    for level in (1.8, 2.0, 2.2):
        last = float(simulate(graph.with_parameters({"level.value": level})).traces["plant.output"].values[-1])
        assert abs(last - quadratic_rest(level)) <= unit * slope


def test_a_constant_has_a_value_or_a_range() -> None:
    text = QUADRATIC.replace('kind = "Constant"\nvalue = 2.0', 'kind = "Sine"\nfrequency = "3 Hz"\noffset = 2.0')
    graph = read_graph_text(text)
    (least, _) = bias([1.0, 2.0], graph, tolerances={"gain.gain": "10 %"}).proofs
    assert least.status == "open"
    assert '--constant "level.output=2"' in least.searched.why
    for written, ends in (("2", (quadratic_rest(2.0),) * 2), ("1.8..2.2", (LEAST, MOST))):
        found = bias(
            [ends[0] - 1e-3, ends[1] + 1e-3],
            graph,
            tolerances={"gain.gain": "10 %"},
            constants={"level.output": written},
        )
        assert status(found) == ["proved", "proved"]
        near = bias([ends[0] + 1e-3, ends[1] - 1e-3] if written != "2" else [ends[0] + 1e-3, 9.0], graph,
                    tolerances={"gain.gain": "10 %"}, constants={"level.output": written})  # fmt: skip
        assert near.proofs[0].status == "refuted"
        assert "where level.value = " in proofs_text(near)
    assert "level.value from 1.8 to 2.2" in check_certificate(certificate(found))[0]
    zero = bias([-1e-6, 1e-6], graph, tolerances={"gain.gain": "10 %"}, input="level.output")
    assert status(zero) == ["proved", "proved"]


@pytest.mark.exhaustive
def test_a_step_that_may_come_later_has_no_rest() -> None:
    """The run has settled before the step of some sensors."""
    text = QUADRATIC.replace(
        'kind = "Constant"\nvalue = 2.0', 'kind = "Step"\noffset = 2.0\namplitude = 1.0\nstart_time = "0.01 s"'
    )
    graph = read_graph_text(text)
    later = quadratic_rest(3.0)
    assert status(bias([0.999 * later, 1.001 * later], graph, tolerances={"gain.gain": "10 %"})) == ["proved", "proved"]
    found = bias(
        [0.999 * later, 1.001 * later], graph, tolerances={"level.start_time": ["0.01 s", "1e4 s"]}, seconds=3.0
    )
    assert "proved" not in status(found)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('kind = "Constant"\nvalue = 2.0', 'kind = "RepeatingSequence"\nvalues = [2.0, 2.0]'), "no point of rest"),
        (('kind = "Constant"\nvalue = 2.0', 'kind = "Ramp"\nslope = "1 1/s"'), "sources change with time"),
        (("gain = 100.0", "gain = 1200.0"), "does not decay"),
    ],
    ids=["counts", "ramp", "unstable"],
)
def test_what_does_not_rest_says_why(change: tuple[str, str], words: str) -> None:
    (proof, _) = bias([0.0, 9.0], read_graph_text(QUADRATIC.replace(*change)), tolerances={"curve.c2": "1 %"}).proofs
    assert proof.status == "open"
    assert words in proof.searched.why


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"constants": {"gone.output": "1"}}, "gone"),
        ({"constants": {"level.output": "2 V"}}, "V is"),
        ({"constants": {"level.output": "3..2"}}, "no value lies between"),
        ({"constants": {"level.output": "nan"}}, "two ends|number|no value"),
        ({"constants": {"level.output": "2"}}, "that of a source that is a constant"),
        ({"limits": "3..2"}, "no value lies between"),
        ({"limits": "1 V..2 V"}, "V is"),
        ({"output": "plan.output"}, "did you mean plant"),
        ({"at": "soon"}, "at"),
    ],
    ids=str,
)
def test_wrong_words_are_answered(more: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"limits": [0.5, 2.0]} | more
    with pytest.raises(ModelError, match=words):
        bias(**given)


def test_parameters_that_change_have_no_point_of_rest() -> None:
    found = prove(LOOP, tolerances=WITHIN, any_change=True, bias={"plant.output": [0.5, 2.0]}, gain_margin="6 dB")
    assert set(status(found)) == {"open"}
    assert all("stay as they are" in proof.searched.why for proof in found.proofs)


@pytest.mark.exhaustive
def test_the_accelerometer_has_the_bias_of_its_closed_form() -> None:
    """At rest the torque of the code balances that of the acceleration: code = -m a 2^20 R / (2 V k)."""
    found = prove(
        read_graph("library:closed_loop_accelerometer"),
        tolerances={"torquer.gain": "5 %", "pendulosity.gain": "2 %"},
        constants={"acceleration.output": "-1..1 m/s^2", "reference.output": "2.5 V"},
        bias={"dac.code": ""},
    )
    end = 8.0e-6 * 1.02 * 2.0**20 * 342.0 / (2.0 * 2.5 * 0.065 * 0.95)
    for proof in found.proofs:
        assert proof.status == "proved"
        assert proof.least is not None
        assert abs(proof.least.margin) == pytest.approx(end, rel=1e-9)
        assert end < abs(proof.claim.limit) < 1.02 * end
    assert len(check_certificate(certificate(found))) == 2
    assert json.loads(json.dumps(found.as_data(), allow_nan=False))["constants"] == [
        "acceleration.value",
        "reference.value",
    ]
