"""What people read and see of worst cases, from results that were written by hand."""

import math
from dataclasses import replace

import pytest

from proofmass.graphs.model.quantities import LoopFigure, MeasureOf
from proofmass.runner.design.quantities.loop_figures import NoValue
from proofmass.runner.design.worst.plot import plot_worst
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.design.worst.text import worst_text
from proofmass.runner.design.worst.worst import OneAtATime, WorstCase, WorstCases

RANGES = (
    Range("sensor.mass", "sensor.mass", "kg", 5e-8, 4.5e-8, 5.5e-8),
    Range("gain.gain", "gain.gain", "1", 2.0, 1.9, 2.1),
    Range("seed", "seed", "1", 0.0, -1.0, 1.0),
)
CASE = WorstCase(
    name="phase",
    quantity=LoopFigure("main", "phase_margin", "deg"),
    side="lowest",
    nominal=60.0,
    worst=45.5,
    first_order=47.25,
    values={"sensor.mass": 5.5e-8, "gain.gain": 1.9, "seed": 0.25},
    places={"sensor.mass": 1.0, "gain.gain": -1.0, "seed": 0.25},
    one_at_a_time=(
        OneAtATime("gain.gain", 55.0, 62.0),
        OneAtATime("sensor.mass", 66.0, 50.0),
        OneAtATime("seed", 60.0, 60.0),
    ),
    corners=(),
)


def cases(*of: WorstCase, **more: object) -> WorstCases:
    facts = {"corners": 8, "random": 58, "evaluations": 70, "interrupted": False, "left_out": {}}
    return WorstCases(RANGES, of, **{**facts, **more})  # type: ignore[arg-type]


def test_every_line_of_a_worst_case() -> None:
    """58 random points leave 1 - 0.05^(1/58) = 5.0 % of the box."""
    text = worst_text(cases(CASE, left_out={"hiss.density": "no loop depends on it"}))
    assert text.splitlines() == [
        "phase: 60 deg nominal, 45.5 deg at worst, inside the tolerances",
        "  derivatives at the nominal values say 47.25 deg",
        "  parameter        low     high      at worst  unit  alone, low  alone, high",
        "  sensor.mass  4.5e-08  5.5e-08  5.5e-08 high  kg            66           50",
        "  gain.gain        1.9      2.1       1.9 low                55           62",
        "  of little or no effect alone: seed",
        "",
        "looked at all 8 corners and 58 random points of 3 parameters, 70 points in all",
        "no random point is worse: with 95 % confidence less than 5 % of the box is; this is a search, not a proof",
        "hiss.density does not count: no loop depends on it",
    ]


@pytest.mark.defect(
    "S805",
    before="a parameter that makes a loop unstable alone, and all beside it, are `of little or no effect alone`",
    after="it stands first in the table, and the others with what they do",
)
def test_a_parameter_that_leaves_no_value_has_the_largest_effect() -> None:
    ends = OneAtATime("gain.gain", None, 62.0), OneAtATime("sensor.mass", 66.0, 50.0), OneAtATime("seed", 60.0, 60.0)
    lines = worst_text(cases(replace(CASE, one_at_a_time=ends))).splitlines()
    assert [line.split()[0] for line in lines[3:5]] == ["gain.gain", "sensor.mass"]
    assert lines[3].split()[-2:] == ["unstable", "62"]
    assert lines[5] == "  of little or no effect alone: seed"


def test_values_that_are_none_and_searches_that_ended_early() -> None:
    lost = replace(CASE, quantity=MeasureOf("end", "1"), nominal=math.inf, worst=None, places={"sensor.mass": 1.0})
    ends = OneAtATime("gain.gain", None, math.inf), OneAtATime("sensor.mass", 1.0, 2.0), OneAtATime("seed", 0.0, 0.0)
    lost = replace(lost, one_at_a_time=ends, places={**dict.fromkeys(CASE.places, 1.0), "gain.gain": 0.5})
    lines = worst_text(cases(lost, interrupted=True, corners=5, random=0)).splitlines()
    assert lines[:2] == [
        "interrupted: the worst so far",
        "phase: no limit nominal, no value at worst, inside the tolerances",
    ]
    assert "derivatives" not in "".join(lines)
    (row,) = [line for line in lines if "gain.gain" in line]
    assert row.split()[3:] == ["1.9", "inside", "no", "value", "no", "limit"]
    assert lines[-1] == "looked at 5 of 8 corners and 0 random points of 3 parameters, 70 points in all"
    corner = replace(CASE, worst=None, places=dict.fromkeys(CASE.places, -1.0))
    assert worst_text(cases(corner)).splitlines()[0] == "phase: 60 deg nominal, unstable at worst, at a corner"


