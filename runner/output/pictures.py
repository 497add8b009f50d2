"""One way to draw: sheets in the house's style, colours, names of axes, and files that are the same every time."""

import io
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.runner.output.export import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

INK, GRID, PAPER = "#1b1b1b", "#d9d9d9", "#ffffff"
BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"  # of Okabe and Ito, distinct for every kind of colour vision
COLOURS = (BLUE, ORANGE, GREEN, "#cc79a7", "#e69f00", "#56b4e9")
STYLE: Any = {
    "font.size": 10.8,  # exponents, smaller by a third, still have ten pixels
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans"],
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.formatter.limits": (-4, 6),
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "svg.hashsalt": "proofmass",
    "path.simplify": True,
}
_MOST_DEGREES, _LETTER, _GAP = 6, 0.75, 2  # numbers of an axis, a letter's width over its size, letters between them
_FEWEST_TICKS = 3
_FEW_DEGREES, _MANY_DEGREES, _FEW_DECADES = 120.0, 600.0, 300.0  # of an axis: spans; its end over its beginning
_MOST_DEGREES = 14  # numbers of an axis of degrees
_NO_DATE: dict[str, dict[str, None]] = {  # the same result gives the same bytes
    "svg": {"Date": None, "Creator": None, "Format": None, "Type": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}


@contextmanager
def sheet(width: float, height: float, title: str = "", layout: Any = "constrained") -> Iterator["Figure"]:
    """Yield an empty figure, in inches; the title is at its left end, for narrow screens."""
    # start-up time: matplotlib takes 0.3 s, and most callers draw nothing
    import matplotlib

    # start-up time: as above
    from proofmass.runner.output.shown_figure import ShownFigure

    with matplotlib.rc_context(STYLE):
        figure = ShownFigure(figsize=(width, height), facecolor=PAPER, layout=layout)
        figure.drawn = svg_of
        if title:
            figure.suptitle(literal(title), x=0.008, ha="left", size=12, weight="bold")
        yield figure
        for panel in figure.axes:
            for axis in (panel.xaxis, panel.yaxis):
                if axis.get_scale() == "log":
                    _plain_numbers(axis)


def axis_label(name: str, unit: str) -> str:
    """Return the name of an axis with its unit in print.

    >>> axis_label("density", "V/sqrt(Hz)"), axis_label("deviation", "1"), axis_label("", "V")
    ('density [V/√Hz]', 'deviation', '[V]')
    """
    return literal(name if unit in ("", "1") else f"{name} [{pretty(unit)}]".lstrip())


def name_rows(panel: "Axes", names: Sequence[str]) -> None:
    """Name rows of bars, the first on top."""
    panel.set_yticks(range(len(names)), [literal(name) for name in names])
    panel.set_ylim(max(len(names), 1) - 0.4, -0.6)
    panel.grid(visible=False, axis="y")


def room_for_ticks(panel: "Axes") -> None:
    """Give the horizontal axis only as many numbers as stand beside each other in its width."""
    places = panel.get_window_extent().width / panel.figure.dpi * 72.0 / (_LETTER * STYLE["font.size"])
    for number in range(_MOST_DEGREES, 1, -1):
        panel.locator_params(axis="x", nbins=number)
        shown = panel.xaxis.get_major_formatter().format_ticks([float(place) for place in panel.get_xticks()])
        if sum(len(text) + _GAP for text in shown) <= places:
            break


def phase_ticks(panel: "Axes") -> None:
    """Number a vertical axis of degrees by eighths of a turn, or thirds of these, or by halves, so many that fit."""
    bottom, top = panel.get_ylim()
    step = 15.0 if top - bottom < _FEW_DEGREES else 45.0 if top - bottom < _MANY_DEGREES else 180.0
    while (top - bottom) / step > _MOST_DEGREES:
        step *= 2.0
    places = [step * number for number in range(math.ceil(bottom / step), math.floor(top / step) + 1)]
    if len(places) > 1:
        panel.set_yticks(places)


def _plain_numbers(axis: "Axis") -> None:
    """Number a logarithmic axis of few decades plainly, 500 instead of 5×10², and so that no two numbers touch."""
    # start-up time: matplotlib takes 0.3 s, and most callers draw nothing
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

    low, high = axis.get_view_interval()
    if high / low > _FEW_DECADES:
        return
    round_ones = LogLocator(subs=(1.0, 2.0, 5.0))
    seen = [number for number in round_ones.tick_values(low, high) if low <= number <= high]
    axis.set_major_locator(round_ones if len(seen) >= _FEWEST_TICKS else MaxNLocator(5))
    axis.set_major_formatter(FuncFormatter(lambda number, _: f"{number:g}"))
    axis.set_minor_locator(NullLocator())


def literal(text: str) -> str:
    """Return text that matplotlib does not read as a formula."""
    return text.replace("$", r"\$")


def save_figure(figure: "Figure", path: str | Path) -> Path:
    """Write any figure, whole or not at all, without a date in it."""
    kind = figure_kind(path)
    with whole_file(path) as file:
        write_figure(figure, file, kind)
    return Path(path)


def svg_of(figure: "Figure", **style: Any) -> str:
    """Return a figure as an element of SVG."""
    file = io.BytesIO()
    write_figure(figure, file, "svg", **style)
    text = file.getvalue().decode()
    return text[text.index("<svg") :]


def figure_kind(path: str | Path) -> str:
    """Return the kind of picture of a file's ending; raises `ValueError` for an unknown one."""
    kind = Path(path).suffix.lower().removeprefix(".")
    if kind not in _NO_DATE:
        raise ValueError(f"cannot draw {Path(path).name}: {did_you_mean(kind, _NO_DATE, 'the endings')}")
    return kind


def write_figure(figure: "Figure", file: BinaryIO, kind: str, **style: Any) -> None:
    """Write a figure as "svg", "png" or "pdf": the same bytes every time."""
    # start-up time: matplotlib takes 0.3 s, and most callers draw nothing
    import matplotlib

    written = io.BytesIO()
    with matplotlib.rc_context(STYLE | style):
        figure.savefig(written, format=kind, dpi=150, metadata=_NO_DATE[kind])
    data = written.getvalue()
    if kind == "svg":  # matplotlib names clips by the last digits of a layout that it iterates
        for number, name in enumerate(dict.fromkeys(re.findall(rb'"(p[0-9a-f]{10})"', data))):
            data = data.replace(name, b"clip_%d" % number)
    file.write(data)
