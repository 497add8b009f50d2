"""The box of a worst case: places and what parameters are there, by arithmetic on paper."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, ModelError, Study
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.design.worst.box import ToleranceBox, box_of

YEAR = 365.25 * 86400.0


def graph(values: str = "", **constants: object) -> Graph:
    lines = ['name = "sum"', 'rate = "1 kHz"', "samples = 1", f"values = {{ {values} }}", "[blocks]"]
    lines += [f'{name} = {{ kind = "Constant", value = {value} }}' for name, value in constants.items()]
    lines += ["[measures]", *(f'{name} = {{ signal = "{name}.output", statistic = "last" }}' for name in constants)]
    return read_graph_text("\n".join(lines))


def at(box: ToleranceBox, **places: float) -> dict[str, float]:
    """Parameters where some coordinates are at places, and all others nominal; names without their parameter."""
    unknown = places.keys() - {wanted.name.removesuffix(".value") for wanted in box.ranges}
    assert not unknown
    place = [places.get(wanted.name.removesuffix(".value"), 0.0) for wanted in box.ranges]
    return {name.removesuffix(".value"): value for name, value in box.values(place).items()}


FOLLOWED: dict[str, Any] = {
    "v": {"uniform": 1.0},
    "a.value": {"uniform": "10 %", "relative": True},
    "alone.value": {"values": [7.0]},
}


def test_a_follower_is_spread_about_what_it_follows() -> None:
    box = box_of(Study(graph("v = 0", a='"= 2 * v"', alone=7), spread=FOLLOWED), {})
    assert [wanted.name for wanted in box.ranges] == ["a.value", "v"], "by name; one choice is none"
    assert at(box) == {"v": 0.0, "a": 0.0, "alone": 7.0}
    assert at(box, v=1.0) == {"v": 1.0, "a": 2.0, "alone": 7.0}
    assert at(box, v=0.5, a=-1.0)["a"] == pytest.approx(0.9)
    assert at(box, v=-1.0, a=0.5)["a"] == pytest.approx(-2.1), "the place is of its own value, however signs turn"


def test_widths_are_those_of_one_coordinate_with_the_others_nominal_or_half_way() -> None:
    """a is 0 where v is nominal: its own spread only shows where v is half way, at v = 1 it goes to 2 * 1.05."""
    box = box_of(Study(graph("v = 0", a='"= 2 * v"', alone=7), spread=FOLLOWED), {})
    assert box.widths() == pytest.approx({"v": 2.0, "a.value": 4.2}), "and none of what has one choice"


def test_of_a_list_the_value_next_to_that_of_the_graph_is_nominal() -> None:
    (values,) = box_of(Study(graph(d=3), spread={"d.value": {"values": [-4.0, 1.0, 2.5, 5.0]}}), {}).ranges
    assert values.nominal == 2.5


def test_slopes_are_those_of_the_places() -> None:
    spread: dict[str, Any] = {
        "b.value": {"normal": "5 %", "relative": True},
        "c.value": {"lognormal": 0.1},
        "d.value": {"values": [1.0, 2.0, 4.0]},
    }
    box = box_of(Study(graph(b=-2, c=1.5, d=2), spread=spread), {})
    for place in (-1.0, -0.3, 0.0, 1.0):
        by_b, by_c, by_d = box.slopes([place, place, place])
        assert by_b == pytest.approx({"b.value": 0.3, "c.value": 0.0, "d.value": 0.0}), "up is up, also below 0"
        grown = 0.3 * 1.5 * math.exp(0.3 * place)
        assert by_c == pytest.approx({"b.value": 0.0, "c.value": grown, "d.value": 0.0}, rel=1e-5)
        assert by_d == {"b.value": 0.0, "c.value": 0.0, "d.value": 0.0}, "a list has none"


NORMAL: dict[str, Any] = {f"{name}.value": {"normal": 1.0} for name in "abcde"}


@pytest.mark.parametrize(
    ("correlation", "places", "deviates"),
    [
        (0.5, (1.0, 0.0), (3.0, 1.5)),  # alone: the other one where it is expected
        (0.5, (0.5, 0.0), (1.5, 0.75)),
        (0.5, (1.0, 1.0), (3.0, 3.0)),
        (0.5, (1.0, -1.0), (math.sqrt(4.5), -math.sqrt(4.5))),  # z' R^-1 z = 4 z^2 = 18
        (-0.5, (1.0, 1.0), (math.sqrt(4.5), math.sqrt(4.5))),
        (0.5, (-0.2, 0.2), (-0.2 * math.sqrt(4.5), 0.2 * math.sqrt(4.5))),
        (1.0, (1.0, 0.0), (3.0, 3.0)),
        (1.0, (1.0, -1.0), (0.0, 0.0)),  # ends that do not exist
        (-1.0, (1.0, -0.5), (3.0, -3.0)),
    ],
)
def test_a_correlated_pair_goes_as_far_as_is_likely(
    correlation: float, places: tuple[float, float], deviates: tuple[float, float]
) -> None:
    spread = {name: NORMAL[name] for name in ("a.value", "b.value")}
    study = Study(graph(a=0, b=0), spread=spread, correlation={"a.value": {"b.value": correlation}})
    assert tuple(at(box_of(study, {}), a=places[0], b=places[1]).values()) == pytest.approx(deviates, abs=1e-12)


def test_groups_are_correlated_by_way_of_others_and_apart_from_the_rest() -> None:
    """a with b, b with c: R p of (1, 0, 0) is (1, 0.6, 0). d with e."""
    pairs: dict[str, Any] = {"a.value": {"b.value": 0.6}, "b.value": {"c.value": -0.5}, "d.value": {"e.value": 0.8}}
    box = box_of(Study(graph(a=0, b=0, c=0, d=0, e=0), spread=NORMAL, correlation=pairs), {})
    assert at(box, a=1.0) == pytest.approx({"a": 3.0, "b": 1.8, "c": 0.0, "d": 0.0, "e": 0.0})
    assert at(box, b=1.0) == pytest.approx({"a": 1.8, "b": 3.0, "c": -1.5, "d": 0.0, "e": 0.0})
    assert at(box, c=-1.0, e=1.0) == pytest.approx({"a": 0.0, "b": 1.5, "c": -3.0, "d": 2.4, "e": 3.0})


def test_a_tolerance_takes_the_place_of_a_spread_and_of_its_correlation() -> None:
    spread = {name: NORMAL[name] for name in ("a.value", "b.value")}
    study = Study(graph(a=1, b=0), spread=spread, correlation={"a.value": {"b.value": 0.5}})
    box = box_of(study, {"a.value": "10 %"})
    assert at(box, a=1.0) == pytest.approx({"a": 1.1, "b": 0.0})
    assert at(box, b=1.0) == pytest.approx({"a": 1.0, "b": 3.0})
    assert [(wanted.name, wanted.low, wanted.high) for wanted in box.ranges] == [
        ("a.value", pytest.approx(0.9), pytest.approx(1.1)),
        ("b.value", -3.0, 3.0),
    ]


def test_a_truncated_deviate_ends_where_it_is_cut() -> None:
    spread: dict[str, Any] = {"a.value": {"normal": 1.0, "truncated": 2.5}, "b.value": {"normal": 1.0, "truncated": 4}}
    box = box_of(Study(graph(a=0, b=0), spread=spread), {})
    assert at(box, a=1.0, b=-1.0) == pytest.approx({"a": 2.5, "b": -3.0}), "and at three standard deviations"


def test_what_drifts_goes_by_its_pace_its_walk_and_the_age() -> None:
    drift: dict[str, Any] = {
        "e.value": {"ramp": "1 1/year", "ramp_spread": "0.5 1/year", "random_walk": "0.1 1/sqrt(year)"}
    }
    box = box_of(Study(graph(e=10), drift=drift, epochs={"ages": ["0 h", "1 year", "4 year"]}), {})
    names = [wanted.name for wanted in box.ranges]
    assert names == ["age", "drift.e.value.ramp", "drift.e.value.random_walk"]
    age, ramp, walk = box.ranges
    assert (age.choices, age.nominal) == (pytest.approx((0.0, YEAR, 4.0 * YEAR)), 0.0)
    assert (ramp.nominal * YEAR, ramp.low * YEAR, ramp.high * YEAR) == pytest.approx((1.0, -0.5, 2.5))
    assert (walk.nominal, walk.high * math.sqrt(YEAR)) == (0.0, pytest.approx(0.3))
    assert (ramp.unit, walk.unit) == ("1/s", "1/sqrt(s)")
    for place, years in ((-1.0, 0.0), (1e-9, 1.0), (1.0, 4.0)):
        (value,) = box.values([place, 0.4, -0.5]).values()
        assert value == pytest.approx(10.0 + (1.0 + 0.4 * 1.5) * years - 0.5 * 0.3 * math.sqrt(years))


def test_one_age_is_where_all_are() -> None:
    drift: dict[str, Any] = {"e.value": {"ramp": "1 1/year", "ramp_spread": "0.5 1/year"}}
    box = box_of(Study(graph(e=10), drift=drift, epochs={"ages": ["2 year"]}), {})
    assert [wanted.name for wanted in box.ranges] == ["drift.e.value.ramp"]
    assert list(box.values([1.0]).values()) == pytest.approx([15.0])


def test_ends_that_a_block_does_not_take_are_refused_at_once() -> None:
    text = """\
