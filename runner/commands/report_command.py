"""The command `report`: what has come out of a study, as one HTML file."""

from pathlib import Path

import click

from proofmass.runner.commands.run_command import own_blocks


def report_study(study: Path, output: Path | None, own: Path | None) -> int:
    """Everything that `proofmass report` does; returns the exit code."""
    from proofmass.runner.studies.kept.folder import find_folder, kept_result
    from proofmass.runner.studies.shown.report import FILE, save_study_report

    blocks = own_blocks(own)
    folder = study if study.is_dir() else find_folder(study, blocks)
    result = kept_result(folder, blocks)
    path = save_study_report(result, output or folder / FILE)
    click.echo(f"wrote {path}: {len(result.numbers):,} of {result.planned_runs:,} runs")
    return 0
