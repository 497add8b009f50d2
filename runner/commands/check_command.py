"""The command `check`: everything that is wrong with a file, and whether it is ready to run."""

import click

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten, values_of
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study import Study
from proofmass.graphs.tuning.check_file import check_file
from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_json, print_problem, print_text
from proofmass.runner.commands.declarations.graphs import CheckRequest
from proofmass.runner.commands.failures import print_codes
from proofmass.runner.commands.graph_options import changed
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table

_VALUES = 40  # that are shown


def check_graph(request: CheckRequest) -> int:
    """Check a graph or study, print its problems and notes, and return the exit code."""
    graph, problems, study = check_file(
        request.graph, own_blocks(request.own), lambda graph: changed(graph, request.changes)
    )
    alone = graph is not None and not _wrong(problems) and runs_alone(flatten(graph))
    if graph is not None and alone:
        from proofmass.runner.studies.whole.ready import unready  # start-up time: NumPy

        problems += unready(graph, study)
        if not _wrong(problems) and any(loop.requirements for loop in flatten(graph).loops.values()):
            problems += _missed_margins(graph)
    wrong = _wrong(problems)
    if request.as_json:
        print_json([problem.as_data() for problem in problems])
        return WRONG_MODEL if wrong else DONE
    for problem in problems:
        print_problem(problem, err=not problem.note)
    if graph is None or wrong:
        print_codes(wrong)
        click.echo(f"{count(len(wrong), 'problem')} in {request.graph}", err=True)
        return WRONG_MODEL
    ready = "ready to run" if alone else "ready to be a part of other graphs"
    size = f"{count(graph.size.blocks, 'block')}, {count(graph.size.wires, 'wire')}{_study_size(study)}"
    click.echo(f"{request.graph}: {size}, {ready}")
    print_text(_values(graph))
    return DONE


def _missed_margins(graph: Graph) -> list[Problem]:
    """Return the problems and notes of loops with requirements, linearised at tick 0."""
    # start-up time: a wrong graph is refused without NumPy
    from proofmass.runner.analysis.margins.margins import Margins
    from proofmass.runner.analysis.margins.stability import all_margins, missed
    from proofmass.runner.planning.plan import plan

    planned, loops, notes = plan(graph), dict[str, Margins](), list[Problem]()
    for name, loop in planned.graph.loops.items():
        loops |= all_margins(planned, name) if loop.requirements else {}
    for margins in loops.values():
        for text in margins.system.map.notes:
            notes.append(planned.graph.placed(Problem(message=text, note=True, path=("loops", margins.loop))))
    return [*missed(planned, loops), *notes]


def _study_size(study: Study | None) -> str:
    """Return how many runs a study has, at how many points of its sweep and ages of the sensors."""
    if study is None:
        return ""
    points = f" at each of {count(study.points, 'point')}" if study.points > 1 else ""
    return f", {count(study.runs, 'run')}{points} at {count(len(study.epochs), 'age')}"


def _wrong(problems: list[Problem]) -> list[Problem]:
    return [problem for problem in problems if not problem.note]


def _values(graph: Graph) -> list[str]:
    """Return a line for each value of a graph and its subgraphs, with its formula; nothing without values."""
    values = values_of(graph).items()
    rows = [(name, value.text(), value.formula.text if value.formula else "") for name, value in values]
    if not rows:
        return []
    more = [f"and {len(rows) - _VALUES} more"] if len(rows) > _VALUES else []
    return ["", *text_table([("value", "is", ""), *rows[:_VALUES]], left=(0, 2)), *more]
