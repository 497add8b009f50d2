"""A graph run once at each point of a sweep: every combination of values of its parameters, or the values in step."""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.engines import choose
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunOptions, simulate_plan, ticks_of

if TYPE_CHECKING:
    import xarray

MOST_POINTS = 100_000


@dataclass(frozen=True, eq=False)
class Sweep:
    """The results of a sweep, a point each; `sweep["bias"]` is an array of a measure over the grid of values.

    `values` has the values of each parameter as they were given; the last parameter moves fastest.
    In a zipped sweep all move together, and there is one dimension.

    >>> from proofmass import read_graph, sweep
    >>> result = sweep(read_graph("library:template"), {"adc.bits": [10, 12], "sensor.mass": ["1 ug"]}, duration="1 ms")
    >>> result.shape, list(result.points())[1]
    ((2, 1), {'adc.bits': 12, 'sensor.mass': '1 ug'})
    """

    values: Mapping[str, tuple[object, ...]]  # by parameter
    zipped: bool  # True if all move together
    results: tuple[Result, ...]  # in the order of `points`

    @property
    def shape(self) -> tuple[int, ...]:
        """Points along each dimension."""
        sizes = [len(values) for values in self.values.values()]
        return tuple(sizes[:1] if self.zipped else sizes)

    @property
    def measures(self) -> dict[str, str]:
        """Measures and their units."""
        return {name: measured.unit for name, measured in self.results[0].measures.items()}

    @property
    def columns(self) -> dict[str, str]:
        """Columns of the parameters; one that has the name of a measure is `parameter.bias`, as in studies."""
        return {name: f"parameter.{name}" if name in self.measures else name for name in self.values}

    def points(self) -> Iterator[dict[str, object]]:
        """Yield the values at each point, in the order of the results."""
        return points(self.values, zipped=self.zipped)

    def __getitem__(self, measure: str) -> AnyArray:
        return np.array([result.measures[measure].value for result in self.results]).reshape(self.shape)

    def rows(self, measures: Sequence[str] = ()) -> list[dict[str, Any]]:
        """Return a table: the values of each point and its measures."""
        names, columns = measures or list(self.measures), self.columns
        return [
            {columns[name]: value for name, value in point.items()}
            | {name: result.measures[name].value for name in names}
            for point, result in zip(self.points(), self.results, strict=True)
        ]

    def to_xarray(self) -> "xarray.Dataset":
        """Return a Dataset with a variable for each measure, over a dimension per parameter."""
        need("xarray")
        # for start-up time: only this needs it
        import xarray

        columns = self.columns
        dimensions = ["point"] if self.zipped else list(columns.values())
        coordinates: dict[str, Any] = {
            columns[name]: ("point" if self.zipped else columns[name], [v if _plain(v) else str(v) for v in values])
            for name, values in self.values.items()
        }
        variables = {name: (dimensions, self[name], {"units": unit}) for name, unit in self.measures.items()}
        return xarray.Dataset(variables, coordinates, {"graph": self.results[0].graph.name})

    def _repr_html_(self) -> str:
        heads = [*self.columns.values(), *(f"{name} [{unit}]" for name, unit in self.measures.items())]
        top = "".join(f"<th>{escape(head)}</th>" for head in heads)
        rows = ("".join(f"<td>{escape(_cell(value))}</td>" for value in row.values()) for row in self.rows())
        return f"<table><tr>{top}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


