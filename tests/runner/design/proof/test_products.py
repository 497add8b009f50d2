"""Parameters that act on a loop as one product: proofs up to closed forms, sensors within, and those that do not.

An integrator of gain g T is stable for 0 < g T < 2: its gain margin is 2 / (g T), with g the product of all gains.
"""

import json
import math
import random
from fractions import Fraction
from typing import Any

import pytest

from proofmass import blocks, margins, prove, read_graph
from proofmass.blocks.arithmetic.elementary import exponential
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.derivatives.ball import enclosing
from proofmass.runner.design.proof.coordinates import ProductRange, coordinates_of
from proofmass.runner.design.proof.products import degree_in
from proofmass.runner.design.proof.prove import Proofs, prove_margin
from proofmass.runner.design.proof.wanted import about_margin
from proofmass.runner.design.worst.box import box_of
from proofmass.runner.planning.plan import plan
from proofmass.runner.verification.box_checker import named_side
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate, digest_of
from tests.by_hand.amounts import chosen
from tests.runner.design.proof.test_continuous_loops import INTEGRATOR
from tests.runner.design.proof.test_prove import INTEGRATING, status

TOLERANCES = {"gain.gain": "30 %", "plant.gain": [0.8, 1.5], "hold.gain": "20 %"}
MOST = 100.0 * 1.3 * 1.5 * 1.2 * 1e-3  # of g T
LIMIT = 20.0 * math.log10(2.0 / MOST)


def product(found: Proofs) -> ProductRange:
    """The product among the coordinates of the last claim."""
    known = found.proofs[-1].coordinates
    assert known is not None
    (only,) = [one for one in known.ranges if isinstance(one, ProductRange)]
    return only


@pytest.fixture(scope="module")
def proved() -> Proofs:
    graph = read_graph_text(INTEGRATING)
    return prove(graph, tolerances=TOLERANCES, gain_margin=f"{LIMIT - 1e-3} dB", phase_margin="20 deg")


def test_gains_in_a_row_are_proved_up_to_the_closed_form(proved: Proofs) -> None:
    assert status(proved) == ["proved"] * 3
    gain = product(proved)
    assert sorted(zip((one.written for one in gain.factors), gain.powers, strict=True)) == [
        ("gain.gain", 1.0),
        ("hold.gain", 1.0),
        ("plant.gain", 1.0),
    ]
    assert gain.low / gain.nominal == pytest.approx(0.7 * 0.8 * 0.8, rel=1e-11)
    assert gain.low / gain.nominal < 0.7 * 0.8 * 0.8
    assert gain.high / gain.nominal == pytest.approx(1.3 * 1.5 * 1.2, rel=1e-11)
    assert gain.high / gain.nominal > 1.3 * 1.5 * 1.2
    assert [one.written for one in proved.ranges] == sorted(TOLERANCES)


def test_gains_in_a_row_are_refuted_beyond_the_closed_form_by_a_sensor_within() -> None:
    found = prove(read_graph_text(INTEGRATING), tolerances=TOLERANCES, gain_margin=f"{LIMIT + 1e-3} dB")
    assert status(found)[:2] == ["proved", "refuted"]
    sensor = found.proofs[1].counterexample
    assert sensor is not None
    for one in found.ranges:
        assert one.low <= sensor[one.written] <= one.high
    assert 20.0 * math.log10(2.0 / (math.prod(sensor.values()) * 1e-3)) < LIMIT + 1e-3


def test_a_sensor_of_a_product_has_it_and_lies_within(proved: Proofs) -> None:
    gain = product(proved)
    for part in (0.0, 0.2, 0.5, 0.9, 1.0):
        value = gain.low + part * (gain.high - gain.low)
        sensor = gain.named(value)
        assert math.prod(sensor.values()) == pytest.approx(value * 1.0 * 1.0, rel=1e-11)
        assert all(one.low <= sensor[one.written] <= one.high for one in gain.factors)


FORGERIES = [
    ("gain.gain", "high", 131.0),
    ("gain.gain", "low", 69.0),
    ("gain.gain", "low", -1.0),
    ("gain.gain", "nominal", 50.0),
    ("plant.gain", "high", 1.6),
    ("plant.gain", "power", -1.0),
    ("hold.gain", "power", 1.5),
]


def forged(text: str, name: str, key: str, value: float) -> str:
    """A certificate with another number for a factor, and a hash of its own."""
    data = json.loads(text)
    del data["sha256"]
    for claim in data["claims"]:
        (factor,) = [one for side in claim["coordinates"] for one in side["product"] if one["name"] == name]
        factor[key] = value
    return json.dumps({**data, "sha256": digest_of(data)})


