"""The command `report`: what the folder of a study holds, as one HTML file."""

from pathlib import Path

import click

from proofmass.runner.commands.run_command import own_blocks


def report_folder(folder: Path, output: Path | None, own: Path | None) -> int:
    """Everything that `proofmass report` does; returns the exit code."""
    from proofmass.runner.studies.folder import kept_result
    from proofmass.runner.studies.report import FILE, save_study_report

    result = kept_result(folder, own_blocks(own))
    path = save_study_report(result, output or folder / FILE)
    click.echo(f"wrote {path}: {len(result.numbers):,} of {result.planned_runs:,} runs")
    return 0
