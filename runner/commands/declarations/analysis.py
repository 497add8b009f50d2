"""The commands that say what a signal is made of; what they do is imported when they are called."""

from typing import Any

import click

from proofmass.runner.commands.completion import outputs
from proofmass.runner.commands.declarations.options import (
    Whole,
    at_option,
    blocks_option,
    duration_option,
    engine_option,
    file_argument,
    graph_argument,
    json_option,
    plot_option,
    seed_option,
    set_option,
)

_SIGNAL_FIELDS = ("source", "probe", "skip", "duration", "samples", "seed", "engine", "changes", "own", "as_json")
_SIGNAL = (
    click.option(
        "--probe",
        default="",
        metavar="BLOCK.PORT",
        shell_complete=outputs,
        help="Take this signal of a graph, or column of a file.",
    ),
    click.option(
        "--skip", default="0 s", show_default=True, metavar="TIME", help="Leave out the start, while it settles."
    ),
    duration_option,
    click.option("--samples", type=Whole(1), help="Run so many base ticks, instead of a duration."),
    seed_option("the graph"),
    engine_option(),
    set_option,
    blocks_option,
    json_option,
)


def _signal_options(command: Any) -> Any:
    for option in reversed(_SIGNAL):
        command = option(command)
    return command


def _signal(options: dict[str, Any]) -> Any:
    """Take what says which signal is meant out of the options of a command."""
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.series_source import SignalRequest

    return SignalRequest(**{field: options.pop(field) for field in _SIGNAL_FIELDS})


@click.command()
@file_argument("source", library=True)
@click.option("--window", default="", help="Window (default: hann of the density, blackman-harris-7 of the tone).")
@click.option(
    "--segment",
    type=Whole(0),
    help="Use segments of this many values; 0 for a single one (default: about an eighth).",
)
@click.option(
    "--band", nargs=2, metavar="FROM TO", help='Compute rms, noise and slope within this band, as "1 Hz" "100 Hz".'
)
@click.option(
    "--tone",
    default="",
    metavar="FREQUENCY",
    help="Look for a tone at this frequency (default: the largest in the band).",
)
@plot_option("picture", "Draw the density")
@_signal_options
def spectrum(**options: Any) -> int:
    """Show the spectrum of a signal.

    Noise density, rms in a band, and of a tone SNR, SNDR, THD, SFDR and ENOB.
    SOURCE is a graph, which is run, or a recording: CSV, Parquet or netCDF.

    \b
    proofmass spectrum sensor.toml --probe adc.number --band "1 Hz" "100 Hz"
    proofmass spectrum recording.csv --probe acceleration --plot density.png
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.spectrum_command import SpectrumRequest, show_spectrum

    return show_spectrum(SpectrumRequest(_signal(options), **options))


@click.command()
@file_argument("source", library=True)
@plot_option("picture", "Draw the deviation")
@click.option("--tau", metavar="TIME", help="Show how long to record for the deviation at this averaging time.")
@click.option(
    "--confidence", default="10 %", show_default=True, help="Aim at this standard error, relative to the deviation."
)
@_signal_options
def allan(**options: Any) -> int:
    """Show the Allan deviation of a signal.

    The coefficients N, B, K and Q of its noise are fitted, with intervals of 95 %.
    SOURCE is a graph, which is run, or a recording: CSV, Parquet or netCDF.

    \b
    proofmass allan recording.csv --probe rate --plot allan.png
    proofmass allan sensor.toml --probe readout.rate --duration "600 s"
    proofmass allan recording.csv --tau "100 s" --confidence "5 %"
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.allan_command import show_allan

    return show_allan(_signal(options), **options)


@click.command()
@graph_argument
@click.option(
    "--output",
    default="",
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Show the sources of the noise of this output (default: of every probe).",
)
@click.option(
    "--input",
    "source",
    default="",
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Refer the noise to this output of a source.",
)
@click.option(
    "--band", nargs=2, metavar="FROM TO", help='Count noise within this band, as "0.1 Hz" "100 Hz" (default: all).'
)
@at_option
@click.option("--derivatives", is_flag=True, help="Show how much each parameter changes the rms.")
@click.option(
    "--until",
    metavar="TIME",
    help="Show instead how far the value at this time, such as an estimate, differs from run to run.",
)
@plot_option("picture", "Draw the budget")
@set_option
@blocks_option
@json_option
def noise(**options: Any) -> int:
    """Show the noise budget of an output.

    It shows what each source contributes at the output and, with --input, at an input.

    \b
    proofmass noise sensor.toml --output adc.number --input acceleration.output --band "0.1 Hz" "100 Hz"
    proofmass noise library:closed_loop_accelerometer
    proofmass noise library:recorded_motion --output mean.mean --input motion.output --plot noise.png
    proofmass noise library:quartz_feedback_noise --output estimator.difference --until "500 s"
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.noise_command import NoiseRequest, show_noise

    return show_noise(NoiseRequest(**options))


@click.command("noise-model")
@click.option("--density", metavar="QUANTITY", help='One-sided white density, as "100 ug0/sqrt(Hz)".')
@click.option("--random-walk", "--arw", "--vrw", "white", metavar="QUANTITY", help='N, as "0.1 deg/sqrt(h)".')
@click.option("--bias-instability", metavar="QUANTITY", help='B, as "1 deg/h".')
@click.option("--flat", is_flag=True, help="The bias instability is the flat part of an Allan curve, 0.664 B.")
@click.option("--rate-random-walk", "--rrw", "wander", metavar="QUANTITY", help='K, as "1 deg/(h*sqrt(h))".')
@click.option(
    "--longest", default="10000 s", show_default=True, help="Longest averaging time that flicker must hold for."
)
@click.option("--rate", default="1 kHz", show_default=True, help="Rate of the blocks.")
@click.option("--unit", default="", help="Unit of the signal (default: rad/s or m/s^2, as the quantities say).")
def noise_model(**options: Any) -> int:
    """Write noise blocks from a data sheet.

    The answer is TOML to put into a graph.

    \b
    proofmass noise-model --arw "0.1 deg/sqrt(h)" --bias-instability "1 deg/h"
    proofmass noise-model --density "80 ug0/sqrt(Hz)" --bias-instability "5 ug0" --flat
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.noise_model_command import NoiseModelRequest, write_noise_model

    return write_noise_model(NoiseModelRequest(**options))


@click.command()
@graph_argument
@click.argument("input")
@click.argument("output")
@click.option(
    "--simulate",
    "stimulus",
    type=click.Choice(["sine", "multitone", "chirp", "prbs"]),
    help="Also run the graph with this stimulus added to the input, and compare.",
)
@click.option("--amplitude", metavar="QUANTITY", help='Peak value of the stimulus, as "10 mV".')
@click.option(
    "--band",
    nargs=2,
    metavar="FROM TO",
    help='Keep the stimulus within this band, as "1 Hz" "100 Hz" (default: about the bandwidth).',
)
@at_option
@plot_option("picture", "Draw it")
@set_option
@blocks_option
@json_option
def response(**options: Any) -> int:
    """Show how one output answers to another.

    Gain, phase, bandwidth, delay and the figures of a step, for small signals;
    with --simulate also by runs of the graph itself.
    INPUT and OUTPUT are outputs of blocks; a change of INPUT moves OUTPUT.

    \b
    proofmass response sensor.toml acceleration.output adc.number --plot response.png
    proofmass response sensor.toml acceleration.output adc.number --simulate multitone --amplitude "1 m/s^2"
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.response_command import ResponseRequest, show_response

    return show_response(ResponseRequest(**options))


ANALYSES = (spectrum, allan, noise, noise_model, response)
