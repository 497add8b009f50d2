"""Coefficients of a fit, written into the models of a graph file."""

from collections.abc import Sequence
from pathlib import Path

from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.graphs.files.toml_editor import edit_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.exports import exported
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.design.fit.fit import Fit, FitReport
from proofmass.runner.output.export import write_whole

MODELS = (  # kinds that take coefficients without being named, beside subgraphs that export a1, b1, a2 and b2
    "DoubleExponentialModel",
    "FixedCoefficientMemory",
    "FixedPolynomial",
    "PolynomialModel",
)
_EXPONENTIALS = ("a1", "b1", "a2", "b2")


def write_coefficients(report: FitReport, target: Path, names: Sequence[str], own: Path | None) -> Path:
    """Write the coefficients into the named blocks of a graph file, or into all its models; returns the file.

    Raises `ModelError` if the readings do not determine them, or no block takes them.
    """
    graph = read_graph(target, own_blocks(own))
    models = names or _models(graph)
    if not models:
        hint = f"name one with --block, or put one in: {', '.join(MODELS)}"
        raise Problem(message="has no block for the coefficients", file=str(target), hint=hint).error
    values: dict[str, float | str] = {}
    for name in models:
        values |= coefficients_for(report, graph, name)
    if not report.determined and any(key.endswith(".a1") for key in values):
        reason = next(finding for finding in report.findings if not finding.note)
        message = "nothing was written: the readings do not determine the two exponentials"
        raise ModelError([reason, Problem(message=message, file=str(target))])
    with_parameters(graph, values)  # refuses units that do not fit
    return write_whole(target, edit_file(target, values))


def coefficients_for(report: FitReport, graph: Graph, name: str) -> dict[str, float | str]:
    """Return the coefficients that a block takes, by `block.parameter`, with their units where these are known.

    A block with parameters a1, b1, a2 and b2 takes the two exponentials; one with c0, c1, ... the
    polynomial of the highest order, and zero for its further coefficients. A subgraph has the
    parameters that it exports.
    """
    if name not in graph.blocks and name not in graph.subgraphs:
        hint = did_you_mean(name, [*graph.blocks, *graph.subgraphs], "the blocks")
        raise Problem(message="there is no such block", file=graph.place.file, key=name, hint=hint).error
    parameters = _parameters(graph, name)
    polynomials = [fit for fit in report.fits if fit.method == "least squares"]
    for fit in (report.fits[0], *polynomials[-1:]):
        if all(c.name in parameters for c in fit.coefficients):
            return _by_key(fit, name, [parameter for parameter in parameters if parameter[1:].isdigit()])
    raise Problem(
        message="takes neither two exponentials nor the polynomial of the highest order",
        file=graph.place.file,
        key=name,
        got=type(graph.blocks.get(name, graph)).__name__,
        expected="a block with parameters a1, b1, a2, b2, or c0, c1, ...",
    ).error


def _parameters(graph: Graph, name: str) -> list[str]:
    if name in graph.blocks:
        return list(type(graph.blocks[name]).parameters)
    exports = exported(flatten(graph.subgraphs[name]))
    return [port for port, (_, inner) in exports.items() if isinstance(inner, Parameter)]


def _models(graph: Graph) -> tuple[str, ...]:
    """The models of a graph by kind, and the subgraphs that take what a model takes."""
    models = [name for name, block in graph.blocks.items() if type(block).__name__ in MODELS]
    return (*models, *(name for name in graph.subgraphs if set(_EXPONENTIALS) <= set(_parameters(graph, name))))


def _by_key(fit: Fit, name: str, parameters: list[str]) -> dict[str, float | str]:
    letters = {c.name[0] for c in fit.coefficients}
    values: dict[str, float | str] = {f"{name}.{p}": 0.0 for p in parameters if p[0] in letters}
    return values | {f"{name}.{c.name}": f"{c.value!r} {c.unit}" if c.unit else c.value for c in fit.coefficients}
