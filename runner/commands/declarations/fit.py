"""The command `fit`: of temperature laws to tables, and of graphs to recordings; imported when it is called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.declarations.options import (
    Whole,
    blocks_option,
    duration_option,
    engine_option,
    file_argument,
    json_option,
    plot_option,
    quiet_option,
    seed_option,
    set_option,
)

_FILE = click.Path(dir_okay=False, path_type=Path)
_LAW = ("temperature", "offset", "orders", "start", "starts", "names", "duration", "engine")  # options of laws alone
_GRAPH = (  # options of graphs alone
    "files", "inputs", "free", "offsets", "delays", "levels", "loss", "tries", "skip", "gaps", "interpolated", "quiet",
)  # fmt: skip

_LAW_OPTIONS = (
    click.option("--temperature", metavar="COLUMN", help="Name the column, or signal of a graph, of the temperature."),
    click.option("--offset", type=float, default=0.0, show_default=True, help="Subtract this from the output first."),
    click.option(
        "--order",
        "orders",
        type=Whole(1, 6),
        multiple=True,
        default=(3, 4),
        show_default=True,
        help="Compare with a polynomial of this order; repeatable.",
    ),
    click.option(
        "--start",
        type=(float, float),
        metavar="B1 B2",
        help="Start the alternation from these exponents (default: those found by a scan).",
    ),
    click.option("--starts", is_flag=True, help="Try a grid of starts, and show from which both methods converge."),
    click.option(
        "--block", "names", multiple=True, help="Write to this block only; repeatable (default: every model)."
    ),
    duration_option,
    engine_option(),
)
_GRAPH_OPTIONS = (
    click.option(
        "--data", "files", multiple=True, type=_FILE, metavar="FILE", help="Fit to this recording; repeatable."
    ),
    click.option(
        "--input",
        "inputs",
        multiple=True,
        metavar="SIGNAL=COLUMN",
        help="Play a column in place of a signal; repeatable.",
    ),
    click.option(
        "--free",
        multiple=True,
        metavar="PARAMETER[=LOW..HIGH]",
        help='Fit this parameter, within bounds if given, as "100 N/m..200 N/m", or about what is expected, as '
        '"132 N/m +- 3 N/m"; repeatable.',
    ),
    click.option(
        "--free-offset", "offsets", multiple=True, metavar="SIGNAL", help="Also fit a constant offset of this output."
    ),
    click.option("--free-delay", "delays", multiple=True, metavar="SIGNAL", help="Also fit a delay of this output."),
    click.option("--free-noise", "levels", multiple=True, metavar="PARAMETER", help="Also fit this level of noise."),
    click.option(
        "--loss",
        type=click.Choice(["linear", "robust", "outliers"]),
        default="linear",
        show_default=True,
        help="Count large residuals fully, less, or hardly at all.",
    ),
    click.option("--tries", type=Whole(1, 1000), default=1, show_default=True, help="Start from this many points."),
    click.option(
        "--skip",
        default="0 s",
        show_default=True,
        metavar="TIME",
        help="Compare outputs from this time on, not before.",
    ),
    click.option(
        "--gaps",
        type=click.Choice(["refuse", "split"]),
        default="refuse",
        show_default=True,
        help="Refuse recordings with gaps, or cut them there.",
    ),
    click.option(
        "--interpolate", "interpolated", is_flag=True, help="Play inputs as straight lines between rows, not as steps."
    ),
    quiet_option,
)


def _options(command: Any) -> Any:
    for option in reversed((*_LAW_OPTIONS, *_GRAPH_OPTIONS)):
        command = option(command)
    return command


@click.command()
@file_argument("source", library=True)
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="COLUMN|SIGNAL[=COLUMN]",
    help="Name the measured quantity; repeatable.",
)
@_options
@plot_option("plot", "Draw readings, fits and residuals")
@click.option("--write", "target", type=_FILE, metavar="FILE", help="Write the fitted parameters into this graph file.")
@set_option
@seed_option("the graph")
@blocks_option
@json_option
def fit(**options: Any) -> int:
    """Fit a graph to recordings, or a temperature law to a table.

    With --data, parameters of the graph SOURCE are fitted to recordings. The answer has their values with intervals,
    their correlations, whether the residuals are white, and which parameters are not identifiable.
    Without --data, SOURCE is a table, or a graph that is run. Two exponentials are fitted to its output over
    temperature, and compared with polynomials.

    \b
    proofmass fit sensor.toml --data record.csv --input force.output=force --output readout.voltage=volts \\
        --free sensor.stiffness --free sensor.damping --plot fit.png --write sensor.toml
    proofmass fit graphs/library/temperature/zero_bias_m1.csv --plot fit.png
    proofmass fit sensor.toml --temperature thermometer.voltage --output readout.voltage --write sensor.toml
    """
    if options["files"] or options["free"]:
        # start-up time: a command imports what it needs itself
        from proofmass.runner.commands.fit_recordings_command import RecordingsRequest, fit_recordings

        _refuse(options, _LAW, "of temperature laws, not of graphs and recordings")
        return fit_recordings(RecordingsRequest(**{key: v for key, v in options.items() if key not in _LAW}))
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.fit_command import FitRequest, run_fit

    _refuse(options, _GRAPH, "of recordings, which --data names")
    outputs = options.pop("outputs")
    if len(outputs) > 1:
        raise click.UsageError("--output: a temperature law has one output")
    output = outputs[0] if outputs else None
    return run_fit(FitRequest(output=output, **{key: v for key, v in options.items() if key not in _GRAPH}))


def _refuse(options: dict[str, Any], names: tuple[str, ...], why: str) -> None:
    """Refuse options that belong to the other kind of fit."""
    parameters = {parameter.name: parameter for parameter in fit.params}
    context = click.get_current_context()
    wrong = [
        parameters[name].opts[0]
        for name in names
        if context.get_parameter_source(name) is not click.core.ParameterSource.DEFAULT
    ]
    if wrong:
        raise click.UsageError(f"{', '.join(wrong)}: {'an option' if len(wrong) == 1 else 'options'} {why}")
