"""Charts of reports, written as SVG at once: lines, bands, bars, points and rows of effects, in panels side by side.

A report may have dozens of them; matplotlib takes a quarter of a second for each. Colours are those of the page, which
may be light or dark.
"""

from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.output.chart_axes import Axis, axis

INK, RULE, BLUE, ORANGE = "var(--ink)", "var(--rule)", "var(--blue)", "var(--orange)"
COLOURS = (BLUE, ORANGE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # of Okabe and Ito
_WIDTH, _HEIGHT, _TOP, _BELOW, _RIGHT, _GAP = 860.0, 230.0, 12.0, 44.0, 10.0, 24.0
_FONT, _LETTER, _ROW = 11.0, 6.8, 18.0  # height and mean width of a letter, height of a row of bars or a legend
_LONG = 34  # letters of a name that are shown
_AXES = f'fill="none" stroke="{INK}"'
Numbers = Any  # a sequence or array of numbers


class Frame(NamedTuple):
    """Place of the axes of a panel on the picture."""

    across: Axis
    up: Axis
    left: float
    right: float
    bottom: float
    top: float

    def x(self, value: Any) -> Any:
        """Return where a value, or an array of them, stands across."""
        return self.left + (self.right - self.left) * (value - self.across.low) / (self.across.high - self.across.low)

    def y(self, value: Any) -> Any:
        """Return where a value, or an array of them, stands upwards."""
        return self.bottom + (self.top - self.bottom) * (value - self.up.low) / (self.up.high - self.up.low)

    def places(self, x: Numbers, y: Numbers) -> list[tuple[float, float]]:
        """Return where points stand."""
        xs, ys = self.x(np.asarray(x, float)), self.y(np.asarray(y, float))
        return [(float(a), float(b)) for a, b in zip(xs, ys, strict=True)]


class Panel:
    """One pair of axes; what is drawn first lies below."""

    def __init__(self, x_label: str, y_label: str = "", share: float = 1.0, counts: bool = False) -> None:
        self.x_label, self.y_label, self.share = x_label, y_label, share
        self.counts = counts  # upwards
        self.legend = dict[str, str]()  # label to the SVG of its sign
        self.names: list[str] = []  # of rows
        self._x, self._y = list[float](), list[float]()
        self._items: list[Callable[[Frame], str]] = []
        self._seen_through = 1.0  # part of the paper that shines through all bands

    def line(self, x: Numbers, y: Numbers, colour: str = BLUE, label: str = "", dashed: bool = False) -> None:
        """Draw a line through points; gaps where a number is missing."""
        dash = ' stroke-dasharray="5 3"' if dashed else ""
        self._see(x, y)
        style = f'fill="none" stroke="{colour}" stroke-width="1.4"{dash}'
        self._items.append(lambda frame: f'<path d="{_path(frame.places(x, y))}" {style}/>')
        self._name(label, f'<line x2="20" {style}/>')

    def band(self, x: Numbers, low: Numbers, high: Numbers, colour: str, opacity: float, label: str = "") -> None:
        """Fill what lies between two lines; a band above others is as strong as all of them in the legend."""
        self._see(x, low)
        self._see(x, high)
        style = f'fill="{colour}" fill-opacity="{opacity:g}" stroke="none"'
        self._items.append(
            lambda frame: f'<path d="{_path([*frame.places(x, low), *frame.places(x, high)[::-1]])}Z" {style}/>'
        )
        self._seen_through *= 1.0 - opacity
        sign = f'fill="{colour}" fill-opacity="{1.0 - self._seen_through:.3g}" stroke="none"'
        self._name(label, f'<rect y="-5" width="20" height="10" {sign}/>')

    def bars(
        self,
        edges: Numbers,
        heights: Numbers,
        colour: str,
        label: str = "",
        opacity: float = 0.7,
        outline: bool = False,
    ) -> None:
        """Draw a histogram."""
        x, y = np.repeat(edges, 2), np.concatenate([[0.0], np.repeat(heights, 2), [0.0]])
        self._see(x, y)
        fill = (
            f'fill="none" stroke="{colour}" stroke-width="1.2"'
            if outline
            else f'fill="{colour}" fill-opacity="{opacity:g}"'
        )
        self._items.append(lambda frame: f'<path d="{_path(frame.places(x, y))}" {fill}/>')
        self._name(label, f'<rect y="-5" width="20" height="10" {fill}/>')

    def points(self, x: Numbers, y: Numbers, colour: str = BLUE, size: float = 5.0) -> None:
        """Draw dots."""
        self._see(x, y)
        style = f'stroke="{colour}" stroke-opacity="0.6" stroke-width="{size:g}" stroke-linecap="round"'
        self._items.append(
            lambda frame: f'<path d="{"".join(f"M{a:.1f} {b:.1f}h0" for a, b in frame.places(x, y))}" {style}/>'
        )

    def rule(self, value: float, upright: bool, colour: str = ORANGE, label: str = "") -> None:
        """Draw a dashed line across the panel, where a value stands."""
        (self._x if upright else self._y).append(value)
        style = f'stroke="{colour}" stroke-width="1.2" stroke-dasharray="5 3"'

        def drawn(frame: Frame) -> str:
            x, y = frame.x(value), frame.y(value)
            ends = (x, x, frame.bottom, frame.top) if upright else (frame.left, frame.right, y, y)
            return _line(ends[0], ends[1], ends[2], ends[3], style)

        self._items.append(drawn)
        self._name(label, f'<line x2="20" {style}/>')

    def rows(self, names: Sequence[str], values: Sequence[float], halves: Sequence[float]) -> None:
        """Draw a row for each name, the first on top: a bar from zero to its value, with an interval."""
        self.names = list(names)
        ends = [value + sign * half for value, half in zip(values, halves, strict=True) for sign in (-1.0, 1.0)]
        self._x += [0.0, *values, *ends]
        self._y += [-0.5, len(names) - 0.5]

        def drawn(frame: Frame) -> Iterator[str]:
            zero = frame.x(0.0)
            for row, (value, half) in enumerate(zip(values, halves, strict=True)):
                end, at = frame.x(value), frame.y(len(names) - 1.0 - row)
                colour = BLUE if value >= 0.0 else ORANGE
                place = f'x="{min(zero, end):.1f}" y="{at - 6:.1f}" width="{abs(end - zero):.1f}"'
                yield f'<rect {place} height="12" fill="{colour}"/>'
                yield _line(frame.x(value - half), frame.x(value + half), at, at, f'stroke="{INK}"')
            yield _line(zero, zero, frame.bottom, frame.top, f'stroke="{INK}"')

        self._items.append(lambda frame: "".join(drawn(frame)))

    def height(self) -> float:
        """Return the height that its rows need."""
        return max(_HEIGHT, len(self.names) * _ROW + _TOP + _BELOW)

    def svg(self, left: float, width: float, height: float) -> str:
        """Return the panel as SVG, at a place of the chart."""
        up = axis(self._y, rim=0.0 if self.names else 0.04, counts=self.counts)
        names = [text if len(text) < _LONG else f"{text[: _LONG - 2]}…" for text in self.names[::-1]]
        margin = max((len(text) for text in names or up.texts), default=0) * _LETTER + (26.0 if self.y_label else 8.0)
        frame = Frame(axis(self._x), up, left + margin, left + width - _RIGHT, height - _BELOW, _TOP)
        parts = [*self._grid(frame, names), *(item(frame) for item in self._items)]
        parts.append(f'<path d="M{frame.left:.1f} {frame.top:.1f}V{frame.bottom:.1f}H{frame.right:.1f}" {_AXES}/>')
        middle = 0.5 * (frame.left + frame.right)
        parts.append(_text(middle, frame.bottom + 33.0, self.x_label + frame.across.note(), "middle"))
        if self.y_label:
            x, y = left + 11.0, 0.5 * (frame.bottom + frame.top)
            turned = f'transform="rotate(-90 {x:.1f} {y:.1f})"'
            parts.append(_text(x, y, self.y_label + up.note(), "middle", turned))
        return "".join(parts)

    def _grid(self, frame: Frame, names: Sequence[str]) -> Iterator[str]:
        """Yield ticks, their lines and texts; every second or third text where they would meet."""
        across = frame.across
        longest = max((len(text) for text in across.texts), default=1) + 2
        every = max(1, -(-int(longest * len(across.texts) * _LETTER) // max(int(frame.right - frame.left), 1)))
        for number, (tick, text) in enumerate(zip(across.ticks, across.texts, strict=True)):
            x = frame.x(tick)
            yield _line(x, x, frame.bottom, frame.top, f'stroke="{RULE}"')
            if number % every == 0:
                yield _text(x, frame.bottom + 15.0, text, "middle")
        ticks = [float(row) for row in range(len(names))] if names else frame.up.ticks
        for tick, text in zip(ticks, names or frame.up.texts, strict=True):
            y = frame.y(tick)
            if not names:
                yield _line(frame.left, frame.right, y, y, f'stroke="{RULE}"')
            yield _text(frame.left - 5.0, y + 4.0, text, "end")

    def _see(self, x: Numbers, y: Numbers) -> None:
        self._x += np.asarray(x, float).tolist()
        self._y += np.asarray(y, float).tolist()

    def _name(self, label: str, sign: str) -> None:
        if label:
            self.legend.setdefault(label, sign)


def chart(panels: Sequence[Panel], title: str) -> str:
    """Return panels side by side as SVG, with one legend below; `title` is read out in its place."""
    height = max(panel.height() for panel in panels)
    room = _WIDTH - _GAP * (len(panels) - 1)
    whole, left, drawn = sum(panel.share for panel in panels), 0.0, []
    for panel in panels:
        width = room * panel.share / whole
        drawn.append(panel.svg(left, width, height))
        left += width + _GAP
    legend, below = _legend({label: sign for panel in panels for label, sign in panel.legend.items()}, height + 6.0)
    return (
        f'<svg class="picture" role="img" width="{_WIDTH:g}" viewBox="0 0 {_WIDTH:g} {below:g}" '
        f'font-size="{_FONT:g}" fill="var(--ink)">'
        f"<title>{escape(title)}</title>{''.join(drawn)}{legend}</svg>"
    )


def _legend(entries: dict[str, str], top: float) -> tuple[str, float]:
    """Return the SVG of a legend, in rows, and where it ends."""
    if not entries:
        return "", top
    x, y, parts = 20.0, top, []
    for label, sign in entries.items():
        width = 44.0 + _LETTER * len(label)
        if x + width > _WIDTH and x > 20.0:
            x, y = 20.0, y + _ROW
        parts.append(f'<g transform="translate({x:.1f} {y:.1f})">{sign}{_text(26.0, 4.0, label, "start")}</g>')
        x += width
    return "".join(parts), y + _ROW


def _line(x1: float, x2: float, y1: float, y2: float, style: str) -> str:
    return f'<line x1="{x1:.1f}" x2="{x2:.1f}" y1="{y1:.1f}" y2="{y2:.1f}" {style}/>'


def _path(places: Sequence[tuple[float, float]]) -> str:
    """Return lines between places; a missing number begins a new one."""
    parts, sign = [], "M"
    for x, y in places:
        known = np.isfinite(x) and np.isfinite(y)
        parts += [f"{sign}{x:.1f} {y:.1f}"] if known else []
        sign = "L" if known else "M"
    return "".join(parts)


def _text(x: float, y: float, text: str, anchor: str, more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {more}>{escape(text)}</text>'