@named_arguments
def sweep(
    graph: GraphSource,
    values: Mapping[str, Sequence[object]],
    *,
    zipped: bool = False,
    traces: bool = False,
    duration: str | float | Fraction | None = None,
    samples: int | None = None,
    seed: int | None = None,
    engine: EngineName = "auto",
) -> Sweep:
    """Run a graph once for each combination of values of its parameters, `{"adc.bits": [10, 12],
    "mass": ["1 ug"]}`.

    Any parameter and named value may be swept, numbers, integers and texts alike. `zipped` takes
    the first values of all parameters together, then the second ones. Probes record only with
    `traces`. By default the engine is chosen for all runs together; the seed is the same at every
    point.

    Raises `ModelError` with what is wrong, at whichever point, before anything runs.

    `graph` has the measures. `values` are lists, by parameter or named value. `duration`,
    `samples`, `seed` and `engine` are those of `simulate`.

    >>> from proofmass import read_graph, sweep
    >>> graph = read_graph("library:template")
    >>> result = sweep(graph, {"adc.bits": [10, 12]}, traces=True, duration="20 ms")
    >>> [(point["adc.bits"], float(run["adc.code"].values[-1])) for point, run in zip(result.points(), result.results)]
    [(10, -175.0), (12, -700.0)]
    """
    graph = graph_from(graph)
    given = {name: plain(entries) for name, entries in values.items()}
    listed = {name: each for name, each in given.items() if isinstance(each, Iterable) and not isinstance(each, str)}
    lists = {name: tuple(map(plain, entries)) for name, entries in listed.items()}
    _refuse(values, lists, zipped=zipped)
    graphs = list(_changed(graph if traces else graph.changed(probes=()), points(lists, zipped=zipped)))
    plans = [plan(changed) for changed in graphs]
    options = RunOptions(duration=duration, samples=samples, seed=seed, engine=engine)
    ticks = sum(ticks_of(planned, options) for planned in plans)
    options = replace(options, engine=choose(plans[0], ticks, engine))
    results = [simulate_plan(planned, changed, options) for planned, changed in zip(plans, graphs, strict=True)]
    return Sweep(lists, zipped, tuple(results))


def points(values: Mapping[str, Sequence[object]], *, zipped: bool) -> Iterator[dict[str, object]]:
    """Yield the values of all parameters at each point of a sweep.

    >>> list(points({"a": [1, 2], "b": [3, 4]}, zipped=True))
    [{'a': 1, 'b': 3}, {'a': 2, 'b': 4}]
    """
    rows = zip(*values.values(), strict=True) if zipped else itertools.product(*values.values())
    return (dict(zip(values, row, strict=True)) for row in rows)


def _changed(graph: Graph, every: Iterator[dict[str, object]]) -> Iterator[Graph]:
    for point in every:
        try:
            yield with_parameters(graph, point)
        except ModelError as error:
            where = ", ".join(f"{name} = {value}" for name, value in point.items())
            own = [replace(problem, message=f"{problem.message}, at the point {where}") for problem in error.problems]
            raise ModelError(own) from None


def _refuse(values: Mapping[str, object], lists: Mapping[str, tuple[object, ...]], *, zipped: bool) -> None:
    """Raise `ModelError` for a sweep of nothing, or of too much."""
    problems = []
    for name, entries in values.items():
        if not lists.get(name):
            hint = "write a list of values, as in [10, 12, 14]"
            problems.append(Problem(message="has no values to sweep", key=name, got=shown(entries), hint=hint))
    sizes = {name: len(entries) for name, entries in lists.items()}
    count = math.prod(sizes.values())
    if not values:
        problems.append(Problem(message="nothing is swept", hint='name a parameter: {"adc.bits": [10, 12, 14]}'))
    elif zipped and len(set(sizes.values())) > 1:
        got = ", ".join(f"{name}: {size}" for name, size in sizes.items())
        problems.append(Problem(message="values that move together must be equally many", got=got))
    elif not zipped and count > MOST_POINTS:
        problems.append(Problem(message="too many points", got=f"{count:,}", expected=f"at most {MOST_POINTS:,}"))
    if problems:
        raise ModelError(problems)


def _cell(value: object) -> str:
    return str(value) if not isinstance(value, float) else "undefined" if math.isnan(value) else f"{value:.6g}"


def _plain(value: object) -> bool:
    return isinstance(value, int | float | str)
