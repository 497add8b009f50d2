"""Charts of reports: what is drawn stands where its numbers say."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from proofmass.runner.output.chart_axes import axis
from proofmass.runner.output.charts import Panel, chart


@pytest.mark.parametrize(
    ("values", "texts", "power"),
    [
        ([0.0, 1.0], ("0.0", "0.2", "0.4", "0.6", "0.8", "1.0"), 0),
        ([0.0, 1.2e-6], ("0.00", "0.25", "0.50", "0.75", "1.00"), -6),
        ([2.0e7, 2.5e7], ("2.0", "2.1", "2.2", "2.3", "2.4", "2.5"), 7),
        ([-10.0, 0.0], ("−10", "−8", "−6", "−4", "−2", "0"), 0),
    ],
)
def test_ticks_are_round_and_told_apart(values: list[float], texts: tuple[str, ...], power: int) -> None:
    made = axis(values, rim=0.0)
    assert made.texts == texts
    assert made.power == power


@pytest.mark.parametrize("values", [[], [3.0, 3.0], [0.0], [float("nan"), 2.0], [1e300, -1e300], [5.0, 5.0 + 1e-13]])
def test_an_axis_of_anything_has_two_ends(values: list[float]) -> None:
    made = axis(values)
    assert made.low < made.high
    assert all(made.low <= tick <= made.high for tick in made.ticks)
    assert len(set(made.texts)) == len(made.texts)


def test_a_line_goes_through_its_points() -> None:
    panel = Panel("time [s]", "voltage [V]")
    panel.line([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, np.nan, 4.0], label="of <one>")
    panel.rule(2.0, upright=False, label="limit")
    drawing = ElementTree.fromstring(chart([panel], "a & b"))
    path = next(
        e.get("d", "") for e in drawing.iter("path") if "M" in e.get("d", "") and e.get("stroke-width") == "1.4"
    )
    assert [word[0] for word in re.findall(r"[ML][\d. ]+", path)] == ["M", "L", "M"]  # a gap where a number is missing
    (x0, y0), (x1, y1), (x3, y3) = [tuple(map(float, w[1:].split())) for w in re.findall(r"[ML][\d. ]+", path)]
    assert x3 - x0 == pytest.approx(3.0 * (x1 - x0), abs=0.2)
    assert y3 - y0 == pytest.approx(4.0 * (y1 - y0), abs=0.2)
    rule = next(e for e in drawing.iter("line") if e.get("stroke-dasharray") and e.get("y1") is not None)
    assert float(rule.get("y1", "")) == pytest.approx(0.5 * (y0 + y3), abs=0.2)
    words = [e.text for e in drawing.iter("text")]
    assert {"of <one>", "limit", "time [s]", "voltage [V]"} <= set(words)


def test_rows_of_effects_stand_in_order() -> None:
    panel = Panel("effect")
    panel.rows(["first", "second"], [2.0, -1.0], [0.1, 0.2])
    drawing = ElementTree.fromstring(chart([panel], "effects"))
    bars = [(float(e.get("y", "")), float(e.get("width", ""))) for e in drawing.iter("rect")]
    assert bars[0][0] < bars[1][0]
    assert bars[0][1] == pytest.approx(2.0 * bars[1][1], abs=0.2)


@pytest.mark.defect("S93", before="5 px on a screen of 400 px: the page shrank charts", after="11 px: they scroll")
def test_letters_keep_their_size_on_a_narrow_screen() -> None:
    panel = Panel("time [s]", "runs", counts=True)
    panel.line([0.0, 1.0], [0.0, 3.0], label="a line")
    drawing = ElementTree.fromstring(chart([panel], "one"))
    assert float(drawing.get("width", "0")) == float(drawing.get("viewBox", "").split()[2])
    sizes = [float(size) for e in drawing.iter() if (size := e.get("font-size"))]
    assert min(sizes) >= 10.0