def test_the_checker_names_the_factors_of_a_product(proved: Proofs) -> None:
    lines = check_certificate(certificate(proved))
    assert all("gain.gain from 70 to 130, hold.gain from 0.8 to 1.2, plant.gain from 0.8 to 1.5" in x for x in lines)
    check_certificate(forged(certificate(proved), "gain.gain", "high", 130.0))


@pytest.mark.parametrize("change", FORGERIES)
def test_a_certificate_of_more_than_was_proved_of_a_product_is_refused(
    proved: Proofs, change: tuple[str, str, float]
) -> None:
    with pytest.raises(FalseCertificateError, match=r"a product does not stand for its parameters|cannot be read"):
        check_certificate(forged(certificate(proved), *change))


@pytest.mark.parametrize(("low", "high", "whole"), [(0.499, 2.001, True), (0.501, 2.001, False), (0.499, 1.999, False)])
def test_a_coordinate_may_be_one_divided_by_a_product(low: float, high: float, whole: bool) -> None:
    """2 a / b with a from 0.5 to 1, nominally 1, and b from 4 to 8, nominally 4: from 0.5 to 2."""
    factors = [
        {"name": "a", "low": 0.5, "high": 1.0, "nominal": 1.0, "power": 1.0},
        {"name": "b", "low": 4.0, "high": 8.0, "nominal": 4.0, "power": -1.0},
    ]
    side = {"name": "a", "inverse": False, "low": low, "high": high, "nominal": 2.0, "product": factors}
    assert named_side(side) == ("a from 0.5 to 1, b from 4 to 8", whole)
    inverse = {**side, "inverse": True, "low": 1.0 / high, "high": 1.0 / low}
    assert named_side(inverse)[1] is whole


@pytest.mark.parametrize("key", ["any_change", "at_rest"])
def test_a_product_of_parameters_that_move_is_refused(proved: Proofs, key: str) -> None:
    """From period to period the units of the states would have to change."""
    data = json.loads(certificate(proved))
    del data["sha256"]
    for claim in data["claims"]:
        claim[key] = True
    with pytest.raises(FalseCertificateError):
        check_certificate(json.dumps({**data, "sha256": digest_of(data)}))


def test_parameters_that_move_are_no_product() -> None:
    found = prove(read_graph_text(INTEGRATING), tolerances=TOLERANCES, gain_margin="6 dB", any_change=True)
    assert found.proofs[0].coordinates is not None
    assert not any(isinstance(one, ProductRange) for one in found.proofs[0].coordinates.ranges)


class Own(Block):
    """An own gain."""

    gain: float = param("1", "What it follows.", default=100.0)
    law: int = param("", "How it does.", default=0)
    input = Input("1", "What is amplified.")


@Own.output("1")
def amplified(p: Any, input: float) -> float:
    """What comes out."""
    gain: float = p.gain
    if p.law == 1:
        gain = 1e4 / p.gain
    if p.law == 2:
        gain = 0.01 * p.gain * p.gain
    if p.law == 3:
        gain = p.gain + 50.0
    if p.law == 4:
        gain = p.gain if p.gain < 150.0 else 50.0
    if p.law == 5:
        gain = 200.0 * exponential(-0.01 * p.gain)
    return gain * input


@pytest.mark.parametrize(
    ("law", "most", "powers"),
    [
        (0, 120.0, {"own.gain": 1.0, "plant.gain": 1.0}),
        (1, 1e4 / 80.0, {"plant.gain": 1.0, "own.gain": -1.0}),
        (2, 144.0, {"own.gain": 1.0, "plant.gain": 0.5}),
        (3, 170.0, {}),
        (4, 120.0, {"plant.gain": 1.0, "own.gain": 1.0}),  # which goes further than the own gain decides alike
        (5, 200.0 * math.exp(-0.8), {}),
    ],
)
def test_an_own_block_is_in_a_product_only_where_it_multiplies(law: int, most: float, powers: dict[str, float]) -> None:
    """The most that its law gives from 80 to 120 stands in the closed form, with 10 % more of another gain."""
    graph = Graph(
        name="an own gain",
        rate="1 kHz",
        samples=400,
        blocks={
            "back": blocks.Gain(gain=-1.0),
            "own": Own(law=law),
            "plant": blocks.DiscreteIntegrator(output_unit="1", gain=1.0),
        },
        wires=["own.amplified -> plant.input", "plant.output -> back.input", "back.output -> own.input"],
        probes=["back.output"],
        loops={"main": {"open_at": "back.output"}},
    )
    limit = 20.0 * math.log10(2.0 / (most * 1.5 * 1e-3))
    within = {"own.gain": "20 %", "plant.gain": "50 %"}
    for off, expected in ((-0.1, "proved"), (0.1, "refuted")):
        found = prove_margin(graph, "main", "gain margin", limit + off, within)
        assert found.status == expected
        assert found.coordinates is not None
        joined = [one for one in found.coordinates.ranges if isinstance(one, ProductRange)]
        assert [dict(zip((one.written for one in each.factors), each.powers, strict=True)) for each in joined] == (
            [powers] if powers else []
        )


