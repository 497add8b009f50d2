"""The command `diff`: two graphs, two runs or two studies, compared by what they mean."""

from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_answer, print_file
from proofmass.runner.commands.declarations.comparison import DiffRequest
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.comparison.files import file_differences
from proofmass.runner.comparison.runs import Allowance, compare_runs, is_run
from proofmass.runner.comparison.studies import compare_studies
from proofmass.runner.comparison.tables import Table, difference_table, run_tables, save_tables, study_tables, text_of
from proofmass.runner.studies.kept.folder import STUDY_FILE, kept_result

GRAPH, RUN, OF_STUDY = "graph", "run", "study"
_VERDICTS = {
    GRAPH: ("they mean the same", "they differ"),
    RUN: ("traces, measures and margins are the same", "traces, measures or margins differ"),
    OF_STUDY: ("no mean and no yield moved", "means or yields moved, or one sensor alone differs"),
}


def show_differences(request: DiffRequest) -> int:
    """Compare, print and write, and return the exit code: 1 where something differs."""
    own = own_blocks(request.own)
    kinds = [_kind(path) for path in (request.before, request.after)]
    if kinds[0] != kinds[1]:
        got, hint = (
            f"a {kinds[0]} and a {kinds[1]}",
            "compare two graphs, two folders of runs, or two folders of studies",
        )
        raise Problem(message="cannot be compared", file=str(request.after), got=got, hint=hint).error
    data, tables, same = _compared(kinds[0], request, own)
    verdict = f"{request.before} and {request.after}: {_VERDICTS[kinds[0]][0 if same else 1]}"
    print_answer(request.as_json, lambda: data, [*text_of(tables), verdict])
    if request.page is not None:
        save_tables(request.page, "Differences", verdict, tables)
        print_file(request.page, request.as_json)
    return DONE if same else WRONG_MODEL


def _kind(path: Path) -> str:
    if path.is_dir():
        if (path / STUDY_FILE).is_file():
            return OF_STUDY
        if is_run(path):
            return RUN
        hint = "name a graph file, or a folder of proofmass run --out or proofmass montecarlo --out"
        raise Problem(message="holds no run and no study", file=str(path), hint=hint).error
    return GRAPH


def _compared(kind: str, request: DiffRequest, own: Own | None) -> tuple[dict[str, Any], list[Table], bool]:
    """Return a comparison as plain data and as tables, and whether all is the same."""
    if kind == RUN:
        runs = compare_runs(request.before, request.after, Allowance(request.absolute, request.relative), own)
        return runs.as_data(), run_tables(runs), runs.same
    if kind == OF_STUDY:
        studies = compare_studies(kept_result(request.before, own), kept_result(request.after, own))
        return studies.as_data(), study_tables(studies), studies.same
    found = file_differences(request.before, request.after, own)
    data = {"same": not found, "differences": [difference.as_data() for difference in found]}
    return data, [difference_table("graph", found)], not found
