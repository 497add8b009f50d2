"""The labelled outcome of a run: traces with units and times, and what they were made with."""

import hashlib
import math
from collections.abc import ItemsView, Iterator, KeysView, Mapping, ValuesView
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.blocks.declaration.shown_units import display
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph, Probe
from proofmass.runner.host.arrays import AnyArray, read_only
from proofmass.runner.host.notebook import Plotted, html_table
from proofmass.runner.plan.measuring import Measured
from proofmass.runner.plan.memory import Memory
from proofmass.runner.run.sparkline import sparkline

if TYPE_CHECKING:
    import pandas
    import xarray


EXACT_BITS = 53  # of an integer that a float holds
PIECE = 1 << 20  # numbers of a long trace that are looked at together


class Statistics(NamedTuple):
    """Over the rows of a trace, one number per entry of a row; the standard deviation with n - 1, zero of one row."""

    mean: AnyArray
    std: AnyArray
    lowest: AnyArray
    highest: AnyArray


def pieces(rows: int, entries: int = 1) -> Iterator[tuple[int, int]]:
    """First row and the row after the last of each piece of a long trace: a mapped file is never in memory whole."""
    step = max(1, PIECE // max(1, entries))
    for first in range(0, rows, step):
        yield first, min(first + step, rows)


def statistics(values: AnyArray) -> Statistics:
    """Mean, standard deviation and extremes over the rows, read once, piece by piece; twice where squares overflow."""
    found = _scaled_statistics(values, 1.0)
    largest = max(float(np.abs(found.lowest).max()), float(np.abs(found.highest).max()))
    if np.isfinite(found.std).all() or not math.isfinite(largest):
        return found
    scale = math.ldexp(1.0, math.frexp(largest)[1] - 1)
    with np.errstate(over="ignore"):
        return Statistics(*(scale * each for each in _scaled_statistics(values, 1.0 / scale)))


def _scaled_statistics(values: AnyArray, scale: float) -> Statistics:
    """Statistics of the values times a power of two."""
    count, entries = 0, values[0].size
    mean = squares = np.zeros(())
    lowest = highest = scale * np.asarray(values[0], dtype=np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        for first, last in pieces(len(values), entries):
            piece = scale * np.asarray(values[first:last], dtype=np.float64)
            middle = piece.mean(axis=0)
            step, total = middle - mean, count + len(piece)
            squares = squares + ((piece - middle) ** 2).sum(axis=0) + step**2 * (count * len(piece) / total)
            mean = mean + step * (len(piece) / total)
            lowest, highest = np.minimum(lowest, piece.min(axis=0)), np.maximum(highest, piece.max(axis=0))
            count = total
        return Statistics(mean, np.sqrt(squares / max(count - 1, 1)), lowest, highest)


_MEANT = {"data": "values", "array": "values", "y": "values", "time": "times", "t": "times", "x": "times"}


@dataclass(frozen=True, eq=False)
class Trace(NDArrayOperatorsMixin, Plotted):
    """Recording of one probe: a row per tick, the first at t = 0 or its block's clock offset.

    Arithmetic with it gives arrays of its values, as in `2 * trace` or `trace == 0`.

    >>> from proofmass import read_graph, simulate
    >>> trace = simulate(read_graph("library:template"), duration="1 ms")["sensor.displacement"]
    >>> trace.unit, trace.values.shape, float(trace.times[-1])
    ('m', (11,), 0.001)
    """

    signal: str  # its name, "block.port"
    unit: str  # of the values, such as "m"
    doc: str  # the sentence that the port has
    stride: int  # base ticks from row to row
    base_rate: Fraction  # Hz, of the graph
    values: AnyArray  # in the unit, read-only; of a fixed-point signal exact up to 53 bits
    format: Fixed | None = None  # of a fixed-point signal
    phase: int = 0  # base tick of the first row
    shown_in: str = ""  # unit of tables and pictures, such as "deg/h", where its probe says one

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", read_only(self.values))

    @property
    def facts(self) -> dict[str, str]:
        """Unit, doc and format as attributes of a variable in a file."""
        known = {"units": self.unit, "long_name": self.doc}
        return known if self.format is None else known | {"fixed_point": str(self.format)}

    @property
    def mantissas(self) -> AnyArray:
        """The integers that the register of a fixed-point signal held; raises ValueError for any other signal."""
        if self.format is None or self.format.width > EXACT_BITS:
            raise ValueError(f"{self.signal} is not a fixed-point signal of up to {EXACT_BITS} bits")
        return np.ldexp(self.values, self.format.fraction).astype(np.int64)

    @property
    def period(self) -> Fraction:
        """Seconds from row to row."""
        return self.stride / self.base_rate

    @property
    def times(self) -> AnyArray:
        """Time of each row in seconds: its tick over the base rate, rounded once, not summed."""
        return self.times_of(0, len(self.values))

    def times_of(self, first: int, last: int) -> AnyArray:
        """Time of the rows from `first` up to, not including, `last`."""
        ticks, rate = self.stride * self.base_rate.denominator, self.base_rate.numerator
        late = self.phase * self.base_rate.denominator
        if max(last * ticks + late, rate) <= 1 << EXACT_BITS:
            return (np.arange(first, last, dtype=np.int64) * ticks + late) / rate
        return np.array([float(Fraction(row * ticks + late, rate)) for row in range(first, last)])

    @property
    def entries(self) -> int:
        """Numbers in a row: 1 for a scalar."""
        return int(np.prod(self.values.shape[1:]))

    @cached_property
    def statistics(self) -> Statistics | None:
        """Mean, standard deviation and extremes over the rows; None without rows."""
        return statistics(self.values) if len(self.values) else None

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the values, row by row in little-endian order; every NaN is the same."""
        digest = hashlib.sha256()
        for first, last in pieces(len(self.values), self.entries):
            digest.update(_bytes(self.values[first:last]))
        return digest.hexdigest()

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        return f"{self.signal} [{self.unit}]"

    def __len__(self) -> int:
        """Rows."""
        return len(self.values)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> AnyArray:
        """Return the values, for NumPy and what builds on it."""
        return np.array(self.values, dtype=dtype, copy=copy) if copy else np.asarray(self.values, dtype=dtype)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        """Return what a function of NumPy makes of the values."""
        values = [one.values if isinstance(one, Trace) else one for one in inputs]
        if any(isinstance(one, Trace) for one in options.get("out", ())):
            raise ValueError("the values of a trace cannot be changed; numpy.array(trace) is a copy that can")
        return getattr(ufunc, method)(*values, **options)

    def __repr__(self) -> str:
        """Signal, unit, rows and range, in a line."""
        if self.statistics is None:
            return f"<Trace of {self.label}: no rows>"
        low, high = float(self.statistics.lowest.min()), float(self.statistics.highest.max())
        return f"<Trace of {self.label}: {len(self):,} rows every {float(self.period):g} s, {low:.6g} to {high:.6g}>"

    def to_pandas(self) -> "pandas.Series | pandas.DataFrame":
        """Return the values over time in seconds: a Series, or of a vector a DataFrame with a column for each entry."""
        need("pandas")
        # start-up time: pandas takes 0.5 s
        import pandas

        index = pandas.Index(self.times, name="time [s]")
        if self.values.ndim == 1:
            return pandas.Series(np.asarray(self.values), index, name=self.label)
        columns = [f"{self.signal}[{entry}] [{self.unit}]" for entry in range(self.entries)]
        return pandas.DataFrame(np.asarray(self.values).reshape(len(self), -1), index, columns)

    def _repr_html_(self) -> str:
        return f"{sparkline(self.values)} {escape(repr(self)[1:-1])}"

    def __getitem__(self, rows: Any) -> Any:
        """Return values, in their unit, by the numbers of rows, as `trace[-1]` or `trace[100:]`."""
        return self.values[rows]

    def _instead(self, name: str) -> str:
        of_array = name != "data" and hasattr(np.ndarray, name)
        return f"its array has: trace.values.{name}" if of_array else super()._instead(_MEANT.get(name, name))


class NoSuchSignal(KeyError):  # noqa: N818  # what it says
    """A signal that a run did not record, and which it did."""

    def __str__(self) -> str:
        """The signal and a cure, without the quotes that a KeyError puts around them."""
        hint, signal = self.args
        return f"{signal!r} was not recorded; {hint}"


@dataclass(frozen=True, eq=False, repr=False)
class Result(Plotted):
    """A finished or interrupted run; `result["block.port"]` is a trace.

    >>> from proofmass import read_graph, simulate
    >>> result = simulate(read_graph("library:template"), duration="1 ms")
    >>> result.ticks, result.interrupted, list(result)
    (11, False, ['sensor.displacement', 'adc.code'])
    >>> result.to_xarray()["adc.code"].shape
    (11,)
    """

    graph: Graph  # that ran
    traces: Mapping[str, Trace]  # by "block.port"
    ticks: int  # base ticks that are done
    planned_ticks: int  # base ticks that were asked for
    base_rate: Fraction  # Hz
    seed: int  # of all noise
    seconds: float  # wall time of the loop
    preparation: float  # wall time before it, and in it for machine code: plan, compilation
    provenance: Mapping[str, str] = field(default_factory=dict)  # graph, versions, machine and date
    overflows: Mapping[str, int] = field(default_factory=dict)  # of blocks in fixed point: ticks with an overflow
    overflow_ticks: Mapping[str, int] = field(default_factory=dict)  # of the blocks
    memory: Memory | None = None  # of an interrupted run, to go on from
    measures: Mapping[str, Measured] = field(default_factory=dict)  # each with value and unit

    def __getitem__(self, signal: str | Probe) -> Trace:
        name = signal.signal if isinstance(signal, Probe) else signal
        if name not in self.traces:
            raise NoSuchSignal(did_you_mean(str(name), self.traces, "the probes"), name)
        return self.traces[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.traces)

    def __contains__(self, signal: object) -> bool:
        return signal in self.traces

    def _instead(self, name: str) -> str:
        trace, meant = next(iter(self.traces.values()), None), _MEANT.get(name, name)
        if meant in ("save", "write", "export") or meant.startswith("to_"):
            return 'as a table: result.to_pandas().to_csv("run.csv")'
        if trace is not None and hasattr(trace, meant):
            return f'a trace has: result["{trace.signal}"].{meant}'
        return super()._instead(meant)

    def keys(self) -> KeysView[str]:
        """Return the signals that were recorded."""
        return self.traces.keys()

    def values(self) -> ValuesView[Trace]:
        """Return the traces."""
        return self.traces.values()

    def items(self) -> ItemsView[str, Trace]:
        """Return the signals with their traces."""
        return self.traces.items()

    def __repr__(self) -> str:
        """Graph, ticks and signals, in a line."""
        done = f"{self.ticks:,} of {self.planned_ticks:,} ticks" if self.interrupted else f"{self.ticks:,} ticks"
        return f"<Result of {self.graph.name}: {done}; {', '.join((*self.traces, *self.measures)) or 'no probes'}>"

    @property
    def interrupted(self) -> bool:
        """True if the run ended before its last tick."""
        return self.ticks < self.planned_ticks

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the names, types, shapes and values of all traces: equal if all bits are."""
        lines = (
            f"{name} {trace.values.dtype.name} {' '.join(map(str, trace.values.shape))} {trace.digest}\n"
            for name, trace in sorted(self.traces.items())
        )
        return hashlib.sha256("".join(lines).encode()).hexdigest()

    def attributes(self) -> dict[str, str]:
        """Graph, seed and provenance as text, for the files."""
        return {
            "graph": self.graph.name,
            "graph_toml": write_graph(self.graph),
            "seed": str(self.seed),
            "ticks": str(self.ticks),
            "base_rate": f"{self.base_rate} Hz",
            **{f"measure_{name}": f"{m.value!r} {m.unit}" for name, m in self.measures.items()},
            **self.provenance,
        }

    def to_xarray(self) -> "xarray.Dataset":
        """A Dataset with one variable per probe, in its unit; one rate, one time axis."""
        need("xarray")
        # start-up time: xarray takes 0.4 s
        import xarray

        axes = self.axes()
        coordinates: dict[str, Any] = {}
        variables: dict[str, Any] = {}
        for dimension, traces in axes.items():
            coordinates[dimension] = (dimension, traces[0].times, {"units": "s", "long_name": "time"})
            for trace in traces:
                extra = [f"{trace.signal}_entry{i or ''}" for i in range(trace.values.ndim - 1)]
                variables[trace.signal] = ([dimension, *extra], trace.values, trace.facts)
        return xarray.Dataset(variables, coordinates, self.attributes())

    def axes(self) -> dict[str, list[Trace]]:
        """Traces by time axis: "time" for the fastest, "time_2", ... for the others."""
        by_axis: dict[tuple[Fraction, int, int], list[Trace]] = {}
        for trace in self.traces.values():
            by_axis.setdefault((trace.period, -len(trace.values), trace.phase), []).append(trace)
        ordered = sorted(by_axis.items(), key=lambda item: item[0])
        return {"time" if i == 0 else f"time_{i + 1}": traces for i, (_, traces) in enumerate(ordered)}

    def summary(self) -> list[dict[str, Any]]:
        """Per probe: rows, mean, standard deviation, extremes, last value; of a vector over all its entries."""
        rows = []
        for trace in self.traces.values():
            row: dict[str, Any] = {"signal": trace.signal, "unit": trace.unit, "rows": len(trace.values)}
            if trace.values.ndim > 1:
                row["entries"] = trace.entries
            if numbers := trace.statistics:
                mean, std = _of_all_entries(numbers, len(trace.values))
                row |= {
                    "mean": mean,
                    "std": std,
                    "min": float(numbers.lowest.min()),
                    "max": float(numbers.highest.max()),
                    "last": trace.values[-1].tolist(),
                }
            rows.append(row)
        return rows

    def to_pandas(self) -> "pandas.DataFrame":
        """Return all traces over time in seconds, a column each; where a slower one has no row stands NaN."""
        need("pandas")
        # start-up time: pandas takes 0.5 s
        import pandas

        if not self.traces:
            return pandas.DataFrame()
        tables = [(trace.to_pandas(), trace.values) for trace in self.traces.values()]
        whole = (table.astype("Int64") if _beyond_floats(values) else table for table, values in tables)
        return pandas.concat(list(whole), axis=1).sort_index()

    def _repr_html_(self) -> str:
        heads = ("signal", "unit", "rows", "mean", "std", "min", "max", "")
        below = [f"{name} = {measure.text()}" for name, measure in self.measures.items()]
        rows = ((*texts, sparkline(self[texts[0]].values)) for *texts, _ in self.shown_rows())
        return html_table(heads, rows, repr(self)[1:-1], below)

    def shown_rows(self) -> Iterator[tuple[str, ...]]:
        """Yield name, unit, rows, mean, std, min, max and last value of each signal as texts, in a unit that suits."""
        for row in self.summary():
            trace = self[row["signal"]]
            factor, unit = display(trace.unit, trace.shown_in, max(abs(row.get("min", 0.0)), abs(row.get("max", 0.0))))
            numbers = [f"{row[key] * factor:.6g}" if key in row else "" for key in ("mean", "std", "min", "max")]
            last = row.get("last", "")
            text = f"[{len(last)} entries]" if isinstance(last, list) else f"{last * factor:.6g}" if last != "" else ""
            yield trace.signal, "" if unit == "1" else unit, f"{row['rows']:,}", *numbers, text


def _beyond_floats(values: AnyArray) -> bool:
    """Return whether floats, as a column with NaN has them, would round some of the integers."""
    if values.dtype.kind != "i" or not values.size:
        return False
    return max(int(values.max()), -int(values.min())) > 1 << EXACT_BITS


def _bytes(values: AnyArray) -> bytes:
    """Values as they are hashed."""
    if values.dtype == np.float64:
        values = np.where(np.isnan(values), np.nan, values)
    return values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()


def _of_all_entries(entries: Statistics, rows: int) -> tuple[float, float]:
    """Mean and standard deviation, with n - 1, of a vector over its rows and entries together."""
    if entries.mean.size == 1:
        return float(entries.mean.mean()), float(entries.std.mean())
    with np.errstate(over="ignore", invalid="ignore"):
        mean = entries.mean.mean()
        squares = (rows - 1) * entries.std**2 + rows * (entries.mean - mean) ** 2
        return float(mean), float(np.sqrt(squares.sum() / max(rows * entries.mean.size - 1, 1)))
