"""The command `report`: a study, ended or under way, as one HTML file."""

import time
from pathlib import Path

from proofmass.runner.commands.answers import DONE, print_json, print_text
from proofmass.runner.commands.declarations.graphs import ReportRequest
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.progress import working
from proofmass.runner.commands.study_files import study_data
from proofmass.runner.output.times import time_text
from proofmass.runner.studies.kept.folder import kept_result, last_result
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.proved import ProvedBound
from proofmass.runner.studies.shown.report import FILE, save_study_report


def report_study(request: ReportRequest) -> int:
    """Write the report of a study and return the exit code."""
    blocks = own_blocks(request.own)
    source = request.study
    folder, result = (source, kept_result(source, blocks)) if source.is_dir() else last_result(source, blocks)
    began = time.perf_counter()
    with working(request.as_json, "writing the report"):
        proved = [] if request.proof is None else _proved(request.proof, result)
        path = save_study_report(result, request.output or folder / FILE, proved=proved)
    seconds = time_text(time.perf_counter() - began)
    wrote = f"wrote {path}: {len(result.numbers):,} of {result.planned_runs:,} runs, in {seconds}"
    print_text([wrote], err=request.as_json)
    if request.as_json:
        print_json(study_data(result) | {"report": str(path)})
    return DONE


def _proved(certificate: Path, result: StudyResult) -> list[ProvedBound]:
    # start-up time: only reports with a proof need it
    from proofmass.runner.verification.proved_bounds import proved_bounds

    text = certificate.read_text(encoding="utf-8", errors="replace")
    return proved_bounds(text, result.study, [measure.name for measure in result.measures])
