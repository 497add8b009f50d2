"""The command `report`: a study, ended or under way, as one HTML file."""

import time
from pathlib import Path

from proofmass.runner.commands.answers import print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.progress import working
from proofmass.runner.commands.study_data import study_data
from proofmass.runner.output.times import time_text
from proofmass.runner.studies.kept.folder import find_folder, kept_result
from proofmass.runner.studies.shown.report import FILE, save_study_report


def report_study(study: Path, output: Path | None, own: Path | None, as_json: bool) -> int:
    """Write the report of a study and return the exit code."""
    blocks = own_blocks(own)
    folder = study if study.is_dir() else find_folder(study, blocks)
    result = kept_result(folder, blocks)
    began = time.perf_counter()
    with working(as_json, "writing the report"):
        path = save_study_report(result, output or folder / FILE)
    seconds = time_text(time.perf_counter() - began)
    wrote = f"wrote {path}: {len(result.numbers):,} of {result.planned_runs:,} runs, in {seconds}"
    print_text([wrote], err=as_json)
    if as_json:
        print_json(study_data(result) | {"report": str(path)})
    return DONE
