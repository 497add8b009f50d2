"""The commands that find parameters."""

from pathlib import Path

import click

from proofmass.runner.commands.declarations.options import (
    JSON,
    PORT,
    QUIET,
    SET,
    Answered,
    LibraryFile,
    Request,
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
    'Vary a parameter by "5 %", which is "0.05", by "0.1 V", or within "4.9 V..5.2 V"; repeatable.',
    "--tolerance",
    metavar="PARAMETER=WIDTH",
)


class TuneRequest(Answered, does="tune_command.show_tuning"):
    """Find parameters that meet the goals of a graph.

    GRAPH has a table [tune]: free parameters with bounds, and goals for margins, noise, scale
    factor or measures. The answer says which goal binds. Exit code 1 if no parameters meet all hard
    goals. Ctrl-C ends the search; the best point so far is the answer.

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

    SOURCE is a graph, or a study, whose spread counts as tolerances: three standard deviations of
    normal parameters. The answer has the worst case of each quantity, the effect of each parameter
    alone, and the number of points tried. Without a quantity it takes the gain and phase margins of
    all loops.

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
    at: str = option(
        'Linearise at this time, or "settled" (default: where there is an answer).', default="", metavar="TIME"
    )
    corners: int = option("Try all corners if there are no more than this.", type=Whole(0, 2**20), default=256)
    samples: int = option("Try this many random points.", type=Whole(1, 10**6), default=100)
    seed: int | None = seed_option("0", "the random points")
    runs: int | None = option(
        "Run this many sensors of the study and show their yields too (default: none).", type=Whole(1, 10**9)
    )
    picture: Path | None = plot_option("Draw the effect of each parameter alone, and of all together")
    changes: tuple[str, ...] = SET
    quiet: bool = QUIET


class ProveRequest(Answered, does="prove_command.show_proofs"):
    """Prove margins, scale factors, peaks and noise over tolerances.

    SOURCE is a graph, or a study, whose spread counts as tolerances: three standard deviations of
    normal parameters. Each claim is proved, refuted by a sensor that you can try, or open. The
    limits are those that loops require, else 6 dB and 45 deg. Exit code 1 if a claim is not proved.
    Ctrl-C ends the search with what is proved. With --out it is kept in the certificate, and the
    same command goes on from there.

    \b
    proofmass prove library:closed_loop_accelerometer
    proofmass prove library:closed_loop_accelerometer --tolerance "torquer.gain=10 %" \\
        --tolerance "pendulum.inertia=10 %" --gain-margin "20 dB" --out proof.json
    proofmass prove library:closed_loop_accelerometer --tolerance "torquer.gain=5 %" --bounds
    proofmass prove library:closed_loop_accelerometer --tolerance "torquer.gain=5 %" --disk-margin 0.5 \\
        --delay-margin "300 us" --decay-rate "50 1/s"
    proofmass prove library:closed_loop_accelerometer --tolerance "torquer.gain=5 %" --input acceleration.output \\
        --scale-factor "dac.code=-9300..-8400" --noise dac.code=0.32
    """

    source: Path = file_argument(library=True)
    tolerances: tuple[str, ...] = TOLERANCES
    loop: str = option("Prove this loop alone, by its name or an output at which it is opened.", default="", **PORT)
    gain_margin: str = option("Prove this gain margin, up and down (default: 6 dB).", default="", metavar="DB")
    phase_margin: str = option("Prove this phase margin (default: 45 deg).", default="", metavar="DEG")
    disk_margin: str = option(
        "Prove this disk margin, of gain and phase at once, below 2.", default="", metavar="NUMBER"
    )
    delay_margin: str = option("Prove that no delay up to this makes a loop unstable.", default="", metavar="TIME")
    decay_rate: str = option('Prove that the slowest pole decays this fast, as "50 1/s".', default="", metavar="RATE")
    scale_factors: tuple[str, ...] = several(
        "Prove limits of this output's scale factor, as adc.number=1.9..2.1, or the nearest without any; repeatable.",
        "--scale-factor",
        metavar="BLOCK.PORT=LIMITS",
    )
    biases: tuple[str, ...] = several(
        "Prove limits of the value at which this output rests, as adc.number=-2..2, or the nearest; repeatable.",
        "--bias",
        metavar="BLOCK.PORT=LIMITS",
    )
    peaks: tuple[str, ...] = several(
        "Prove a limit of the gain to this output at all frequencies, as adc.number=3, or the least; repeatable.",
        "--peak",
        metavar="BLOCK.PORT=LIMIT",
    )
    noises: tuple[str, ...] = several(
        "Prove a limit of this output's rms noise, as adc.number=0.4, or the nearest without one; repeatable.",
        "--noise",
        metavar="BLOCK.PORT=LIMIT",
    )
    source_signal: str = option(
        "Count scale factors and peaks from this output of a source; biases are those at zero.",
        "--input",
        default="",
        **PORT,
    )
    at: str = option(
        'Prove claims about "0 s", the start, or about "settled", rest or an orbit (default: where it is known).',
        default="auto",
        show_default=False,
        metavar="TIME",
    )
    constants: tuple[str, ...] = several(
        "Give this output of a source a constant value, as step.output=0, so that the sensor can rest; repeatable.",
        "--constant",
        metavar="BLOCK.PORT=VALUE",
    )
    no_overflow: bool = flag(
        "Prove that no number of a block in fixed point overflows, or show inputs by which one does."
    )
    roundings: tuple[str, ...] = several(
        "Prove a limit of what rounding adds to this output in fixed point, or the least without one; repeatable.",
        "--rounding",
        metavar="BLOCK.PORT=LIMIT",
    )
    input_ranges: tuple[str, ...] = several(
        "Let this wire into a FixedQuantiser have these values alone, as source.output=-1..1; repeatable.",
        "--input-range",
        metavar="BLOCK.PORT=RANGE",
    )
    counterexample: Path | None = file_option(
        "Write the graph of a run in which something overflows, with its inputs.", "--counterexample"
    )
    any_change: bool = flag("Let parameters change within their tolerances from period to period, however fast.")
    slow_changes: tuple[str, ...] = several(
        'Let parameters change so fast, as "1 %/s", or one of them, as "torquer.gain=1 %/s"; repeatable.',
        "--slow-change",
        metavar="RATE",
    )
    bounds: bool = flag("Also look for the best limits that can be proved, and for the worst there are.")
    seconds: float = option("Search for this long.", type=click.FloatRange(0.0, 1e6), default=60.0, metavar="SECONDS")
    workers: int | None = option("Use this many processes (default: one per processor).", type=Whole(1, 1024))
    target: Path | None = file_option(
        "Write a certificate that check-proof verifies, and go on from what is there.", "-o", "--out", "--output"
    )
    changes: tuple[str, ...] = SET
    quiet: bool = QUIET


class CheckProofRequest(Answered, does="prove_command.check_proof"):
    """Check a certificate that `prove --out` wrote.

    The checker shares no code with the search. It verifies every box in whole numbers, and says
    what it takes for granted. With GRAPH it also says whether the certificate is about that graph.
    Exit code 1 if it proves nothing.

    \b
    proofmass prove library:closed_loop_accelerometer --out proof.json
    proofmass check-proof proof.json library:closed_loop_accelerometer
    """

    certificate: Path = file_argument()
    graph: Path | None = argument(type=LibraryFile(dir_okay=False, path_type=Path), required=False)


class SigmaDeltaRequest(Request, does="sigma_delta_command.show_modulator"):
    """Design the loop of a sigma-delta modulator.

    The answer has the noise transfer function, the coefficients of the loop filter, and signal to
    noise ratios over amplitude, predicted and simulated. With --out you get a graph, in which the
    coefficients are named values.

    \b
    proofmass sigma-delta --order 3 --oversampling 64 --out loop.toml
    proofmass sigma-delta --order 4 --oversampling 64 --centre 0.25 --plot loop.svg
    proofmass sigma-delta --order 3 --oversampling 64 --form CIFF --pulse 0 1 --rate "3.072 MHz" \\
        --out analog.toml
    """

    order: int = option("Order of the loop.", type=Whole(1, 8), default=3)
    oversampling: float = option("Rate over twice the band.", type=click.FloatRange(2.0, 1e6), default=64.0)
    gain: float = option("Gain of the noise far from the band.", type=float, default=1.5)
    zeros: str = option(
        "Place the zeros for the least noise in the band, so but two of an even number at its centre, or all there.",
        type=click.Choice(("optimised", "centred", "none")),
        default="optimised",
    )
    form: str = option(
        "Chain integrators (CI) or resonators (CR), with feedback (FB) or feed-forward (FF).",
        type=click.Choice(("CIFB", "CRFB", "CIFF", "CRFF"), case_sensitive=False),
        default="CRFB",
    )
    centre: float = option("Centre of the band of a band pass, relative to the rate.", type=float, default=0.0)
    levels: int = option("Levels of the quantiser.", type=Whole(2, 65536), default=2)
    feeds: str = option(
        "Feed the input to the first state, or to all.", type=click.Choice(("first", "all")), default="first"
    )
    pulse: tuple[float, float] | None = option(
        "Make the loop filter one of continuous time, for a feedback pulse between these parts of a period.",
        type=(float, float),
        metavar="FROM TO",
    )
    swing: float = option(
        "Scale the states to this swing at the peak; 0 leaves them.", type=click.FloatRange(0.0, 1e6), default=1.0
    )
    rate: str = option("Rate of the graph.", default="1 MHz", metavar="RATE")
    target: Path | None = file_option("Write the graph to this file.", "-o", "--out", "--output")
    picture: Path | None = plot_option("Draw the gain of the noise, and signal to noise over amplitude")
    as_json: bool = JSON
