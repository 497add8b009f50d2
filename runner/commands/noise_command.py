"""The command `noise`: what the noise of an output is made of."""

import math
from dataclasses import dataclass
from pathlib import Path

import click

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit, word_of
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.noise.budget import NoiseBudget, budget_at
from proofmass.runner.analysis.noise.over_runs import ValueDeviation, deviation_over_runs
from proofmass.runner.analysis.noise.plot import plot_noise
from proofmass.runner.commands.answers import print_file, print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.progress import progress
from proofmass.runner.commands.series_source import band_of
from proofmass.runner.commands.texts.sensitivity import sensitivity_text
from proofmass.runner.output.pictures import save_figure
from proofmass.runner.planning.plan import plan

_SMALL_MISFIT = 1.0  # dB, to which N, B and K describe a density
_ROWS = 20
_NO_OUTPUT = Problem(
    message="the graph has no probe", key="probes", hint="name an output: --output adc.number", path=("probes",)
)


@dataclass(frozen=True)
class NoiseRequest:
    """Request of `proofmass noise`."""

    graph: Path
    output: str
    source: str
    band: tuple[str, str] | None
    at: str
    derivatives: bool
    until: str | None
    picture: Path | None
    changes: tuple[str, ...]
    own: Path | None
    as_json: bool


def show_noise(request: NoiseRequest) -> int:
    """Show a noise budget and return the exit code."""
    graph = graph_of(request.graph, request.own, request.changes)
    if request.until is not None:
        return _show_value(request, graph)
    with progress(request.as_json) as bar:
        points = OperatingPoints(plan(graph), request.at, bar)
    outputs = [request.output] if request.output else list(dict.fromkeys(probe.signal for probe in points.plan.probes))
    if not outputs:
        raise ModelError([points.plan.graph.placed(_NO_OUTPUT)])
    budgets, refused = list[NoiseBudget](), list[ModelError]()
    for output in outputs:
        try:
            budgets.append(budget_at(points, output, request.source, band_of(request.band), (), request.derivatives))
        except ModelError as error:
            refused.append(error)
    if request.as_json:
        print_json(budgets[0].as_data() if request.output and budgets else [budget.as_data() for budget in budgets])
    else:
        print_text(text for budget in budgets for text in (noise_text(budget), *_derivatives(budget)))
    if request.picture is not None:
        names = [_named(request.picture, budget.output, len(budgets)) for budget in budgets]
        for budget, path in zip(budgets, names, strict=True):
            print_file(save_figure(plot_noise(budget), path), request.as_json)
    if refused:
        raise ModelError([problem for error in refused for problem in error.problems])
    return DONE


def _named(picture: Path, output: str, several: int) -> Path:
    return picture if several == 1 else picture.with_stem(f"{picture.stem}_{output}")


def _show_value(request: NoiseRequest, graph: Graph) -> int:
    """Show how far one value differs from run to run."""
    given = {
        "--input": request.source,
        "--band": request.band,
        "--at": request.at != AUTO,
        "--derivatives": request.derivatives,
        "--plot": request.picture,
    }
    wrong = [name for name, value in given.items() if value]
    if wrong:
        raise click.UsageError(f"{', '.join(wrong)}: with --until there is one value, and no spectrum; leave it out")
    with progress(request.as_json) as bar:
        value = deviation_over_runs(graph, request.output, until=request.until, progress=bar)
    if request.as_json:
        print_json(value.as_data())
    else:
        print_text([value_text(value)])
    return DONE


def value_text(found: ValueDeviation) -> str:
    """Return the value of an output at a time with its deviation over runs, and that of each source, for people."""
    unit = f" {found.unit}" if found.unit != "1" else ""
    whole = found.deviation**2
    lines = [
        f"{found.output} at {found.time:.6g} s: {found.value:.6g}{unit},"
        f" from run to run +-{found.deviation:.4g}{unit} rms",
        f"  {'source':<28} {'rms' + unit:>16} {'share':>8}",
    ]
    lines += [f"  {name:<28} {rms:16.5g} {100.0 * rms**2 / whole:7.2f} %" for name, rms in found.sources.items()]
    return "\n".join(lines)


def noise_text(budget: NoiseBudget) -> str:
    """A budget for people: a row for each source, and what it amounts to."""
    unit = f" {budget.unit}" if budget.unit != "1" else ""
    low, high = budget.band
    lines = [
        f"noise of {budget.output}, {low:g} Hz to {high:g} Hz: {budget.rms:.6g}{unit} rms",
        f"  {'source':<28} {'kind':<20} {'rms' + unit.join(('', '')):>12} {'share':>8}",
    ]
    for source in budget.sources[:_ROWS]:
        doubtful = "  ?" if source.doubtful else ""
        lines.append(
            f"  {source.block:<28} {source.kind:<20} {source.rms:12.5g} {100.0 * source.share:7.2f} %{doubtful}"
        )
    more = len(budget.sources) - _ROWS
    lines += [f"  and {more} more"] if more > 0 else []
    lines += _coefficients(budget)
    return "\n".join([*lines, *(f"  note: {note}" for note in budget.notes)])


def _derivatives(budget: NoiseBudget) -> list[str]:
    """The parameters that move the rms, and what one more of each whole number does."""
    if budget.derivatives is None:
        return []
    steps = [
        f"  {step.parameter:<32} {step.change:+12.4g}  for {step.value + 1} instead of {step.value}"
        for step in budget.steps
    ]
    return [sensitivity_text(budget.derivatives), *steps]


def _coefficients(budget: NoiseBudget) -> list[str]:
    """White level, bias instability and random walk, at the input where there is one."""
    unit = budget.referred_unit
    lines = [f"referred to {budget.input}" if budget.input else f"density of {budget.output}"]
    lines += [_density(budget, share) for share in (0.0, 0.5, 1.0)]
    levels = budget.levels
    if levels.misfit > _SMALL_MISFIT:
        lines.append(f"  N, B, K and Q do not describe it: {levels.misfit:.1f} dB off; name a narrower --band")
        return lines
    for level in levels.levels:
        value = in_field_unit(level.name, level.value, unit)
        if level.value:
            lines.append(f"  {level.name}  {word_of(level.name, unit):<26} {value:.5g} {field_unit(level.name, unit)}")
    return lines


def _density(budget: NoiseBudget, share: float) -> str:
    """Amplitude density at a place on the logarithmic axis of frequency."""
    place = round(share * (len(budget.frequencies) - 1))
    value = in_field_unit("density", math.sqrt(float(budget.referred_density[place])), budget.referred_unit)
    unit = field_unit("density", budget.referred_unit)
    return f"  at {budget.frequencies[place]:<12.5g} Hz {'':<11} {value:.5g} {unit}"