name = "two resonators"
rate = "1 kHz"
samples = 1
wires = ["push.output -> first.force", "push.output -> second.force"]
[blocks]
push = { kind = "Constant", unit = "N" }
first = { kind = "MassSpringDamper", mass = "1 kg", damping = "1 kg/s", stiffness = "1 N/m" }
second = { kind = "MassSpringDamper", mass = "2 kg", damping = "1 kg/s", stiffness = "1 N/m" }
"""
    with pytest.raises(ModelError) as refused:
        box_of(read_graph_text(text), {"first.mass": "120 %", "second.mass": "50 %", "second.damping": "300 %"})
    assert [(problem.got, problem.path) for problem in refused.value.problems] == [
        ("-0.2 to 2.2", ("tolerances", "first.mass")),
        ("-2 to 4", ("tolerances", "second.damping")),
    ]


@pytest.mark.defect(
    "S911", before="a value of weight 0, which no sensor has, was the worst", after="the least of those drawn"
)
def test_a_value_that_no_sensor_has_is_no_end() -> None:
    spread = {"a.value": {"values": [-5.0, -2.0, 1.0, 4.0], "weights": [0, 1, 3, 0]}}
    (wanted,) = box_of(Study(graph(a=0), spread=spread), {}).ranges
    assert (wanted.low, wanted.high) == (-2.0, 1.0)
    assert wanted.choices == (-2.0, 1.0)


@pytest.mark.defect(
    "S912", before="derivatives said twice as much of two parameters that are one", after="as far as they go together"
)
@pytest.mark.parametrize(
    ("correlation", "largest"),
    [
        (1.0, 9.0),
        (-1.0, 3.0),
        (0.5, 9.0),  # (3, 3) is likely enough: z' R^-1 z = 12
        (-0.5, 6.0 + 3.0 * (math.sqrt(3.0) - 1.0) / 2.0),  # b at 3, and z' R^-1 z = 18
    ],
)
def test_derivatives_count_as_far_as_correlated_deviates_go(correlation: float, largest: float) -> None:
    """Of a + 2 b, both of deviation 1. Alone, each takes the other one along."""
    spread = {name: NORMAL[name] for name in ("a.value", "b.value")}
    box = box_of(Study(graph(a=0, b=0), spread=spread, correlation={"a.value": {"b.value": correlation}}), {})
    slopes = np.array([3.0 + 6.0 * correlation, 3.0 * correlation + 6.0])
    assert box.largest_change(slopes, slopes) == pytest.approx(largest, rel=1e-7)


def test_derivatives_of_a_parameter_that_falls_with_its_deviate() -> None:
    """Of a + 2 b + c: b = -1 - z2, so that with 0.5 it is the sum of two of -0.5. c lies 1 below and 2 above."""
    spread = {"a.value": NORMAL["a.value"], "b.value": {"normal": 1.0, "relative": True}}
    study = Study(graph(a=0, b=-1, c=0), spread=spread, correlation={"a.value": {"b.value": 0.5}})
    box = box_of(study, {"c.value": [-1.0, 2.0]})
    assert [wanted.written for wanted in box.ranges] == ["a.value", "b.value", "c.value"]
    up, down = np.array([0.0, 4.5, 2.0]), np.array([0.0, 4.5, 1.0])
    assert box.largest_change(up, down) == pytest.approx(6.0 + 3.0 * (math.sqrt(3.0) - 1.0) / 2.0 + 2.0, rel=1e-7)
