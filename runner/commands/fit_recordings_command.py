"""The command `fit` of a graph to recordings: read, fit, show, draw, write the parameters into a graph file."""

from collections.abc import Sequence

import click

from proofmass.graphs.files.toml_editor import edit_file
from proofmass.runner.commands.answers import DONE, INTERRUPTED, WRONG_MODEL, print_answer, print_file
from proofmass.runner.commands.declarations.fit import FitRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.named_options import by_name
from proofmass.runner.commands.progress import progress
from proofmass.runner.design.identification.fitted import fit
from proofmass.runner.design.identification.plot import plot_fitted
from proofmass.runner.design.identification.text import fitted_text
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.pictures import save_figure


def fit_recordings(request: FitRequest) -> int:
    """Fit a graph to recordings; exit code 1 if they do not determine every parameter."""
    graph = graph_of(request.source, request.own, request.changes)
    with progress(request.quiet or request.as_json, "run") as bar:
        fitted = request.call(
            fit,
            graph,
            list(request.files),
            inputs=_mapped("--input", request.inputs),
            outputs=_mapped("--output", request.outputs),
            free=_bounds(request.free),
            starts=request.tries,
            seed=request.seed or 0,
            progress=bar,
        )
    paths = []
    try:  # before anything is printed, as in `run_fit`
        if request.plot is not None:
            paths.append(save_figure(plot_fitted(fitted), request.plot))
        if request.target is not None and fitted.determined:
            paths.append(write_whole(request.target, edit_file(request.target, fitted.changes)))
    finally:
        print_answer(request.as_json, lambda: {"graph": graph.name} | fitted.as_data(), [fitted_text(fitted)])
    for path in paths:
        print_file(path, request.as_json)
    if request.target is not None and not fitted.determined:
        click.echo("nothing was written: the recordings do not determine every parameter", err=True)
    return INTERRUPTED if fitted.interrupted else DONE if fitted.determined else WRONG_MODEL


def _mapped(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Signals and their columns."""
    mapped = list[tuple[str, str]]()
    for text in texts:
        signal, _, column = text.partition("=")
        if "." not in signal:
            raise click.UsageError(f"{option} {text}: write BLOCK.PORT=COLUMN, for example readout.voltage=volts")
        mapped.append((signal.strip(), column.strip() or signal.strip()))
    return by_name(option, mapped)


def _bounds(texts: Sequence[str]) -> dict[str, object]:
    """Parameters and what is known of them: bounds, or a value with its standard uncertainty."""
    free = list[tuple[str, object]]()
    for text in texts:
        name, equals, known = text.partition("=")
        free.append((name.strip(), _known(text, known) if equals else {}))
    return by_name("--free", free)


def _known(text: str, known: str) -> dict[str, str]:
    for sign, keys in (("..", ("at_least", "at_most")), ("+-", ("expected", "uncertainty"))):
        first, found, second = (part.strip() for part in known.replace("\u00b1", "+-").partition(sign))
        if found and first and second:
            return {keys[0]: first, keys[1]: second}
    hint = 'write bounds as PARAMETER="100 N/m..200 N/m", or what is expected as PARAMETER="132 N/m +- 3 N/m"'
    raise click.UsageError(f"--free {text}: {hint}")
