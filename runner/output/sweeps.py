"""A sweep as a table for the terminal, as CSV, and as curves of measures against the parameter that is swept."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.shown_units import display
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert_exactly, split_quantity
from proofmass.runner.output.export import whole_csv
from proofmass.runner.output.pictures import BLUE, axis_label, literal, sheet
from proofmass.runner.output.text_table import text_table
from proofmass.runner.run.sweep import Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def sweep_lines(sweep: Sweep, measures: Sequence[str]) -> list[str]:
    """Return a line for each point: the values of the parameters, then the measures."""
    scales = {name: _scale(sweep, name) for name in measures}
    head = [*sweep.columns.values(), *(_named(name, unit) for name, (_, unit) in scales.items())]
    rows = [
        [_text(value * scales[name][0] if name in scales else value) for name, value in row.items()]
        for row in sweep.rows(measures)
    ]
    return text_table([head, *rows], left=())


def save_sweep_csv(sweep: Sweep, measures: Sequence[str], path: Path) -> Path:
    """Write the table as CSV, numbers as they read back."""
    head = [*sweep.columns.values(), *(f"{name} [{sweep.measures[name]}]" for name in measures)]
    with whole_csv(path) as table:
        table.writerows([head, *(row.values() for row in sweep.rows(measures))])
    return path


def plot_sweep(sweep: Sweep, measures: Sequence[str]) -> "Figure":
    """Draw a panel for each measure against the first parameter, a curve for each combination of the others."""
    title = f"{sweep.results[0].graph.name}: {len(sweep.results)} points"
    with sheet(7.0, 0.8 + 2.2 * len(measures), title) as figure:
        panels = figure.subplots(len(measures), 1, sharex=True, squeeze=False)[:, 0]
        name, (places, unit) = next(iter(sweep.values)), axis_of(next(iter(sweep.values.values())))
        for panel, measure in zip(panels, measures, strict=True):
            factor, unit_of_measure = _scale(sweep, measure)
            for label, curve in _curves(sweep, measure):
                color = None if label else BLUE
                panel.plot(places, factor * curve, "o-", markersize=4.0, label=label, color=color)
            panel.set_ylabel(axis_label(measure, unit_of_measure))
        panels[-1].set_xlabel(axis_label(name, unit))
        name_places(panels[-1], places, next(iter(sweep.values.values())), unit)
        if len(sweep.shape) > 1 and math.prod(sweep.shape[1:]) <= 12:
            panels[0].legend(fontsize="small")
    return figure


def axis_of(values: Sequence[object]) -> tuple[list[float], str]:
    """Return where values stand on an axis, and its unit: that of the first; in a row if they are not quantities.

    >>> axis_of(["1 kHz", "500 Hz"]), axis_of(["held", "continuous"])
    (([1.0, 0.5], 'kHz'), ([0.0, 1.0], ''))
    """
    if all(isinstance(value, int | float) for value in values):
        return [float(value) for value in values if isinstance(value, int | float)], ""
    try:
        unit = split_quantity(str(values[0]))[1]
        return [float(convert_exactly(str(value), unit or "1")) for value in values], unit
    except (UnitError, OverflowError):
        return [float(place) for place in range(len(values))], ""


def name_places(panel: "Axes", places: Sequence[float], values: Sequence[object], unit: str) -> None:
    """Write values that are not quantities at their places on the axis."""
    if not unit and not all(isinstance(value, int | float) for value in values):
        panel.set_xticks(places, [literal(str(value)) for value in values])


def _scale(sweep: Sweep, measure: str) -> tuple[float, str]:
    """Return the factor and the unit of a measure for people: those that the graph asks for, such as deg/h."""
    own, asked = sweep.measures[measure], sweep.results[0].measures[measure].shown_in
    return (display(own, asked, 1.0)[0], asked) if asked else (1.0, own)


def _curves(sweep: Sweep, measure: str) -> Iterator[tuple[str, Any]]:
    grid = sweep[measure].reshape(sweep.shape[0], -1)
    if sweep.zipped or grid.shape[1] == 1:
        yield "", grid[:, 0]
        return
    others = dict(list(sweep.values.items())[1:])
    sizes = [len(values) for values in others.values()]
    for column in range(grid.shape[1]):
        places = np.unravel_index(column, sizes)
        named = zip(others.items(), places, strict=True)
        yield ", ".join(f"{name} = {values[place]}" for (name, values), place in named), grid[:, column]


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def _text(value: object) -> str:
    """Return a value for people: "undefined" for a measure without one."""
    return str(value) if not isinstance(value, float) else "undefined" if math.isnan(value) else f"{value:.9g}"
