"""The command `fit`: of temperature laws to tables, and of graphs to recordings."""

from collections.abc import Iterator
from pathlib import Path

import click

from proofmass.runner.commands.declarations.options import (
    DURATION,
    QUIET,
    SET,
    Answered,
    Request,
    Whole,
    engine_option,
    file_argument,
    file_option,
    flag,
    option,
    plot_option,
    seed_option,
    several,
)
from proofmass.runner.run.engine_table import EngineName


class OfLaw(Request):
    """Options of temperature laws alone."""

    temperature: str | None = option("Name the column, or signal of a graph, of the temperature.", metavar="COLUMN")
    offset: float = option("Subtract this from the output first.", type=float, default=0.0)
    orders: tuple[int, ...] = several(
        "Compare with a polynomial of this order; repeatable.", "--order", type=Whole(1, 6), default=(3, 4)
    )
    start: tuple[float, float] | None = option(
        "Start the alternation from these exponents (default: those found by a scan).",
        type=(float, float),
        metavar="B1 B2",
    )
    starts: bool = flag("Try a grid of starts, and show from which both methods converge.")
    names: tuple[str, ...] = several("Write to this block only; repeatable (default: every model).", "--block")
    duration: str | None = DURATION
    engine: EngineName = engine_option()


class OfRecordings(Request):
    """Options of graphs and recordings alone."""

    files: tuple[Path, ...] = several(
        "Fit to this recording; repeatable.", "--data", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE"
    )
    inputs: tuple[str, ...] = several(
        "Play a column in place of a signal; repeatable.", "--input", metavar="SIGNAL=COLUMN"
    )
    free: tuple[str, ...] = several(
        'Fit this parameter, within bounds if given, as "100 N/m..200 N/m", or about what is expected, as '
        '"132 N/m +- 3 N/m"; repeatable.',
        metavar="PARAMETER[=LOW..HIGH]",
    )
    offsets: tuple[str, ...] = several("Also fit a constant offset of this output.", "--free-offset", metavar="SIGNAL")
    delays: tuple[str, ...] = several("Also fit a delay of this output.", "--free-delay", metavar="SIGNAL")
    levels: tuple[str, ...] = several("Also fit this level of noise.", "--free-noise", metavar="PARAMETER")
    loss: str = option(
        "Count large residuals fully, less, or hardly at all.",
        type=click.Choice(["linear", "robust", "outliers"]),
        default="linear",
    )
    tries: int = option("Start from this many points.", type=Whole(1, 1000), default=1)
    skip: str = option("Compare outputs from this time on, not before.", default="0 s", metavar="TIME")
    gaps: str = option(
        "Refuse recordings with gaps, or cut them there.",
        type=click.Choice(["refuse", "split"]),
        default="refuse",
    )
    interpolated: bool = flag("Play inputs as straight lines between rows, not as steps.", "--interpolate")
    quiet: bool = QUIET


class _Written(Answered):
    """Options that stand behind those of both kinds."""

    plot: Path | None = plot_option("Draw readings, fits and residuals")
    target: Path | None = file_option("Write the fitted parameters into this graph file.", "--write")
    changes: tuple[str, ...] = SET
    seed: int | None = seed_option("as the graph says")


class FitRequest(OfLaw, OfRecordings, _Written, does="fit_command.run_fit"):
    """Fit a graph to recordings, or a temperature law to a table.

    With --data, parameters of the graph SOURCE are fitted to recordings. The answer has their
    values with intervals, their correlations, whether the residuals are white, and which parameters
    are not identifiable.
    Without --data, SOURCE is a table, or a graph that is run. Two exponentials are fitted to its
    output over temperature, and compared with polynomials.

    \b
    proofmass new sensor.toml
    proofmass run sensor.toml --probe inertia.output --set sensor.damping=4e-3 --out record --format csv
    proofmass fit sensor.toml --data record/traces.csv --input inertia.output=inertia.output \\
        --output sensor.displacement=sensor.displacement --free sensor.damping --plot fit.png --write sensor.toml
    proofmass fit library:zero_bias_m1.csv --plot law.png
    proofmass fit library:temperature_compensation_m1 --temperature thermometer.voltage \\
        --output noisy.output
    """

    source: Path = file_argument(library=True)
    outputs: tuple[str, ...] = several(
        "Name the measured quantity; repeatable.", "--output", metavar="COLUMN|SIGNAL[=COLUMN]"
    )

    def check(self) -> None:
        if self.of_recordings:
            _refuse(OfLaw, "of temperature laws, not of graphs and recordings")
            self._check_recordings()
        else:
            _refuse(OfRecordings, "of recordings, which --data names")
            self._check_law()

    @property
    def of_recordings(self) -> bool:
        """True if a graph is fitted to recordings, instead of a law to a table."""
        return bool(self.files or self.free)

    @property
    def of_graph(self) -> bool:
        """True if a graph is run, instead of a table read."""
        return self.source.suffix.lower() == ".toml"

    @property
    def output(self) -> str | None:
        """The one output of a temperature law."""
        return self.outputs[0] if self.outputs else None

    def _check_recordings(self) -> None:
        if not self.files:
            raise click.UsageError("--free needs --data, the recordings to fit to")
        if not self.outputs:
            raise click.UsageError("name what was recorded: --output BLOCK.PORT=COLUMN")

    def _check_law(self) -> None:
        if len(self.outputs) > 1:
            raise click.UsageError("--output: a temperature law has one output")
        if self.names and self.target is None:
            raise click.UsageError("--block needs --write, the graph file that it is in")
        if self.of_graph and not (self.temperature and self.output):
            raise click.UsageError("of a graph, name the signals: --temperature BLOCK.PORT --output BLOCK.PORT")
        options = {"--set": bool(self.changes), "--duration": bool(self.duration), "--seed": self.seed is not None}
        wrong = [option for option, said in options.items() if said]
        if wrong and not self.of_graph:
            raise click.UsageError(f"{', '.join(wrong)}: only for a graph, which {self.source.name} is not")


def _refuse(kind: type[Request], why: str) -> None:
    """Refuse options that belong to the other kind of fit."""
    wrong = list(_said(kind))
    if wrong:
        raise click.UsageError(f"{', '.join(wrong)}: {'an option' if len(wrong) == 1 else 'options'} {why}")


def _said(kind: type[Request]) -> Iterator[str]:
    """Yield the options of a kind that stand on the command line."""
    context = click.get_current_context()
    for name, row in kind.rows():
        if context.get_parameter_source(name) is not click.core.ParameterSource.DEFAULT:
            yield row.of_click(name).opts[0]
