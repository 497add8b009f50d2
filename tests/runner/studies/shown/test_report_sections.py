"""Parts in percent, ends of intervals, sections of several points, and what is proved."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.points import all_points_text, by_point, first_point, parts, point_text
from proofmass.runner.studies.shown.proved import ProvedBound, bounds_of, proved_section
from proofmass.runner.studies.shown.report_sections import at_each, ends_text, percent_text
from tests.by_hand.study_results import SWEPT, study_result


@pytest.mark.parametrize(
    ("part", "text"),
    [(0.0, "0 %"), (1.0, "100 %"), (0.5, "50.0 %"), (0.9996, "99.96 %"), (0.99996, "100 %"), (4e-5, "0 %")],
)
def test_parts_of_nearly_nothing_and_nearly_all_have_more_digits(part: float, text: str) -> None:
    assert percent_text(part) == text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (-math.inf, 2.0, "≤ 2"),
        (1.0, math.inf, "≥ 1"),
        (-math.inf, math.inf, "unknown"),
        (0.0, 0.123456, "0 to 0.12346"),
        (1.0000464, 1.0000566, "1.000046 to 1.000057"),  # 1 over 1e-5 is 5 digits, and two more
        (-1.0000566, -1.0000464, "-1.000057 to -1.000046"),
        (1.23456789, 1.23456789, "1.2346 to 1.2346"),
        (100.123, 101.123, "100.12 to 101.12"),
        (0.1, 0.1 + 2.0**-54, "0.1 to 0.1"),  # no more digits than a number has
    ],
)
def test_ends_of_intervals_have_the_digits_that_tell_them_apart(low: float, high: float, text: str) -> None:
    assert ends_text(low, high) == text


def runs_of(result: StudyResult) -> str:
    return f"runs {result.numbers.tolist()}" if len(result.numbers) != 1 else ""


def test_points_have_sections_under_their_names() -> None:
    """A point whose section is empty has no heading; a name that is no parameter begins with a capital."""
    result = study_result(SWEPT, {"bias": [[1.0]] * 5})
    names = ["filter.corner_frequency = 100 Hz", "filter.corner_frequency = 200 Hz"]
    text = f"<h3>{names[0]}</h3>\nruns [0, 2, 4]\n<h3>{names[1]}</h3>\nruns [1, 3]"
    assert at_each(parts)(runs_of)(result) == text
    assert at_each(parts)(runs_of)(result.some(result.numbers < 3)) == f"<h3>{names[0]}</h3>\nruns [0, 2]"
    assert at_each(lambda _: {"": result})(runs_of)(result) == "runs [0, 1, 2, 3, 4]"
    never = at_each(lambda _: {"never calibrated": result, "x = <1": result})(lambda _: "body")
    assert never(result) == "<h3>Never calibrated</h3>\nbody\n<h3>x = &lt;1</h3>\nbody"


@pytest.mark.parametrize(("points", "sections"), [(12, 12), (13, 1)])
def test_many_points_are_told_together(points: int, sections: int) -> None:
    swept = f'sweep = {{ "filter.corner_frequency" = {[*range(1, points + 1)]} }}\n'
    result = study_result(swept, {"bias": [[1.0]] * points})
    assert len(parts(result)) == sections
    assert at_each(parts)(lambda _: "")(result) == ""
    together = "<p>All 13 points of the sweep together; study.nc has them one by one.</p>\n"
    text = at_each(lambda _: {"": result})(lambda _: "body")(result)
    assert text == ("body" if sections > 1 else together + "body")
    assert all_points_text(result.study).startswith(f"all {points} points")


def test_the_point_of_no_run_is_the_first_and_a_sweep_of_one_value_has_no_name() -> None:
    result = study_result(SWEPT, {"bias": [[1.0]] * 4})
    assert [first_point(part) for part in by_point(result)] == [0, 1]
    assert [first_point(result), first_point(result.some(result.numbers < 0))] == [0, 0]
    one = study_result('sweep = { "filter.corner_frequency" = [100] }\n', {"bias": [[1.0]]})
    assert point_text(one.study, 0) == ""
    assert by_point(one) == [one]


BOUNDS = [
    ProvedBound("bias", "a bias", 0.5, "1 %", ()),
    ProvedBound("", "a <gain>", 0.25, "2 %", ("a.b", "c.d")),
    ProvedBound("noise", "noise", 2.0, "3 %", ("a.b",)),
    ProvedBound("bias", "another", 0.75, "4 %", ()),
]


def test_what_is_proved_stands_beside_the_least_of_the_runs() -> None:
    result = study_result("", {"bias": [[0.75], [np.nan], [0.5]], "noise": [[3], [2.5], [4]]}, {"bias": "V"})
    text = proved_section(result, BOUNDS)
    assert [row.count("<td") for row in text.split("</tr>")[1:-1]] == [3] * 4
    cells: Any = [row.replace("</th>", "</td>").split("</td>")[:-1] for row in text.split("<tr>")[2:]]
    bare = [[cell[cell.index(">") + 1 :] for cell in row] for row in cells]
    assert bare == [
        ["a bias", "1 %", "0.5 V", "lies within"],
        ["a &lt;gain&gt;", "2 %", "", "goes beyond: a.b, c.d"],
        ["noise", "3 %", "2.5", "goes beyond: a.b"],
        ["another", "4 %", "0.5 V", "lies within"],
    ]
    assert '<th>within</th><th class="number">least of the runs</th><th>spread of the study</th>' in text
    assert bounds_of(BOUNDS, "bias") == [0.5, 0.75]
    nothing = replace(result, values={"bias": np.full((3, 1), np.nan), "noise": np.full((3, 1), np.nan)})
    assert proved_section(nothing, BOUNDS[2:3]).count('<td class="number"></td>') == 1
