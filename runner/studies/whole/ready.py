"""Checks whether a graph is ready to run, by planning it as a run does: both refuse the same."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from proofmass.blocks.declaration.problem import ModelError, Problem, Problems
from proofmass.graphs.checks.check import check as check_wiring
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study import Study
from proofmass.runner.plan.measuring import refuse_late
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.recording_notes import recording_notes
from proofmass.runner.run.trace_size import refuse_large
from proofmass.runner.studies.runs.notes import notes_of_a_study

MANY_STEPS = 1000  # in a tick


def check(graph: GraphSource) -> Problems:
    """Return all problems of a graph, each with its place; only notes are left if the graph can run.

    The files that it names are read, and it is planned as for a run. A graph with open inputs, a
    part of others, is checked by itself.

    Nothing is raised: what is wrong with the `graph` is in the list.

    >>> from proofmass import Graph, check
    >>> from proofmass.blocks import LowPass
    >>> for problem in check(Graph(name="open", rate="1 kHz", blocks={"lag": LowPass()})):
    ...     print(problem.key, problem.message)
    blocks.lag the input input is not connected
    """
    graph = graph_from(graph)
    problems = Problems(check_wiring(graph))
    if all(problem.note for problem in problems) and runs_alone(flatten(graph)):
        problems += unready(graph)
    return problems


def unready(graph: Graph, study: Study | None = None) -> list[Problem]:
    """Return the problems of a run or study beyond the wiring, and notes on it."""
    try:
        planned = plan(graph)
    except ModelError as error:
        return list(error.problems)
    length = list(_length(planned, study))
    if any(not problem.note for problem in length):
        return length
    end = None if length else Fraction(planned.ticks() - 1) / planned.schedule.base_rate
    notes = [*_many_steps(planned, end), *recording_notes(planned, end), *(notes_of_a_study(study) if study else ())]
    return [*length, *(_measures(planned, study) if end is not None else ()), *notes]


def _length(planned: Plan, study: Study | None) -> Iterator[Problem]:
    """Yield why a run has no length; a note if the command line may still give one."""
    try:
        planned.ticks()
    except ModelError as error:
        missing = planned.graph.samples is None and planned.graph.duration is None
        yield from (replace(problem, note=missing and study is None) for problem in error.problems)


def _many_steps(planned: Plan, end: Fraction | None) -> Iterator[Problem]:
    """Yield groups of continuous blocks that take a thousand steps a tick, or more."""
    for solver in planned.solvers:
        if solver.exact or solver.substeps < MANY_STEPS:
            continue
        blocks = solver.group.blocks
        message = f"{', '.join(blocks)}: a tick takes {solver.substeps:,} steps of {solver.method}"
        got = f"{solver.substeps * planned.ticks():,} in the run" if end is not None else ""
        hint = 'choose method = "radau", a lower accuracy or a higher rate, or look for a parameter that is far off'
        yield planned.graph.placed(Problem(message=message, got=got, hint=hint, note=True, path=("blocks", blocks[0])))


def _measures(planned: Plan, study: Study | None) -> Iterator[Problem]:
    """Yield measures that begin too late, and traces too large for memory; studies have measures but no traces."""
    for refuse in (refuse_late, *(() if study else (refuse_large,))):
        try:
            refuse(planned, planned.ticks())
        except ModelError as error:
            yield from (replace(problem, note=study is None) for problem in error.problems)
