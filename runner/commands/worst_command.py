"""The command `worst`: how bad margins, noise and measures can get in tolerances."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import click

from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study import Study
from proofmass.runner.commands.answers import DONE, INTERRUPTED, print_answer, print_picture
from proofmass.runner.commands.declarations.design import WorstRequest
from proofmass.runner.commands.graph_options import toleranced
from proofmass.runner.commands.named_options import by_name, read_tolerance
from proofmass.runner.commands.progress import progress
from proofmass.runner.design.worst.plot import plot_worst
from proofmass.runner.design.worst.text import worst_text
from proofmass.runner.design.worst.worst import worst
from proofmass.runner.output.text_table import text_table
from proofmass.runner.studies.whole.study import run_study


def show_worst(request: WorstRequest) -> int:
    """Show worst cases and return the exit code."""
    (source, left_out), quantities = (
        toleranced(request.source, request.own, request.changes),
        dict(_quantities(request)),
    )
    with progress(request.quiet or request.as_json, "point") as bar:
        cases = request.call(
            worst,
            source,
            quantities or None,
            tolerances=by_name("--tolerance", map(read_tolerance, request.tolerances)),
            seed=request.seed or 0,
            progress=bar,
        )
    cases = replace(cases, left_out={**cases.left_out, **left_out})
    yields = _study_yields(source, request.runs)
    named = {"graph": source.graph.name if isinstance(source, Study) else source.name}
    more = {"yields": yields} if yields else {}
    lines = [worst_text(cases), *_yields_text(yields, request.runs or 0)]
    print_answer(request.as_json, lambda: named | cases.as_data() | more, lines)
    print_picture(lambda: plot_worst(cases), request.picture, request.as_json)
    return INTERRUPTED if cases.interrupted else DONE


def _study_yields(source: Graph | Study, runs: int | None) -> dict[str, tuple[float, float, float]]:
    """Return the yield of each limit with its interval of 95 %, if `runs` asks for sensors."""
    if runs is None:
        return {}
    if not (isinstance(source, Study) and source.limits):
        raise click.UsageError("--runs: of a study with limits; a graph alone has no yield")
    result = run_study(source, runs=runs)
    intervals = result.yield_intervals()
    return {name: (part, *intervals[name]) for name, part in result.yields().items()}


def _yields_text(yields: Mapping[str, tuple[float, float, float]], runs: int) -> Iterator[str]:
    if yields:
        yield f"yield of {runs:,} sensors of the study, with intervals of 95 %"
        rows = [(name, *(f"{100.0 * part:.4g} %" for part in parts)) for name, parts in yields.items()]
        yield from (f"  {line}" for line in text_table([("limit", "yield", "from", "to"), *rows], left=(0,)))


def _quantities(request: WorstRequest) -> Iterator[tuple[str, dict[str, Any]]]:
    for text in request.figures:
        loop, colon, figure = text.rpartition(":")
        if not colon:
            raise click.UsageError(f"--figure {text}: write LOOP:FIGURE, for example main:phase_margin")
        yield text, {"loop": loop, "figure": figure}
    for key, signals in (("scale_factor", request.scale_factors), ("bias", request.biases)):
        for signal in signals:
            if not request.source_signal:
                raise click.UsageError(f"--{key.replace('_', '-')} needs --input, the output of the source")
            yield f"{key.replace('_', ' ')} of {signal}", {key: signal, "input": request.source_signal}
    for signal in request.noises:
        noise: dict[str, Any] = {"noise": signal}
        noise |= {"input": request.source_signal} if request.source_signal else {}
        noise |= {"band": list(request.band)} if request.band else {}
        yield f"noise of {signal}", noise
    for text in request.responses:
        signal, colon, figure = text.rpartition(":")
        if not (colon and request.source_signal):
            raise click.UsageError(f"--response {text}: write BLOCK.PORT:FIGURE, and --input, the output of the source")
        figure, _, frequency = figure.partition("@")
        response = {"response": signal, "input": request.source_signal, "figure": figure}
        yield f"{figure} of {signal}", response | ({"frequency": frequency} if frequency else {})
    for name in request.measures:
        yield name, {"measure": name}
    for name in request.yields:
        yield f"yield of {name}", {"yield": True if name == "all" else name}