@pytest.mark.parametrize("number", [3, 12, 14])
def test_a_table_has_twelve_rows(number: int) -> None:
    """The first ones have the largest effect; of the others the names of twelve are told."""
    names = [f"a{k}" for k in range(12 + number)]
    moves = [0.0 if k < number else float(k) for k in range(12 + number)]
    ranges = tuple(Range(name, name, "1", 0.0, -1.0, 1.0) for name in names)
    singles = tuple(OneAtATime(name, 60.0 - by, 60.0) for name, by in zip(names, moves, strict=True))
    case = replace(CASE, values=dict.fromkeys(names, 1.0), places=dict.fromkeys(names, 1.0), one_at_a_time=singles)
    lines = worst_text(WorstCases(ranges, (case,), 1, 0, 1, False, {})).splitlines()
    assert [line.split()[0] for line in lines[3:15]] == names[:-13:-1]
    listed = ", ".join(names[: min(number, 12)])
    assert lines[15] == f"  of little or no effect alone: {listed}{' and more' if number > 12 else ''}"


def test_bars_begin_at_the_nominal_value_and_end_where_each_parameter_leads() -> None:
    (panel,) = plot_worst(cases(CASE)).axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["sensor.mass", "gain.gain", "all together"]
    drawn = [
        (round(bar.get_y() + 0.3), bar.get_x() + min(bar.get_width(), 0.0), abs(bar.get_width()))
        for bar in panel.patches
    ]
    expected = [(0, 60.0, 6.0), (0, 50.0, 10.0), (1, 55.0, 5.0), (1, 60.0, 2.0), (2, 45.5, 14.5)]
    for found, wanted in zip(drawn, expected, strict=True):
        assert found == pytest.approx(wanted)
    assert panel.get_title(loc="left") == "phase: 60 ° nominal, 45.5 ° at worst"
    assert panel.get_xlabel().splitlines() == ["phase margin of main [°]", "not drawn, too little alone: seed"]


@pytest.mark.defect("S975", before="what has no limit was `unstable`, as was any other reason", after="`no limit`")
@pytest.mark.parametrize(("nominal", "word"), [(None, "unstable"), (math.inf, "no limit")])
def test_without_a_nominal_value_nothing_is_drawn(nominal: float | None, word: str) -> None:
    (panel,) = plot_worst(cases(replace(CASE, nominal=nominal))).axes
    assert panel.get_title(loc="left") == f"phase: {word} at the nominal values"
    assert not panel.patches
    assert not panel.axison


def test_ends_that_have_no_value_have_no_bar() -> None:
    ends = (
        OneAtATime("gain.gain", None, 62.0),
        OneAtATime("sensor.mass", 50.0, math.inf),
        OneAtATime("seed", None, None),
    )
    (panel,) = plot_worst(cases(replace(CASE, worst=None, one_at_a_time=ends))).axes
    rows = [label.get_text() for label in panel.get_yticklabels()]
    assert rows == ["gain.gain", "sensor.mass", "seed", "all together"]
    assert [bar.get_width() for bar in panel.patches] == pytest.approx([0.0, 2.0, -10.0, 0.0, 0.0, 0.0])
    assert panel.get_title(loc="left") == "phase: 60 ° nominal, unstable at worst"
    assert panel.get_xlabel().splitlines() == [
        "phase margin of main [°]",
        "without a finite value at an end: gain.gain, sensor.mass, seed",
    ]


def test_effects_of_a_millionth_stand_in_the_table_and_those_of_rounding_do_not() -> None:
    ends = (
        OneAtATime("gain.gain", 60.0, 50.0),
        OneAtATime("sensor.mass", 60.0, 60.0 + 1e-5),
        OneAtATime("seed", 60.0, 60.0 + 1e-10),
    )
    lines = worst_text(cases(replace(CASE, one_at_a_time=ends))).splitlines()
    assert [line.split()[0] for line in lines[3:5]] == ["gain.gain", "sensor.mass"]
    assert lines[5] == "  of little or no effect alone: seed"


