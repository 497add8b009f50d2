"""Pictures within pages: letters keep their size, colours are those of the page, nothing moves."""

import io
import re
import xml.etree.ElementTree as ElementTree
from itertools import pairwise

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from proofmass.runner.output.page import picture
from proofmass.runner.output.pictures import BLUE, name_rows, room_for_ticks, sheet, write_figure
from proofmass.runner.output.shown_figure import ShownFigure

TAG = "{http://www.w3.org/2000/svg}"


def drawn() -> str:
    with sheet(4.0, 3.0, "of <one> at 0.123456789") as figure:
        panel = figure.subplots()
        panel.plot([1e-9, 2e-9, 3e-9, 4e-9], [0.1234567, 0.7654321, 0.3, 0.4], "o", color=BLUE, label="a & b")
        panel.legend()
    return picture(figure, 'a "drawing" of <one>')


@pytest.mark.defect("S93", before="5 px on a screen of 400 px: the page shrank charts", after="10 px: they scroll")
def test_letters_keep_their_size_on_a_narrow_screen() -> None:
    drawing = ElementTree.fromstring(drawn())
    width = drawing.get("width", "")
    assert width.endswith("pt"), "a point is 4/3 pixels"
    assert float(width.removesuffix("pt")) == float(drawing.get("viewBox", "").split()[2])
    sizes = [float(size) * 4.0 / 3.0 for size in re.findall(r"font(?:-size)?: (?:bold )?([\d.]+)px", drawn())]
    assert len(sizes) > 10
    assert min(sizes) >= 10.0


def test_colours_are_those_of_the_page_and_texts_what_was_written() -> None:
    text = drawn()
    assert not re.search("#(?!m)[0-9a-f]{6}", text), "a colour that a dark page does not change"
    drawing = ElementTree.fromstring(text)
    assert drawing.findtext(f"{TAG}title") == 'a "drawing" of <one>'
    words = {"".join(e.itertext()).strip() for e in drawing.iter(f"{TAG}text")}
    assert {"of <one> at 0.123456789", "a & b"} <= words


def test_markers_stand_where_matplotlib_put_them() -> None:
    """Once in a style that they share; places to a hundredth of a point."""
    with sheet(4.0, 3.0) as figure:
        panel = figure.subplots()
        panel.plot([1.0, 2.0, 3.0], [0.1, 0.2, 0.15], "o", color=BLUE)
    file = io.BytesIO()
    write_figure(figure, file, "svg")
    marker = r'<use xlink:href="#(\w+)" x="([\d.]+)" y="([\d.]+)"'
    before, after = re.findall(marker, file.getvalue().decode()), re.findall(marker, picture(figure, "dots"))
    assert len(before) == len(after) > 3
    for (_, x, y), (_, x_after, y_after) in zip(before, after, strict=True):
        assert (float(x_after), float(y_after)) == pytest.approx((float(x), float(y)), abs=0.01)
    shared = re.findall(r'<g (style="[^"]*")>(?:<use [^>]*>)+</g>', picture(figure, "dots"))
    assert any("var(--blue)" in style for style in shared)


def test_rows_are_named_from_the_top() -> None:
    with sheet(4.0, 3.0) as figure:
        panel = figure.subplots()
        name_rows(panel, ["first", "$second$"])
    bottom, top = panel.get_ylim()
    assert bottom > top
    assert [label.get_text() for label in panel.get_yticklabels()] == ["first", r"\$second\$"]


@pytest.mark.parametrize(("low", "high"), [(-86700.0, -86400.0), (0.0, 1.0), (2.4981, 2.5021)])
def test_numbers_of_a_narrow_axis_stand_beside_each_other(low: float, high: float) -> None:
    with sheet(9.0, 3.1) as figure:
        for panel in figure.subplots(1, 3):
            panel.plot([low, high], [0.0, 1.0])
            room_for_ticks(panel)
    figure.draw_without_rendering()
    for panel in figure.axes:
        shown = [label.get_window_extent() for label in panel.get_xticklabels() if label.get_text()]
        assert len(shown) > 1
        assert all(left.x1 < right.x0 for left, right in pairwise(shown))


@pytest.mark.parametrize("low", [8.0, 0.02])
def test_a_logarithmic_axis_of_few_decades_has_plain_numbers_without_being_asked(low: float) -> None:
    with sheet(4.0, 3.0) as figure:
        few, many = figure.subplots(1, 2)
        few.loglog([low, 11.0 * low], [1.0, 2.0])
        many.loglog([1e-3, 1e3], [1.0, 2.0])
    figure.draw_without_rendering()
    shown = [label.get_text() for label in (*few.get_xticklabels(), *few.get_xticklabels(minor=True))]
    assert len(shown) > 1
    assert [float(text) for text in shown] == pytest.approx(few.get_xticks()), "no powers of ten"
    assert any("mathdefault" in label.get_text() for label in many.get_xticklabels())


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_panels_are_drawn_once_and_stand_where_two_draws_leave_them(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def written() -> bytes:
        with sheet(4.0, 3.0, "of two panels") as figure:
            upper, lower = figure.subplots(2)
            upper.loglog([1.0, 1e6], [1e-3, 1e4], label="a long name of a line")
            upper.legend()
            lower.set_ylabel("deviation")
        file = io.BytesIO()
        write_figure(figure, file, kind)
        return file.getvalue()

    panels: list[Axes] = []
    draw_axes = Axes.draw
    monkeypatch.setattr(Axes, "draw", lambda axes, renderer: (panels.append(axes), draw_axes(axes, renderer)))
    once = written()
    assert len(panels) == 2
    monkeypatch.setattr(ShownFigure, "draw", Figure.draw)
    assert written() == once
    assert len(panels) == 6
