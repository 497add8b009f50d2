"""What the shell sees: one command per job, imported when it is called."""

import os
import sys
from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.analysis_declarations import ANALYSES
from proofmass.runner.commands.failures import DONE, INTERRUPTED, USAGE, explain
from proofmass.runner.commands.options import blocks_option, graph_argument, json_option, set_option
from proofmass.runner.commands.rtl_command import rtl
from proofmass.runner.host.versions import PROOFMASS


class Commands(click.Group):
    """Commands with "did you mean"."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError:
            from proofmass.blocks.declaration.problem import did_you_mean

            raise click.UsageError(
                f"no such command: {args[0]}; {did_you_mean(args[0], self.commands, 'command')}", ctx
            ) from None


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120})
@click.version_option(PROOFMASS, prog_name="proofmass")
@click.option("--traceback", is_flag=True, help="Show Python's traceback of an error; it may stand anywhere.")
def cli(traceback: bool) -> None:
    """Block-diagram dataflow simulator for inertial sensors.

    \b
    proofmass new sensor.toml         a commented graph to start from
    proofmass check sensor.toml       everything that is wrong with it, at once
    proofmass run sensor.toml --out results
    """


@cli.command()
@graph_argument
@click.option("--duration", help='How long, for example "2 s"; both ends are run.')
@click.option("--samples", type=click.IntRange(1), help="How many ticks of the base rate, instead of a duration.")
@click.option("--seed", type=click.IntRange(0, 2**62), help="Seed of the noise.")
@click.option(
    "--engine", type=click.Choice(["auto", "python", "compiled", "cxxrtl"]), default="auto", show_default=True
)
@set_option
@click.option("--probe", "probes", multiple=True, metavar="BLOCK.PORT", help="Record one more signal.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Folder for traces, plot and report.")
@click.option(
    "--format", "formats", multiple=True, type=click.Choice(["netcdf", "csv", "parquet"]), help="Files of traces."
)
@click.option("--resume", is_flag=True, help="Go on from the checkpoint of an interrupted run in --out.")
@click.option("--show-source", is_flag=True, help="Print the generated loop instead of running it.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
@blocks_option
@json_option
def run(**options: Any) -> int:
    """Run a graph once and show what its probes recorded.

    \b
    proofmass run graphs/library/closed_loop_accelerometer.toml
    proofmass run sensor.toml --duration "2 s" --set adc.bits=24 --out results
    """
    from proofmass.runner.commands.run_command import run_graph

    return run_graph(**options)


@cli.command()
@graph_argument
@blocks_option
@json_option
def check(graph: Path, own: Path | None, as_json: bool) -> int:
    """Say everything that is wrong with a graph or a study; exit 1 when it cannot run, or its loops miss a margin.

    The files that it names are read, and it is planned as for a run.

    \b
    proofmass check sensor.toml
    """
    from proofmass.runner.commands.check_command import check_graph

    return check_graph(graph, own, as_json)


@cli.command()
@graph_argument
@click.option("--loop", default="", metavar="NAME", help="One loop: by its name, or by the output to open it at.")
@click.option("--at", default="0 s", show_default=True, help='Operating point: a time, or "settled".')
@click.option(
    "--sensitivity",
    nargs=2,
    metavar="INPUT OUTPUT",
    help="What each parameter does to scale factor and bias between two outputs, and to the margins.",
)
@click.option(
    "--gain", "gains", multiple=True, metavar="BLOCK=GAIN", help="Count a quantiser, comparator or relay as a gain."
)
@click.option(
    "--amplitude",
    "amplitudes",
    multiple=True,
    metavar="BLOCK=AMPLITUDE",
    help="Count it as the gain that it has for a sine of that amplitude: its describing function.",
)
@click.option("--limit-cycle", default="", metavar="BLOCK", help="Predict limit cycles by its describing function.")
@click.option("--plot", "picture", type=click.Path(dir_okay=False, path_type=Path), help="Picture, .svg, .png or .pdf.")
@set_option
@blocks_option
@json_option
def margins(**options: Any) -> int:
    """Say how stable the loops of a graph are: margins, closed-loop poles, sensitivity.

    \b
    proofmass margins graphs/library/closed_loop_accelerometer.toml --plot loop.png
    proofmass margins sensor.toml --loop dac.voltage --set pid.integral=12
    proofmass margins sensor.toml --sensitivity acceleration.output dac.voltage
    proofmass margins modulator.toml --gain quantiser=0.7
    proofmass margins modulator.toml --limit-cycle quantiser
    """
    from proofmass.runner.commands.margins_command import show_margins

    return show_margins(**options)


@cli.command()
@graph_argument
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="File to write; else to the screen."
)
@click.option(
    "--format", "form", type=click.Choice(["svg", "mermaid", "dot"]), help="Default: by the file's ending, or svg."
)
@blocks_option
def draw(graph: Path, output: Path | None, form: str | None, own: Path | None) -> None:
    """Draw the block diagram of a graph.

    \b
    proofmass draw sensor.toml -o sensor.svg
    proofmass draw sensor.toml --format mermaid
    """
    from proofmass.graphs.drawing import diagram
    from proofmass.graphs.files.toml_reader import read_graph

    by_ending = {".mmd": "mermaid", ".mermaid": "mermaid", ".dot": "dot", ".gv": "dot"}
    form = form or by_ending.get(output.suffix if output else "", "svg")
    text = {"svg": diagram.svg, "mermaid": diagram.mermaid, "dot": diagram.dot}[form](read_graph(graph, _own(own)))
    if output is None:
        click.echo(text)
    else:
        output.write_text(text, encoding="utf-8")
        click.echo(f"wrote {output}")


@cli.command()
@click.argument("source", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--temperature", metavar="COLUMN", help="Column, or signal of a graph, of the temperature.")
@click.option("--output", metavar="COLUMN", help="Column, or signal of a graph, of what depends on it.")
@click.option("--offset", type=float, default=0.0, help="Constant to take off the output first.")
@click.option(
    "--order",
    "orders",
    type=click.IntRange(1, 6),
    multiple=True,
    default=(3, 4),
    show_default=True,
    help="Polynomials to compare with.",
)
@click.option("--start", type=(float, float), metavar="B1 B2", help="Exponents that the alternation starts from.")
@click.option("--starts", is_flag=True, help="Also from which starts of a grid both methods reach the optimum.")
@click.option("--plot", type=click.Path(dir_okay=False, path_type=Path), help="Picture to write: .svg, .png or .pdf.")
@click.option(
    "--write", "target", type=click.Path(dir_okay=False, path_type=Path), help="Graph file to write coefficients into."
)
@click.option("--block", "names", multiple=True, help="Block of that file; default: every model in it.")
@set_option
@click.option("--duration", help="How long to run a graph.")
@click.option("--seed", type=click.IntRange(0, 2**62), help="Seed of its noise.")
@click.option("--engine", type=click.Choice(["auto", "python", "compiled"]), default="auto", show_default=True)
@blocks_option
@json_option
def fit(**options: Any) -> int:
    """Fit a temperature law: two exponentials and polynomials, to a table or to a run of a graph.

    The table is CSV, Parquet or netCDF, with a column of temperature (or of its sensor's voltage) and one of output.

    \b
    proofmass fit graphs/library/zero_bias_m1.csv --plot fit.png
    proofmass fit sensor.toml --temperature thermometer.voltage --output readout.voltage --write sensor.toml
    """
    from proofmass.runner.commands.fit_command import run_fit

    return run_fit(**options)


@cli.command()
@click.argument("study", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--runs", type=click.IntRange(1, 2**32), help="How many sensors, instead of what the study says.")
@click.option("--seed", type=click.IntRange(0, 2**62), help="Seed of everything that is drawn.")
@click.option("--engine", type=click.Choice(["auto", "python", "compiled"]), default="auto", show_default=True)
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path), help="Folder for ledger, table and pictures; resumes."
)
@click.option("--threads", type=click.IntRange(1, 1024), help="Threads that run; as many as processors.")
@click.option("--lanes", type=click.IntRange(0, 64), help="Runs side by side in a thread, 0 for none; as suits.")
@click.option("--dask", metavar="ADDRESS|local[:N]", help="Workers of a Dask cluster run; local starts N here.")
@click.option("--format", "formats", multiple=True, type=click.Choice(["csv", "parquet"]), help="Tables beside netCDF.")
@click.option("--report/--no-report", default=True, help="Pictures, influences and report.html, which take their time.")
@click.option("--run", type=click.IntRange(0), help="Replay this run with the traces of all probes.")
@click.option("--epoch", type=click.IntRange(0), default=0, help="Epoch of the run to replay; 0 is the first.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
@blocks_option
@json_option
def montecarlo(**options: Any) -> int:
    """Run a study: many sensors, spread and aged, and what part of them keeps the limits.

    The study is a file that names its graph, or a graph file with a table [study].

    \b
    proofmass montecarlo graphs/library/scale_factor_drift.toml --out drift
    proofmass montecarlo graphs/library/scale_factor_drift.toml --run 17 --epoch 5
    """
    from proofmass.runner.commands.montecarlo_command import run_montecarlo

    return run_montecarlo(**options)


@cli.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="File to write; else report.html in there."
)
@blocks_option
def report(**options: Any) -> int:
    """Show a study, ended or under way, as one HTML file: tables, histograms, fans, tornado, runs to look at.

    STUDY is the folder that `proofmass montecarlo --out` wrote, or the study file: the folder beside it, or here, in
    which it ran last.

    \b
    proofmass report drift
    proofmass report graphs/library/scale_factor_drift.toml
    """
    from proofmass.runner.commands.report_command import report_study

    return report_study(**options)


@cli.command()
@click.argument("kind", required=False)
@blocks_option
@json_option
def blocks(kind: str | None, own: Path | None, as_json: bool) -> int:
    """List all blocks, or show one with its equation, parameters and ports.

    \b
    proofmass blocks
    proofmass blocks MassSpringDamper
    """
    from proofmass.runner.commands.blocks_command import show_blocks

    return show_blocks(kind, _own(own), as_json)


@cli.command()
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
def new(file: Path) -> None:
    """Write a commented graph to start from; it runs as it is.

    \b
    proofmass new sensor.toml && proofmass run sensor.toml
    """
    from importlib.resources import files

    text = (files("proofmass.graphs") / "library" / "template.toml").read_text(encoding="utf-8")
    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(text)
    except FileExistsError:
        raise click.UsageError(f"{file} exists already; nothing was written") from None
    click.echo(f"wrote {file}; run it with: proofmass run {file}")


@cli.command()
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="File to write; else to the screen."
)
@blocks_option
def schema(output: Path | None, own: Path | None) -> None:
    """Write the JSON Schema of graph files, for completion and checks in an editor.

    \b
    proofmass schema -o proofmass-graph.json
    """
    import json

    from proofmass.graphs.schema.schema import schema as schema_of

    text = json.dumps(schema_of(_own(own)), indent=2)
    if output is None:
        click.echo(text)
    else:
        output.write_text(text + "\n", encoding="utf-8")
        click.echo(f"wrote {output}")


for command in (rtl, *ANALYSES):
    cli.add_command(command)


def main(arguments: list[str] | None = None) -> int:
    """Run a command; a user's error is a message and an exit code, never a traceback unless it is asked for."""
    given = sys.argv[1:] if arguments is None else arguments
    plain = [word for word in given if word != "--traceback"]
    try:
        code = cli.main(plain, prog_name="proofmass", standalone_mode=False)
        sys.stdout.flush()
        return code or DONE
    except SystemExit:
        return DONE  # click's answer to a reader that has gone away, as in `proofmass blocks | head -1`
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more at its end
        return DONE
    except click.Abort:
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except click.UsageError as error:
        error.show()
        return USAGE
    except Exception as error:
        if plain != given:
            raise
        return explain(error)


def _own(path: Path | None) -> Any:
    if path is None:
        return None
    from proofmass.runner.commands.run_command import own_blocks

    return own_blocks(path)
