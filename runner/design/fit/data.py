"""Readings of output and temperature for a fit: from a table, or from a run of a graph."""

import re
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import Problem, did_you_mean, shown
from proofmass.graphs.model.graph import Graph, Probe
from proofmass.runner.analysis.spectrum.series import refused_scatter
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.recording import Column, RecordingError, read_columns
from proofmass.runner.run.simulate import simulate

FEWEST_TEMPERATURES = 5  # one more than the coefficients of two exponentials
LARGEST = 1e15
SMALLEST_SPAN = 1e-9  # of the temperatures, against the largest
_TEMPERATURE = re.compile("temp|therm", re.IGNORECASE)


@dataclass(frozen=True)
class Readings:
    """Measured readings, one in each row, in the order of time if there is one."""

    source: str
    temperature: AnyArray
    output: AnyArray
    temperature_name: str
    output_name: str
    temperature_unit: str = ""  # empty if the source has none
    output_unit: str = ""

    def __post_init__(self) -> None:
        problem = self._problem()
        if problem:
            raise replace(problem, file=self.source).error

    def less(self, offset: float) -> "Readings":
        """Return the readings with a constant subtracted from the output."""
        return replace(self, output=self.output - offset)

    def _problem(self) -> Problem | None:
        t, v = self.temperature, self.output
        if not (np.isfinite(t).all() and np.isfinite(v).all() and max(np.abs(t).max(), np.abs(v).max()) <= LARGEST):
            return Problem(message=f"must be finite numbers of at most {LARGEST:g}")
        different = len(np.unique(t))
        if different < FEWEST_TEMPERATURES:
            message, got = "there are too few different temperatures to fit", f"{different} in {len(t)} rows"
            expected = f"at least {FEWEST_TEMPERATURES}: two exponentials have 4 coefficients"
            return Problem(message=message, key=self.temperature_name, got=got, expected=expected)
        if np.ptp(t) < SMALLEST_SPAN * np.abs(t).max():
            got, hint = f"{np.ptp(t):g} about {t.mean():g}", "subtract a constant from the temperatures"
            return Problem(message="hardly moves", key=self.temperature_name, got=got, hint=hint)
        if np.ptp(v) == 0.0:
            message = "is the same in every row: there is nothing to fit"
            return Problem(message=message, key=self.output_name, got=f"{v[0]:g}")
        return refused_scatter(v, self.output_name)


def read_table(path: Path, temperature: str = "", output: str = "") -> Readings:
    """Return the readings of a CSV, Parquet or netCDF file.

    Without names, the file must have two columns besides time: first temperature, then output.
    Raises `ModelError` with file and line.
    """
    try:
        columns = read_columns(path, lambda names: _choose(names, temperature, output))
        values = [np.asarray(column.values) for column in columns]
    except RecordingError as error:
        raise Problem(message=str(error), file=str(path), line=error.line, hint=error.hint).error from None
    return _readings(path.name, columns, values)


def run_cycle(graph: Graph, temperature: str, output: str, **options: Any) -> Readings:
    """Return readings from a run of a graph, such as a temperature cycle; options are those of `simulate`."""
    probed = graph.changed(probes=tuple(Probe(s) for s in dict.fromkeys((temperature, output))))
    result = simulate(probed, **options)
    traces = (result[temperature], result[output])
    wrong: Mapping[str, bool] = {
        "is not a signal of single numbers": any(trace.values.ndim > 1 for trace in traces),
        "has another rate than the temperature": traces[0].stride != traces[1].stride,
        "has another clock offset than the temperature": traces[0].phase != traces[1].phase,
    }
    for message, found in wrong.items():
        if found:
            raise Problem(message=message, file=graph.place.file, key=output).error
    columns = [Column(trace.signal, trace.unit, array("d")) for trace in traces]
    return _readings(graph.name, columns, [np.asarray(trace.values, dtype=np.float64) for trace in traces])


def _readings(source: str, columns: Sequence[Column], values: Sequence[AnyArray]) -> Readings:
    (t, v), (temperature, output) = values, columns
    return Readings(source, t, v, temperature.name, output.name, temperature.unit, output.unit)


def _choose(names: Sequence[str], temperature: str, output: str) -> tuple[int, int]:
    for wanted in filter(None, (temperature, output)):
        if wanted not in names:
            raise RecordingError(f"there is no column {shown(wanted)}", hint=did_you_mean(wanted, names, "its columns"))
    if temperature and temperature == output:
        raise RecordingError(f"column {temperature} cannot be both temperature and output")
    free = [name for name in names if name not in (temperature, output) and name.lower() != "time"]
    missing = [not temperature, not output].count(True)
    if missing and len(free) != missing:
        hint = f"say --temperature and --output; the columns: {', '.join(names)}"
        raise RecordingError("it is not clear which two of its columns are meant", hint=hint)
    first = temperature or free.pop(0)
    second = output or free.pop(0)
    if missing and _TEMPERATURE.search(second) and not _TEMPERATURE.search(first):
        hint = f"for the other order say --temperature {shown(second)} --output {shown(first)}"
        raise RecordingError(f"its columns look swapped: {first} as temperature, {second} as output", hint=hint)
    return names.index(first), names.index(second)
