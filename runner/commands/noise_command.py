"""The command `noise`: what the noise of an output is made of."""

from functools import partial

import click

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.graphs.model.names import last_outputs
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.noise.budget import BudgetQuestion, budgets_at
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from proofmass.runner.analysis.noise.over_runs import deviation_over_runs
from proofmass.runner.analysis.noise.plot import plot_noise
from proofmass.runner.analysis.noise.text import derivatives_text, noise_text, value_text
from proofmass.runner.commands.answers import DONE, print_answer, print_pictures
from proofmass.runner.commands.declarations.analysis import NoiseRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.progress import progress
from proofmass.runner.commands.series_source import band_of
from proofmass.runner.planning.plan import plan

_NO_OUTPUT = Problem(message="the graph has no probe", hint="name an output: --output adc.number", path=("probes",))


def show_noise(request: NoiseRequest) -> int:
    """Show a noise budget and return the exit code."""
    graph = graph_of(request.graph, request.own, request.changes)
    if request.until is not None:
        return _show_value(request, graph)
    with progress(request.as_json) as bar:
        points = OperatingPoints(plan(graph), request.at, bar)
    probed = list(dict.fromkeys(probe.signal for probe in points.plan.probes))
    outputs = [request.output] if request.output else probed or last_outputs(points.plan.graph)
    if not outputs:
        raise points.plan.graph.placed(_NO_OUTPUT).error
    wanted = BudgetQuestion(request.source, band_of(request.band), derivatives=request.derivatives)
    answers = budgets_at(points, outputs, wanted)
    budgets = [answer for answer in answers if isinstance(answer, NoiseBudget)]
    refused = [answer for answer in answers if isinstance(answer, ModelError)]
    data = [budget.as_data() for budget in budgets]
    texts = (text for budget in budgets for text in (noise_text(budget), *derivatives_text(budget)))
    print_answer(request.as_json, lambda: data[0] if request.output and data else data, texts)
    figures = {budget.output: partial(plot_noise, budget) for budget in budgets}
    print_pictures(figures, request.picture, request.as_json)
    if refused:
        raise ModelError([problem for error in refused for problem in error.problems])
    return DONE


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
