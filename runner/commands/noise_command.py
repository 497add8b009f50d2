"""The command `noise`: what the noise of an output is made of."""

from collections.abc import Sequence
from functools import partial

import click

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import is_number
from proofmass.runner.analysis.noise.budget import BudgetQuestion, behind_sources, budgets_at
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from proofmass.runner.analysis.noise.over_runs import deviation_over_runs
from proofmass.runner.analysis.noise.plot import plot_noise
from proofmass.runner.analysis.noise.text import derivatives_text, noise_text, value_text
from proofmass.runner.commands.answers import DONE, Shown, print_answer, print_answers, print_text
from proofmass.runner.commands.declarations.analysis import NoiseRequest
from proofmass.runner.commands.graph_options import graph_of, outputs_of
from proofmass.runner.commands.progress import progress
from proofmass.runner.commands.series_source import band_of
from proofmass.runner.planning.plan import plan


def show_noise(request: NoiseRequest) -> int:
    """Show a noise budget and return the exit code."""
    graph = graph_of(request.graph, request.own, request.changes)
    if request.until is not None:
        return _show_value(request, graph)
    with progress(request.as_json) as bar:
        points = OperatingPoints(plan(graph), request.at, bar)
    every = outputs_of(graph, request.output, "--output")
    numbers = [output for output in every if is_number(points.plan, output)] or every
    outputs = behind_sources(points.plan, numbers)
    wanted = BudgetQuestion(request.source, band_of(request.band), derivatives=request.derivatives)
    answers = budgets_at(points, outputs, wanted)
    told = (answer if isinstance(answer, ModelError) else _answered(answer) for answer in answers)
    code = print_answers(told, bool(request.output), request.picture, request.as_json)
    silent, others = _less(numbers, outputs), _less(every, numbers)
    told_too = {"no noise reaches": silent, "not outputs of one number:": others}
    print_text(f"{words} {', '.join(left)}" for words, left in told_too.items() if left and not request.as_json)
    return code


def _less(outputs: Sequence[str], kept: Sequence[str]) -> list[str]:
    return [output for output in outputs if output not in kept]


def _answered(budget: NoiseBudget) -> Shown:
    lines = [noise_text(budget), *derivatives_text(budget)]
    return Shown(budget.output, lines, budget.as_data, partial(plot_noise, budget))


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
        value = request.call(deviation_over_runs, graph, progress=bar)
    print_answer(request.as_json, value.as_data, [value_text(value)])
    return DONE
