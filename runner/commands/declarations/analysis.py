"""The commands that say what a signal is made of."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.declarations.options import (
    AT,
    DURATION,
    PORT,
    Changed,
    Request,
    Whole,
    argument,
    band_option,
    engine_option,
    file_argument,
    flag,
    option,
    plot_option,
    seed_option,
)
from proofmass.runner.run.engine_table import EngineName


class OfSignal(Changed):
    """A command of a signal: of a graph, which is run, or of a recording."""

    source: Path = file_argument(library=True)
    probe: str = option(
        "Take this signal of a graph, entry of a vector (join.output[0]), or column of a file"
        " (default: probes, or the first column).",
        default="",
        **PORT,
    )
    skip: str = option("Leave out the start, while it settles.", default="0 s", metavar="TIME")
    duration: str | None = DURATION
    samples: int | None = option("Run so many base ticks, instead of a duration.", type=Whole(1))
    seed: int | None = seed_option("as the graph says")
    engine: EngineName = engine_option()


class SpectrumRequest(OfSignal, does="spectrum_command.show_spectrum"):
    """Show the spectrum of a signal.

    Noise density, rms in a band, and of a tone SNR, SNDR, THD, SFDR and ENOB.
    SOURCE is a graph, which is run, or a recording: CSV, Parquet or netCDF.

    \b
    proofmass spectrum library:template --probe adc.number --band "10 Hz" "1 kHz"
    proofmass spectrum library:recorded_motion.csv --probe acceleration --plot density.png
    """

    window: str = option("Window (default: hann of the density, blackman-harris-7 of the tone).", default="")
    segment: int | None = option(
        "Use segments of this many values; 0 for a single one (default: about an eighth).", type=Whole(0)
    )
    band: tuple[str, str] | None = band_option('Compute rms, noise and slope within this band, as "1 Hz" "100 Hz".')
    tone: str = option(
        "Look for a tone at this frequency (default: the largest in the band).", default="", metavar="FREQUENCY"
    )
    picture: Path | None = plot_option("Draw the density")


class AllanRequest(OfSignal, does="allan_command.show_allan"):
    """Show the Allan deviation of a signal.

    The coefficients N, B, K and Q of its noise are fitted, with intervals of 95 %.
    SOURCE is a graph, which is run, or a recording: CSV, Parquet or netCDF.

    \b
    proofmass allan library:recorded_motion.csv --probe acceleration --plot allan.png
    proofmass allan library:open_loop_gyroscope --probe output.output --duration "2 s"
    proofmass allan library:recorded_motion.csv --probe acceleration --tau "1 s" --confidence "5 %"
    """

    picture: Path | None = plot_option("Draw the deviation")
    tau: str | None = option("Show how long to record for the deviation at this averaging time.", metavar="TIME")
    confidence: str = option("Aim at this standard error, relative to the deviation.", default="10 %")


class NoiseRequest(Changed, does="noise_command.show_noise"):
    """Show the noise budget of an output.

    It shows what each source contributes at the output and, with --input, at an input.

    \b
    proofmass noise library:template --output adc.number --input acceleration.output --band "0.1 Hz" "100 Hz"
    proofmass noise library:closed_loop_accelerometer
    proofmass noise library:recorded_motion --output mean.mean --input motion.output --plot noise.png
    proofmass noise library:quartz_feedback_noise --output estimator.difference --until "500 s"
    """

    graph: Path = file_argument(library=True)
    output: str = option(
        "Show the sources of the noise of this output (default: of every probe, else of the last blocks).",
        default="",
        **PORT,
    )
    source: str = option("Refer the noise to this output of a source.", "--input", default="", **PORT)
    band: tuple[str, str] | None = band_option('Count noise within this band, as "0.1 Hz" "100 Hz" (default: all).')
    at: str = AT
    derivatives: bool = flag("Show how much each parameter changes the rms.")
    until: str | None = option(
        "Show instead how far the value at this time, such as an estimate, differs from run to run.", metavar="TIME"
    )
    picture: Path | None = plot_option("Draw the budget")


class NoiseModelRequest(Request, does="noise_model_command.write_noise_model"):
    """Write noise blocks from a data sheet.

    The answer is TOML to put into a graph.

    \b
    proofmass noise-model --arw "0.1 deg/sqrt(h)" --bias-instability "1 deg/h"
    proofmass noise-model --density "80 ug0/sqrt(Hz)" --bias-instability "5 ug0" --flat
    """

    density: str | None = option('One-sided white density, as "100 ug0/sqrt(Hz)".', metavar="QUANTITY")
    white: str | None = option('N, as "0.1 deg/sqrt(h)".', "--random-walk", "--arw", "--vrw", metavar="QUANTITY")
    bias_instability: str | None = option('B, as "1 deg/h".', metavar="QUANTITY")
    flat: bool = flag("The bias instability is the flat part of an Allan curve, 0.664 B.")
    wander: str | None = option('K, as "1 deg/(h*sqrt(h))".', "--rate-random-walk", "--rrw", metavar="QUANTITY")
    longest: str = option("Longest averaging time that flicker must hold for.", default="10000 s")
    rate: str = option("Rate of the blocks.", default="1 kHz")
    unit: str = option("Unit of the signal (default: rad/s or m/s^2, as the quantities say).", default="")


class ResponseRequest(Changed, does="response_command.show_response"):
    """Show how one output answers to another.

    Gain, phase, bandwidth, delay and the figures of a step, for small signals;
    with --simulate also by runs of the graph itself.
    INPUT and OUTPUT are outputs of blocks; a change of INPUT moves OUTPUT.
    Without them these are the only source, and all probes.

    \b
    proofmass response library:template acceleration.output adc.number --plot response.png
    proofmass response library:template acceleration.output adc.number --simulate multitone \\
        --amplitude "1 m/s^2"
    """

    graph: Path = file_argument(library=True)
    input: str = argument(required=False, default="")
    output: str = argument(required=False, default="")
    simulate: Any = option(
        "Also run the graph with this stimulus added to the input, and compare.",
        type=click.Choice(["sine", "multitone", "chirp", "prbs"]),
    )
    amplitude: str | None = option('Peak value of the stimulus, as "10 mV".', metavar="QUANTITY")
    band: tuple[str, str] | None = band_option(
        'Keep the stimulus within this band, as "1 Hz" "100 Hz" (default: about the bandwidth).'
    )
    at: str = AT
    picture: Path | None = plot_option("Draw it")