def degrees(graph: Graph, loop: str) -> dict[str, Fraction]:
    """The degree of a loop at the start of a run in each parameter that has one, one by one within 5 %."""
    planned, found = plan(graph), dict[str, Fraction]()
    begin, _ = about_margin(planned, loop, "0 s", "gain margin", 6.0)
    starting = begin(None)
    for name, block in graph.blocks.items():
        for parameter, declared in type(block).parameters.items():
            value = getattr(block, parameter)
            if declared.kind is not float or not value or not math.isfinite(value):
                continue
            name_of = f"{name}.{parameter}"
            try:
                coordinates = coordinates_of(planned, box_of(graph, {name_of: "5 %"}).ranges)
            except ModelError:  # which follows a formula, or a wire
                continue
            with enclosing():
                degree = degree_in(starting, coordinates, coordinates.ranges[0], 0)
            if degree is not None:
                found[name_of] = degree
    return found


def nominal_of(graph: Graph, name: str) -> float:
    block, _, parameter = name.partition(".")
    return float(getattr(graph.blocks[block], parameter))


@pytest.mark.parametrize(
    "case",
    chosen(
        [
            ("averaged_loop", "main", {"plant.gain": 1}),
            (
                "closed_loop_accelerometer",
                "main",
                {"adc.reference": -1, "pickoff.gain": 1, "reference.offset": 1, "resistor.gain": 1, "torquer.gain": 1},
            ),
        ],
        [
            (
                "force_balance_seismometer",
                "balance",
                {"adc.reference": -1, "coil.gain": 1, "dac.reference": 1, "pickoff.gain": 1},
            ),
            ("quartz_recalibration", "main", {"k_d.initial": 1, "n_vref.initial": 1, "spacing.value": -1}),
        ],
    ),
)
def test_a_loop_of_the_library_is_the_same_where_its_product_is(case: tuple[str, str, dict[str, int]]) -> None:
    """Margins of polynomials, for sensors whose gains make up for each other, and for others that do not count."""
    name, loop, gains = case
    graph, draw = read_graph(f"library:{name}"), random.Random(3)
    found = degrees(graph, loop)
    assert {name_of: degree for name_of, degree in found.items() if degree} == gains
    nominal: Any = margins(graph, loop, at="0 s")
    for _ in range(3):
        sensor, left = dict[str, float](), 1.0
        for name_of, degree in gains.items():
            part = draw.uniform(0.96, 1.04)
            sensor[name_of], left = part, left * part**degree
        last = next(iter(gains))
        sensor[last] *= left ** -gains[last]
        idle = draw.choice([name_of for name_of, degree in found.items() if not degree])
        sensor[idle] = draw.uniform(0.96, 1.04)
        values = {name_of: part * nominal_of(graph, name_of) for name_of, part in sensor.items()}
        figures: Any = margins(graph.with_parameters(values), loop, at="0 s")
        assert figures.least_gain_margin == pytest.approx(nominal.least_gain_margin, rel=1e-9)
        assert figures.phase_margin == pytest.approx(nominal.phase_margin, rel=1e-9)


def test_gains_of_a_loop_in_continuous_time_are_a_product_too() -> None:
    """k / s decays by k, which is 3 nominally: at least by 2.16."""
    for limit, expected in ((2.159, "proved"), (2.161, "refuted")):
        found = prove_margin(
            read_graph_text(INTEGRATOR), "main", "decay rate", limit, {"plant.gain": "10 %", "back.gain": "20 %"}
        )
        assert found.status == expected
        assert found.claim.continuous
        assert found.coordinates is not None
        assert [isinstance(one, ProductRange) for one in found.coordinates.ranges] == [True]