def test_bars_in_millivolts_the_fifteen_longest() -> None:
    """4 mV nominal and -2 mV at worst; the one that leads 1 % as far as all together has a bar, of 0.4 % has none."""
    names = [f"p{k}" for k in range(20)]
    moves = [1e-4 * (k + 1) for k in range(17)]
    singles = [OneAtATime(name, 4e-3 + by, 4e-3 - 0.5 * by) for name, by in zip(names, moves, strict=False)]
    case = replace(CASE, quantity=MeasureOf("end", "V"), nominal=4e-3, worst=-2e-3, one_at_a_time=tuple(singles))
    (panel,) = plot_worst(cases(case)).axes
    rows = [label.get_text() for label in panel.get_yticklabels()]
    assert rows == [*names[16:1:-1], "all together"]
    assert [bar.get_width() for bar in panel.patches[:2]] == pytest.approx([1.7, -0.85])
    assert (panel.patches[-1].get_x(), panel.patches[-1].get_width()) == pytest.approx((4.0, -6.0))
    assert panel.get_title(loc="left") == "end: 4 mV nominal, -2 mV at worst".replace("end", "phase")
    assert panel.get_xlabel().splitlines() == ["measure end [mV]", "not drawn, too little alone: p0, p1"]
    assert [text.get_text() for text in panel.get_legend().get_texts()] == ["low", "high"]
    short = tuple(OneAtATime(name, 4e-3, 4e-3 + by) for name, by in zip(names, (6e-5, 2.4e-5), strict=False))
    (panel,) = plot_worst(cases(replace(case, one_at_a_time=short))).axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["p0", "all together"]


def test_bars_about_a_nominal_value_of_0_and_none_where_nothing_moves() -> None:
    """-0.6 and 1.2 in volts, by the worst case of 2 V; a parameter that does nothing has no bar."""
    ends = OneAtATime("gain.gain", -0.6, 0.0), OneAtATime("sensor.mass", 0.0, 1.2), OneAtATime("seed", 0.0, 0.0)
    case = replace(CASE, quantity=MeasureOf("end", "V"), nominal=0.0, worst=2.0, one_at_a_time=ends)
    (panel,) = plot_worst(cases(case)).axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["sensor.mass", "gain.gain", "all together"]
    (panel,) = plot_worst(cases(replace(case, nominal=4e-3))).axes
    assert panel.get_title(loc="left") == "phase: 0.004 V nominal, 2 V at worst"
    (panel,) = plot_worst(cases(replace(case, worst=0.0, one_at_a_time=ends[2:]))).axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["all together"]


@pytest.mark.defect("S975", before="`unstable`, whatever the reason", after="no value, and why")
def test_reasons_without_a_value_stand_below_once() -> None:
    none, lost = NoValue("the loop main has no gain"), NoValue("the loop main is unstable", unstable=True)
    why = {"nominal": none, "worst": none, "gain.gain, low": lost}
    ends = OneAtATime("gain.gain", None, 62.0), OneAtATime("sensor.mass", 66.0, 50.0), OneAtATime("seed", 60.0, 60.0)
    case = replace(CASE, nominal=None, worst=None, first_order=None, one_at_a_time=ends, why=why)
    lines = worst_text(cases(case)).splitlines()
    assert lines[:3] == [
        "phase: no value nominal, no value at worst, inside the tolerances",
        "  the loop main has no gain",
        "  the loop main is unstable",
    ]
    (row,) = [line for line in lines if "gain.gain" in line]
    assert row.split()[-2:] == ["unstable", "62"]
    assert plot_worst(cases(case)).axes[0].get_title(loc="left") == "phase: no value at the nominal values"


@pytest.mark.defect("H891", before="rounding of what nothing moves stood in the table", after="little or no effect")
def test_what_moves_by_rounding_alone_has_no_row() -> None:
    """1 and the next number above it."""
    ends = tuple(OneAtATime(r.written, 1.0, math.nextafter(1.0, 2.0)) for r in RANGES)
    lines = worst_text(cases(replace(CASE, nominal=1.0, worst=1.0, one_at_a_time=ends))).splitlines()
    assert lines[3] == "  of little or no effect alone: sensor.mass, gain.gain, seed"
