"""Pictures of a result: one panel per probe, names and units on the axes."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.shown_units import display, in_table, prefix, pretty
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.graph import split
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, literal, save_figure, sheet
from proofmass.runner.run.result import Result, Trace, pieces, statistics

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PANELS = 40
_FEW = 300  # rows up to which held signals are drawn as steps
_DOTTED = 120  # rows up to which each has a dot
_BAND = 0.25  # mean height of a stretch, by the picture's, above which a line looks like a band
_MANY = 120  # crossings of the middle from which on a line is a band
_DETAIL = 0.24  # part of the width that shows the last rows of a band
_TURNS, _FEWEST, _LOOKED_AT = 6, 30, 20_000  # turns of a signal that are shown, fewest rows, rows that are looked at
_STRETCHES = 1500  # of a long trace, each drawn by its lowest and highest row
_WIDTH, _PANEL, _LEFT, _RIGHT, _TOP = 9.0, 1.7, 1.25, 0.2, 0.55  # inches


def plot_traces(result: Result) -> "Figure":
    """A figure with one panel per probe: signals against time, the last row of a vector against its entries.

    A long trace is drawn by the lowest and the highest row of each of its stretches, so that no
    spike is lost.
    """
    traces = sorted(result.traces.values(), key=lambda trace: trace.values.ndim > 1)[:MOST_PANELS]
    return _figure(traces, _title(result, len(traces)), partial(_held, result))


def plot_trace(trace: Trace) -> "Figure":
    """Return a figure of one signal against time, or of the last row of a vector."""
    return _figure([trace], "", lambda trace: trace.values.dtype.kind in "iub")


def _figure(traces: Sequence[Trace], title: str, held: Callable[[Trace], bool]) -> "Figure":
    signals = [trace for trace in traces if trace.values.ndim == 1]
    lowest = len(signals) - 1  # the panel that names the time axis which all signals share
    seconds = prefix("s", max((float(t.period) * len(t.values) for t in signals), default=0.0))
    stretches = min(_STRETCHES, max(100, 16_000 // max(1, len(traces))))
    bands = {i for i, trace in enumerate(signals) if _band(trace.values, stretches)}
    height = _TOP + sum(_PANEL + _gap(i >= lowest) for i in range(len(traces)))
    with sheet(_WIDTH, height, layout=None) as figure:
        figure.text(0.5, 1.0 - 0.12 / height, literal(title), size=12, weight="bold", ha="center", va="top")
        top, shared = _TOP, None
        for i, trace in enumerate(traces):
            bottom, tall = 1.0 - (top + _PANEL) / height, _PANEL / height
            whole = 1.0 - (_LEFT + _RIGHT) / _WIDTH
            wide = whole * (1.0 - _DETAIL) if bands and i <= lowest else whole
            shares = shared if i <= lowest else None
            panel = figure.add_axes((_LEFT / _WIDTH, bottom, wide, tall), facecolor="none", sharex=shares)
            detail = None
            if i in bands:
                end = (_LEFT / _WIDTH + wide + 0.02, bottom, whole * _DETAIL - 0.02, tall)
                detail = figure.add_axes(end, facecolor="none")
            _draw(panel, trace, held(trace), seconds, stretches, detail)
            if i <= lowest:
                shared = shared or panel
                panel.margins(x=0.01)
                panel.tick_params(labelbottom=i == lowest)
            if i == lowest:
                panel.set_xlabel(f"time [{seconds[1]}]")
            top += _PANEL + _gap(i >= lowest)
    return figure


def save_plot(result: Result, path: str | Path) -> Path:
    """Write the plot; it ends in .svg, .png or .pdf. Raises `ValueError` for another ending."""
    return save_figure(plot_traces(result), path)


def offset(lowest: float, highest: float) -> float:
    """Return a round number to subtract from a signal that moves by less than a thousandth of its size, else 0.

    >>> offset(2.5, 2.50005)
    2.5
    """
    size, span = max(abs(lowest), abs(highest)), highest - lowest
    if not 1e-12 * size < span < 1e-3 * size < math.inf:
        return 0.0
    digits = -math.floor(math.log10(size))
    while abs(round(lowest, digits) - lowest) > span:
        digits += 1
    return round(lowest, digits)


def envelope(values: AnyArray, stretches: int) -> AnyArray:
    """Return the rows that a drawing needs: the lowest and highest of each stretch, and both ends, in order."""
    rows = len(values)
    if rows <= 2 * stretches:
        return np.arange(rows)
    length = -(-rows // stretches)
    places = [np.array([0, rows - 1])]
    for first, last in pieces(-(-rows // length), length):
        piece = np.asarray(values[first * length : last * length])
        whole = len(piece) // length
        grid = piece[: whole * length].reshape(whole, length)
        starts = (first + np.arange(whole)) * length
        places += [starts + grid.argmin(axis=1), starts + grid.argmax(axis=1)]
        if rest := piece[whole * length :].tolist():
            start = (first + whole) * length
            places.append(np.array([start + rest.index(min(rest)), start + rest.index(max(rest))]))
    return np.unique(np.concatenate(places))


def _draw(
    panel: "Axes",
    trace: Trace,
    steps: bool,
    seconds: tuple[float, str],
    stretches: int,
    detail: "Axes | None" = None,
) -> None:
    if not len(trace.values):
        panel.text(0.5, 0.5, "no rows", transform=panel.transAxes, ha="center")
        _name(panel, trace, pretty(trace.shown_in or trace.unit))
        return
    if trace.values.ndim > 1:
        _draw_vector(panel, trace)
        return
    rows = envelope(trace.values, stretches)
    values = np.asarray(trace.values[rows], dtype=np.float64)
    away = offset(float(values.min()), float(values.max()))
    values = values - away
    factor, unit = display(trace.unit, trace.shown_in, float(np.abs(values).max()))
    times, values = rows * float(trace.period) * seconds[0], values * factor
    if band := _band(trace.values, stretches):
        starts, *places = _edges(trace.values, band)
        at = np.append(starts, len(trace.values)) * float(trace.period) * seconds[0]
        sides = [(np.asarray(trace.values[rows], dtype=np.float64) - away) * factor for rows in places]
        low, high = (np.append(side, side[-1]) for side in sides)
        panel.fill_between(at, low, high, step="post", color=BLUE, alpha=0.3, linewidth=0.0)
        for edge in (low, high):
            panel.plot(at, edge, color=BLUE, linewidth=0.8, drawstyle="steps-post")
    elif len(trace.values) <= _FEW and steps:
        times = np.append(times, len(trace.values) * float(trace.period) * seconds[0])
        panel.plot(times, np.append(values, values[-1]), color=BLUE, drawstyle="steps-post")
    else:
        panel.plot(times, values, color=BLUE, marker="." if len(values) <= _DOTTED else "", markersize=4)
    if trace.values.dtype == bool:
        panel.set_yticks([0, 1], ["false", "true"])
        panel.set_ylim(-0.15, 1.15)
    number = f"{away * (factor if trace.shown_in else 1.0):.12g}"
    _name(panel, trace, unit, f"− {number} {in_table(trace.shown_in or trace.unit)}".strip() if away else "")
    if band and detail is not None:
        _draw_end(detail, trace, away, factor)
        detail.set_ylim(panel.get_ylim())


def _band(values: AnyArray, stretches: int) -> int:
    """Return in how many stretches a signal is drawn by its envelope, because a line of it would be a band; or 0."""
    if len(values) <= 2 * stretches or values.dtype == bool:
        return 0
    line = np.asarray(values[envelope(values, stretches)], dtype=np.float64)
    above = line > np.median(line)
    crossings = int(np.count_nonzero(above[1:] != above[:-1]))
    if _MANY < crossings < stretches:  # periods of several stretches
        return max(_FEWEST, crossings // 4)
    _, low, high = _edges(values, stretches)
    low, high = np.asarray(values[low], dtype=np.float64), np.asarray(values[high], dtype=np.float64)
    span = float(high.max() - low.min())
    wide = span > 0.0 and float(np.mean(high - low)) > _BAND * span
    return stretches // 2 if wide else 0  # a step has two corners


def _edges(values: AnyArray, stretches: int) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return the first row of each stretch, and the places of its lowest and its highest value."""
    length = -(-len(values) // stretches)
    starts = np.arange(0, len(values), length)
    low = np.array([first + int(np.argmin(values[first : first + length])) for first in starts])
    high = np.array([first + int(np.argmax(values[first : first + length])) for first in starts])
    return starts, low, high


def _draw_end(panel: "Axes", trace: Trace, away: float, factor: float) -> None:
    """Draw the last rows of a signal, some turns of it, beside all of it."""
    last = np.asarray(trace.values[-_LOOKED_AT:], dtype=np.float64)
    above = last > last.mean()
    turns = max(1, int(np.count_nonzero(above[1:] != above[:-1]) // 2))
    rows = min(len(last), max(_FEWEST, _TURNS * len(last) // turns))
    values = (last[-rows:] - away) * factor
    length, unit = prefix("s", rows * float(trace.period))
    times = (np.arange(rows) - rows + 1) * float(trace.period) * length
    panel.plot(times, values, color=BLUE, marker="." if rows <= _DOTTED else "", markersize=4)
    panel.tick_params(labelleft=False)
    panel.margins(x=0.02)
    panel.set_xlabel(f"the last {rows * float(trace.period) * length:.3g} {unit}", fontsize=9)
    panel.set_xticks([])


def _draw_vector(panel: "Axes", trace: Trace) -> None:
    """Draw the last row as stems, with mean and spread of the rows from the first one that is not all zero."""
    # start-up time: matplotlib takes 0.3 s, and most callers draw nothing
    from matplotlib.ticker import MaxNLocator

    last = np.asarray(trace.values[-1], dtype=np.float64).ravel()
    first = _first_not_zero(trace.values)
    spread = statistics(trace.values[first:].reshape(len(trace.values) - first, -1))
    largest = float(max(np.abs(spread.lowest).max(), np.abs(spread.highest).max()))
    factor, unit = display(trace.unit, trace.shown_in, largest)
    entries = np.arange(len(last))
    panel.axhline(0.0, color=INK, linewidth=0.8)
    if len(last) <= 128:
        panel.vlines(entries, 0.0, last * factor, color=BLUE, linewidth=1.5)
        panel.plot(entries, last * factor, color=BLUE, marker="o", markersize=5, linestyle="", label="last row")
    else:
        panel.plot(entries, last * factor, color=BLUE, label="last row")
    rows = len(trace.values) - first
    if rows > 1:
        panel.errorbar(
            entries + (0.2 if len(last) <= 128 else 0.0),
            spread.mean * factor,
            spread.std * factor,
            color=ORANGE,
            linestyle="",
            marker="_",
            markersize=7,
            capsize=2.5,
            errorevery=max(1, len(last) // 64),
            markevery=max(1, len(last) // 64),
            label=f"mean ± std of {rows:,} rows",
        )
    panel.xaxis.set_major_locator(MaxNLocator(integer=True))
    panel.set_xlabel("entry, counted from 0" if "lag" not in trace.doc.lower() else "lag")
    panel.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.16), borderpad=0.0)
    _name(panel, trace, unit)


def _first_not_zero(values: AnyArray) -> int:
    for first, last in pieces(len(values), values[0].size):
        filled = np.asarray(values[first:last]).reshape(last - first, -1).any(axis=1)
        if filled.any():
            return first + int(filled.argmax())
    return 0


def _held(result: Result, trace: Trace) -> bool:
    """Return whether a signal holds its value between ticks: discrete numbers, codes and bits."""
    block = flatten(result.graph).blocks.get(split(inside(result.graph, trace.signal))[0])
    return holds(block, trace.values.dtype.kind in "iub")


def holds(block: Block | None, integer: bool) -> bool:
    """Return whether an output holds its value between ticks: of integers and bits, and of a discrete block."""
    return integer or (block is not None and "update" in type(block).functions)


def _name(panel: "Axes", trace: Trace, unit: str, less: str = "") -> None:
    """Write name and unit at the axis; a long name above the panel."""
    name = trace.signal if len(trace.signal) <= 22 or less else trace.signal.replace(".", ".\n", 1)
    bracket = "" if unit == "1" else f" [{unit}]"
    label = name + ("\n" + less if less else "") + bracket
    if max(map(len, label.split("\n"))) > 26:
        panel.set_title(trace.signal, fontsize=9, pad=3)
        label = less + bracket
    panel.set_ylabel(literal(label.strip()), fontsize=9)
    panel.yaxis.set_label_coords(-0.92 / (panel.get_position().width * _WIDTH), 0.5)


def _gap(labelled: bool) -> float:
    return 0.75 if labelled else 0.28


def _title(result: Result, drawn: int) -> str:
    interrupted = " (interrupted)" if result.interrupted else ""
    left_out = f" (the first {drawn} of {len(result.traces)} probes)" if drawn < len(result.traces) else ""
    return (result.graph.name + interrupted + left_out) if result.traces else "no probes"
