"""The command `margins`: show and draw margins, sensitivities or limit cycles of a graph."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING

import click

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.analysis.linearisation.find_loops import find_loops
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.plot import plot_margins, plot_sensitivities
from proofmass.runner.analysis.margins.sensitivity import Sensitivity, margin_sensitivities, transfer_sensitivities
from proofmass.runner.analysis.margins.stability import margins_or_reasons, missed
from proofmass.runner.analysis.margins.text import margins_text, sensitivity_text
from proofmass.runner.commands.answers import DONE, print_answer, print_pictures
from proofmass.runner.commands.declarations.graphs import MarginsRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.named_options import by_name
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.progress import progress
from proofmass.runner.planning.plan import plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from proofmass.runner.analysis.margins.second_opinion import SecondOpinion


def show_margins(request: MarginsRequest) -> int:
    """Show margins of a graph and return the exit code; raises `ModelError` if one is missed."""
    if request.over == "age":
        # start-up time: only this option needs it, and those of several loops
        from proofmass.runner.commands.several_loops import show_over

        study = read_study(request.graph, own_blocks(request.own))
        return show_over(study, "age", request.loop, request.at, request.picture, request.as_json)
    graph = graph_of(request.graph, request.own, request.changes)
    if request.limit_cycle:
        return _show_limit_cycles(graph, request)
    if request.gains or request.amplitudes:
        # start-up time: only these options need it
        from proofmass.runner.analysis.limit_cycles.quasi_linear import with_gains

        graph = with_gains(graph, _pairs("--gain", request.gains), _pairs("--amplitude", request.amplitudes))
    if request.together or request.others or request.over:
        return _show_several(graph, request)
    planned = plan(graph)
    with progress(request.as_json) as bar:
        points = OperatingPoints(planned, request.at, bar)
        answers = _answers(points, request)
    loops = {name: answer for name, answer in answers.items() if isinstance(answer, Margins)}
    quantities = _sensitivities(points, loops, *request.sensitivity) if request.sensitivity else []
    data = {"graph": graph.name, "loops": [margins.as_data() for margins in loops.values()]}
    data |= {"sensitivities": [quantity.as_data() for quantity in quantities]} if quantities else {}
    texts = chain(
        map(margins_text, loops.values()), map(sensitivity_text, quantities), (str(one) for one in _opinions(loops))
    )
    print_answer(request.as_json, lambda: data | {"python_control": [one.as_data() for one in _opinions(loops)]}, texts)
    figures: dict[str, Callable[[], Figure]] = {name: partial(plot_margins, loop) for name, loop in loops.items()}
    figures |= {"sensitivity": partial(plot_sensitivities, quantities)} if quantities else {}
    print_pictures(figures, request.picture, request.as_json)
    problems = [problem for error in answers.values() if isinstance(error, ModelError) for problem in error.problems]
    problems += missed(planned, loops)
    if problems:
        raise ModelError(problems)
    return DONE


def _sensitivities(
    points: OperatingPoints, loops: Mapping[str, Margins], source: str, target: str
) -> list[Sensitivity]:
    """Return scale factor and bias from one output to another, and the margins of loops, with their derivatives."""
    planned = points.plan
    ends = node_of(planned, source), node_of(planned, target)
    quantities = list(points.answered(lambda about: transfer_sensitivities(about, *ends)))
    for margins in loops.values():
        node = node_of(planned, margins.open_at)
        quantities += margin_sensitivities(planned, margins, points.loop(node, by_parameters=True))
    return quantities


def _opinions(loops: dict[str, Margins]) -> "Iterator[SecondOpinion]":
    """Opinions of python-control on the loops; its import follows behind our figures."""
    if loops:
        # start-up time: python-control takes 0.9 s
        from proofmass.runner.analysis.margins.second_opinion import second_opinion

        yield from map(second_opinion, loops.values())


def _show_limit_cycles(graph: Graph, request: MarginsRequest) -> int:
    # start-up time: only this option needs it
    from proofmass.runner.analysis.limit_cycles.text import limit_cycles, limit_cycles_data, limit_cycles_lines

    cycles = limit_cycles(graph, request.limit_cycle)
    print_answer(request.as_json, lambda: limit_cycles_data(graph, cycles), limit_cycles_lines(cycles))
    return DONE


def _show_several(graph: Graph, request: MarginsRequest) -> int:
    # start-up time: only these options need it
    from proofmass.runner.commands.several_loops import show_over, show_together

    if request.over and (request.together or request.others):
        raise click.UsageError("--over shows loops one by one: leave out --together and --with")
    if request.over:
        return show_over(graph, request.over, request.loop, request.at, request.picture, request.as_json)
    loops = tuple(name for name in (request.loop, *request.others) if name)
    return show_together(graph, loops, request.at, request.picture, request.as_json)


def _pairs(option: str, texts: tuple[str, ...]) -> dict[str, str]:
    """Values of an option by block."""
    pairs = [text.partition("=") for text in texts]
    for text, (name, equals, value) in zip(texts, pairs, strict=True):
        if not (name and equals and value):
            raise click.UsageError(f"{option} {text}: write BLOCK=VALUE, for example quantiser=0.7")
    return by_name(option, ((name.strip(), value.strip()) for name, _, value in pairs))


def _answers(points: OperatingPoints, request: MarginsRequest) -> dict[str, Margins | ModelError]:
    """Margins of the loops; none of a graph without loops where only sensitivities of its outputs are wanted."""
    if request.sensitivity and not request.loop and not points.plan.graph.loops and not find_loops(points.plan):
        return {}
    return margins_or_reasons(points, request.loop, over=True)
