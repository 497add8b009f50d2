"""The commands that compare and verify."""

from pathlib import Path

import click

from proofmass.runner.commands.declarations.options import (
    Answered,
    Changed,
    LibraryFile,
    Whole,
    argument,
    engine_option,
    file_argument,
    file_option,
    flag,
    option,
)
from proofmass.runner.run.engine_table import EngineName


class DiffRequest(Answered, does="diff_command.show_differences"):
    """Show how two graphs, two runs or two studies differ.

    BEFORE and AFTER are graph files, which are compared by what they mean, or folders that `run
    --out` or `montecarlo --out` wrote. Of studies the answer says which means and yields moved by
    more than sensors scatter. Exit code 1 if something differs.

    \b
    proofmass diff library:closed_loop_accelerometer library:scale_factor_drift
    proofmass run library:template --out before
    proofmass run library:template --set adc.bits=14 --out after
    proofmass diff before after --tolerance 1e-9 --html changes.html
    """

    before: Path = argument(type=LibraryFile(path_type=Path))
    after: Path = argument(type=LibraryFile(path_type=Path))
    relative: float = option(
        "Allow this difference of traces and measures, relative to the largest value before.",
        "--tolerance",
        type=click.FloatRange(0.0),
        default=0.0,
    )
    absolute: float = option(
        "Allow this difference of traces and measures, in their units.", type=click.FloatRange(0.0), default=0.0
    )
    page: Path | None = file_option("Write the tables as one HTML file.", "--html")


class VerifyRequest(Changed, does="verify_command.verify_graph"):
    """Check a graph against its requirements and golden results.

    Requirements are those of the table [requirements] and of the loops; a run, margins and the
    study are computed if one needs them. Exit code 1 if one is missed.

    \b
    proofmass verify library:closed_loop_accelerometer --junit findings.xml
    proofmass new sensor.toml --from closed_loop_accelerometer
    proofmass verify sensor.toml --record
    """

    graph: Path = file_argument(library=True)
    runs: int | None = option(
        "Simulate this many sensors for yields (default: as the study says).", type=Whole(1, 2**32)
    )
    record: bool = flag("Record measures and margins as golden results, beside the graph.")
    golden: Path | None = file_option(
        "Compare with these golden results, or record them there (default: GRAPH.golden.json, if it is there)."
    )
    junit: Path | None = file_option("Write the findings as JUnit XML.")
    page: Path | None = file_option("Write the findings as one HTML file.", "--html")
    engine: EngineName = engine_option()
