"""The commands that find parameters."""

from pathlib import Path

import click

from proofmass.runner.commands.declarations.options import (
    PORT,
    QUIET,
    SET,
    Answered,
    LibraryFile,
    Whole,
    argument,
    band_option,
    file_argument,
    file_option,
    flag,
    option,
    plot_option,
    seed_option,
    several,
)

TOLERANCES = several(
    'Vary a parameter by "5 %", by "0.1 V", or within "4.9 V..5.2 V"; repeatable.',
    "--tolerance",
    metavar="PARAMETER=WIDTH",
)


class TuneRequest(Answered, does="tune_command.show_tuning"):
    """Find parameters that meet the goals of a graph.

    GRAPH has a table [tune]: free parameters with bounds, and goals for margins, noise, scale factor or measures.
    The answer says which goal binds. Exit code 1 if no parameters meet all hard goals. Ctrl-C ends the search; the
    best point so far is the answer.

    \b
    proofmass tune library:closed_loop_accelerometer --plot tuned.png --write tuned.toml
    proofmass tune library:closed_loop_accelerometer --set pickoff.gain=9000 --samples 8
    """

    graph: Path = file_argument(library=True)
    target: Path | None = file_option(
        "Write the tuned graph, with its comments, to this file; it may be GRAPH itself.", "--write"
    )
    picture: Path | None = plot_option("Draw parameters, goals and loops before and after")
    starts: int | None = option("Start from this many samples (default: as the graph says).", type=Whole(1, 100))
    samples: int | None = option("Try this many points first (default: as the graph says).", type=Whole(1, 100000))
    seed: int | None = seed_option("as the graph says", "these points")
    changes: tuple[str, ...] = SET
    quiet: bool = QUIET


class WorstRequest(Answered, does="worst_command.show_worst"):
    """Find how bad a graph can get within tolerances.

    SOURCE is a graph, or a study, whose spread counts as tolerances: three standard deviations of normal parameters.
    The answer has the worst case of each quantity, the effect of each parameter alone, and the number of points tried.
    Without a quantity it takes the gain and phase margins of all named loops.

    \b
    proofmass worst library:margin_tolerance_study --samples 20
    proofmass worst library:closed_loop_accelerometer --tolerance "torquer.gain=5 %" --figure main:phase_margin \\
        --plot worst.png
    """

    source: Path = file_argument(library=True)
    figures: tuple[str, ...] = several(
        "Find the worst case of this figure, as main:phase_margin; repeatable.", "--figure", metavar="LOOP:FIGURE"
    )
    noises: tuple[str, ...] = several("Find the worst noise of this output.", "--noise", **PORT)
    scale_factors: tuple[str, ...] = several("Find the worst scale factor of this output.", "--scale-factor", **PORT)
    biases: tuple[str, ...] = several("Find the worst value of this output at zero input.", "--bias", **PORT)
    responses: tuple[str, ...] = several(
        "Find the worst response of this output, as adc.number:bandwidth or adc.number:gain@100Hz; repeatable.",
        "--response",
        metavar="BLOCK.PORT:FIGURE",
    )
    measures: tuple[str, ...] = several("Find the worst case of this measure; repeatable.", "--measure", metavar="NAME")
    yields: tuple[str, ...] = several(
        'Find the worst yield of the study for this limit of it, or "all", within --tolerance; repeatable.',
        "--yield",
        metavar="LIMIT",
    )
    source_signal: str = option(
        "Count scale factors and responses from this output of a source, and refer noise to it.",
        "--input",
        default="",
        **PORT,
    )
    band: tuple[str, str] | None = band_option('Count noise within this band, as "1 Hz" "100 Hz" (default: all).')
    tolerances: tuple[str, ...] = TOLERANCES
    at: str = option('Linearise at this time, or "settled" (default: the start).', default="", metavar="TIME")
    corners: int = option(
        "Try all corners if there are no more than this.", type=Whole(0, 2**20), default=256, show_default=True
    )
    samples: int = option("Try this many random points.", type=Whole(1, 10**6), default=100, show_default=True)
    seed: int | None = seed_option("0", "the random points")
    runs: int | None = option(
        "Run this many sensors of the study and show their yields too (default: none).", type=Whole(1, 10**9)
    )
    picture: Path | None = plot_option("Draw the effect of each parameter alone, and of all together")
    changes: tuple[str, ...] = SET
    quiet: bool = QUIET


class ProveRequest(Answered, does="prove_command.show_proofs"):
    """Prove margins over tolerances, for every sensor.

    SOURCE is a graph, or a study, whose spread counts as tolerances: three standard deviations of normal parameters.
    Each claim is proved, refuted by a sensor that you can try, or open. The limits are those that loops require, else
    6 dB and 45 deg. Exit code 1 if a claim is not proved. Ctrl-C ends the search with what is proved.

    \b
    proofmass prove library:closed_loop_accelerometer
    proofmass prove library:closed_loop_accelerometer --tolerance "torquer.gain=10 %" \\
        --tolerance "pendulum.inertia=10 %" --gain-margin "20 dB" --out proof.json
    proofmass prove library:closed_loop_accelerometer --tolerance "torquer.gain=5 %" --bounds
    """

    source: Path = file_argument(library=True)
    tolerances: tuple[str, ...] = TOLERANCES
    loop: str = option("Prove this loop alone, by its name or an output at which it is opened.", default="", **PORT)
    gain_margin: str = option("Prove this gain margin, up and down (default: 6 dB).", default="", metavar="DB")
    phase_margin: str = option("Prove this phase margin (default: 45 deg).", default="", metavar="DEG")
    bounds: bool = flag("Also look for the largest margins that can be proved, and for the least there are.")
    seconds: float = option(
        "Search for this long.", type=click.FloatRange(0.0, 1e6), default=60.0, show_default=True, metavar="SECONDS"
    )
    target: Path | None = file_option("Write a certificate that check-proof verifies.", "-o", "--out", "--output")
    changes: tuple[str, ...] = SET
    quiet: bool = QUIET


class CheckProofRequest(Answered, does="prove_command.check_proof"):
    """Check a certificate that `prove --out` wrote.

    The checker shares no code with the search. It verifies every box in whole numbers, and says what it takes for
    granted. With GRAPH it also says whether the certificate is about that graph. Exit code 1 if it proves nothing.

    \b
    proofmass prove library:closed_loop_accelerometer --out proof.json
    proofmass check-proof proof.json library:closed_loop_accelerometer
    """

    certificate: Path = file_argument()
    graph: Path | None = argument(type=LibraryFile(dir_okay=False, path_type=Path), required=False)


DESIGN = (
    TuneRequest,
    WorstRequest,
    ProveRequest,
    CheckProofRequest,
)
