"""Arguments and options of each command; its function is imported when it is called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.completion import outputs, parameters
from proofmass.runner.commands.declarations.options import (
    Whole,
    at_option,
    blocks_option,
    duration_option,
    engine_option,
    file_argument,
    graph_argument,
    json_option,
    out_option,
    output_option,
    plot_option,
    probe_option,
    quiet_option,
    seed_option,
    set_option,
)
from proofmass.runner.host.versions import PROOFMASS


class Commands(click.Group):
    """Commands with "did you mean"."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError:
            # start-up time: a command imports what it needs itself
            from proofmass.blocks.declaration.problem import did_you_mean

            raise click.UsageError(
                f"no such command: {args[0]}; {did_you_mean(args[0], self.commands, 'the commands')}", ctx
            ) from None


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120})
@click.version_option(PROOFMASS, prog_name="proofmass")
@click.option("--traceback", is_flag=True, help="Show Python's traceback of an error; allowed after the command too.")
def cli(traceback: bool) -> None:
    """Simulate inertial sensors and the loops around them, declared as block diagrams.

    \b
    proofmass new sensor.toml                 write a commented graph to start from
    proofmass check sensor.toml               list everything that is wrong with it
    proofmass run sensor.toml --out results   simulate it, write traces, plot and report

    Exit codes: 0 done, 1 the model is wrong, 2 wrong usage, 3 the run failed, 130 interrupted.
    """


@cli.command()
@graph_argument
@duration_option
@click.option("--samples", type=Whole(1), help="Run this many ticks of the base rate, instead of for a duration.")
@seed_option("the graph")
@engine_option()
@set_option
@probe_option
@out_option("Write traces, plot and report to this folder (default: none is written).")
@click.option(
    "--format",
    "formats",
    multiple=True,
    type=click.Choice(["netcdf", "csv", "parquet"]),
    help="Choose the format of traces; repeatable (default: netcdf, or csv where that is not installed).",
)
@plot_option("picture", "Draw the traces")
@click.option("--live", is_flag=True, help="Add the running model to the report, with a slider for each parameter.")
@click.option(
    "--noise",
    "budgets",
    multiple=True,
    metavar="OUTPUT",
    shell_complete=outputs,
    help="Put the noise budget of this output into the report, and into noise.json; repeatable.",
)
@click.option(
    "--resume",
    is_flag=True,
    help="Continue the interrupted run in --out (default: if there is one).",
)
@click.option("--restart", is_flag=True, help="Remove an interrupted run in --out and start at tick 0.")
@click.option(
    "--sweep",
    "swept",
    multiple=True,
    metavar="NAME=VALUE,VALUE",
    shell_complete=parameters,
    help="Run once for each value, as in adc.bits=10,12,14 or mass.mass=1g:1kg:4:log, for its measures; repeatable.",
)
@click.option(
    "--zip",
    "zipped",
    is_flag=True,
    help="Combine the values of all --sweep in order, instead of trying all combinations.",
)
@click.option("--measure", "measures", multiple=True, metavar="NAME", help="Show this measure of a sweep; repeatable.")
@click.option(
    "--show-source",
    is_flag=True,
    help="Print the program of the loop, with its lines of Python, instead of running it.",
)
@click.option("--profile", is_flag=True, help="Show where the time goes: phases of the run, and each block in a tick.")
@quiet_option
@blocks_option
@json_option
def run(**options: Any) -> int:
    """Run a graph once and show what its probes recorded.

    \b
    proofmass run graphs/library/accelerometer/closed_loop_accelerometer.toml
    proofmass run sensor.toml --duration "2 s" --set adc.bits=24 --out results
    proofmass run sensor.toml --sweep adc.bits=10,12,14 --measure noise
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.run_command import RunRequest, run_graph

    return run_graph(RunRequest(**options))


@cli.command()
@graph_argument
@set_option
@blocks_option
@json_option
def check(graph: Path, changes: tuple[str, ...], own: Path | None, as_json: bool) -> int:
    """List everything that is wrong with a graph or a study.

    Files that it names are read, and it is planned as for a run. Exit code 1 if it cannot run, or if a loop misses a
    margin that the graph requires.

    \b
    proofmass check sensor.toml
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.check_command import check_graph

    return check_graph(graph, changes, own, as_json)


@cli.command()
@graph_argument
@click.option("--loop", default="", metavar="NAME", help="Choose a loop by name, or by the output to open it at.")
@at_option
@click.option(
    "--sensitivity",
    nargs=2,
    metavar="INPUT OUTPUT",
    help="Rank parameters by their effect on scale factor and bias between two outputs, and on the margins.",
)
@click.option(
    "--gain",
    "gains",
    multiple=True,
    metavar="BLOCK=GAIN",
    help="Replace a quantiser, comparator or relay by a gain; repeatable.",
)
@click.option(
    "--amplitude",
    "amplitudes",
    multiple=True,
    metavar="BLOCK=AMPLITUDE",
    help="Replace a block by its gain for a sine of this amplitude (its describing function); repeatable.",
)
@click.option("--limit-cycle", default="", metavar="BLOCK", help="Predict limit cycles by this describing function.")
@click.option("--together", is_flag=True, help="Perturb all loops at once, each by its own factor.")
@click.option(
    "--with", "others", multiple=True, metavar="NAME", help="Perturb this loop together with --loop; repeatable."
)
@click.option(
    "--over",
    default="",
    metavar="PARAMETER=LOW..HIGH[:N]|age",
    help="Show margins over a parameter, or over a study's age.",
)
@plot_option("picture", "Draw Bode, Nyquist and step response")
@set_option
@blocks_option
@json_option
def margins(**options: Any) -> int:
    """Show how stable the loops of a graph are.

    The answer has margins, closed-loop poles and, if asked for, sensitivities to parameters and limit cycles.

    \b
    proofmass margins graphs/library/accelerometer/closed_loop_accelerometer.toml --plot loop.png
    proofmass margins sensor.toml --loop dac.voltage --set pid.integral=12
    proofmass margins sensor.toml --sensitivity acceleration.output dac.voltage
    proofmass margins modulator.toml --gain quantiser=0.7
    proofmass margins modulator.toml --limit-cycle quantiser
    proofmass margins gyroscope.toml --together --plot together.png
    proofmass margins sensor.toml --over "temperature.value=233 K..358 K"
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.margins_command import MarginsRequest, show_margins

    return show_margins(MarginsRequest(**options))


@cli.command()
@graph_argument
@output_option("the screen")
@click.option(
    "--format",
    "form",
    type=click.Choice(["svg", "mermaid", "dot"]),
    help="Choose the format (default: by the file's ending, else svg).",
)
@click.option(
    "--unfold", multiple=True, metavar="SUBGRAPH", help="Draw what is inside a subgraph, or inside all; repeatable."
)
@click.option(
    "--overlay", type=click.Choice(["rates", "loops", "formats"]), help="Colour rates, loops or types of signals."
)
@set_option
@blocks_option
@json_option
def draw(**options: Any) -> int:
    """Draw the block diagram of a graph.

    \b
    proofmass draw sensor.toml -o sensor.svg
    proofmass draw sensor.toml --format mermaid
    proofmass draw library:closed_loop_gyroscope -o gyroscope.svg --unfold drive --overlay rates
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.draw_command import DrawRequest, draw_graph

    return draw_graph(DrawRequest(**options))


@cli.command()
@file_argument("study", library=True)
@click.option("--runs", type=Whole(1, 2**32), help="Simulate this many sensors (default: as the study says).")
@seed_option("the study")
@engine_option(studies=True)
@set_option
@out_option("Write ledger, tables and report to this folder; a study that is there already is continued.")
@click.option("--threads", type=Whole(1, 1024), help="Use this many threads (default: one per processor).")
@click.option(
    "--lanes",
    type=Whole(0, 64),
    help="Run this many sensors side by side in a thread, or the next power of two; 0 for one at a time (default:"
    " automatic).",
)
@click.option(
    "--dask", metavar="ADDRESS|local[:N]", help="Run on the Dask cluster at ADDRESS, or start N local workers."
)
@click.option(
    "--format",
    "formats",
    multiple=True,
    type=click.Choice(["csv", "parquet"]),
    help="Write tables in this format too; repeatable (default: netCDF, or CSV where that is not installed).",
)
@plot_option("picture", "Draw fans and histograms of the measures")
@click.option("--report/--no-report", default=True, show_default=True, help="Write plots, influences and report.html.")
@click.option("--repair", is_flag=True, help="Keep the whole runs of a damaged ledger in --out; run the others again.")
@click.option("--run", type=Whole(0), help="Replay only this run, with the traces of all probes.")
@click.option(
    "--epoch",
    type=Whole(0),
    default=0,
    show_default=True,
    help="Replay the run at this epoch, the first being 0.",
)
@click.option("--variant", metavar="NAME", help="Run this variant of the study only.")
@quiet_option
@blocks_option
@json_option
def montecarlo(**options: Any) -> int:
    """Run a study of many sensors, spread and aged.

    It shows their measures, and how many keep the limits. STUDY is a file that names its graph, or a graph file
    with a table [study].

    \b
    proofmass montecarlo graphs/library/accelerometer/scale_factor_drift.toml --out drift
    proofmass montecarlo graphs/library/accelerometer/scale_factor_drift.toml --run 17 --epoch 5
    proofmass montecarlo graphs/library/accelerometer/scale_factor_drift.toml --set adc.bits=20 --runs 20
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.montecarlo_command import StudyRequest, run_montecarlo

    return run_montecarlo(StudyRequest(**options))


@cli.command()
@click.argument("study", type=click.Path(path_type=Path))
@output_option("report.html in the folder of the study")
@blocks_option
@json_option
def report(study: Path, output: Path | None, own: Path | None, as_json: bool) -> int:
    """Write a study as one HTML file.

    The page has tables, histograms, fans, a tornado, and the runs worth a look. STUDY is the folder of `proofmass
    montecarlo --out`, even while the study runs, or the study file. Of a file it takes the folder of the last run,
    beside the file or here.

    \b
    proofmass report drift
    proofmass report graphs/library/accelerometer/scale_factor_drift.toml
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.report_command import report_study

    return report_study(study, output, own, as_json)


@cli.command()
@graph_argument
@click.option("--block", "names", multiple=True, metavar="NAME", help="Write this block or subgraph only; repeatable.")
@out_option("Write to this folder.", required=True)
@click.option(
    "--ticks",
    type=Whole(1, 10**7),
    help="Test this many clocks (default: the graph's duration, at most 10,000).",
)
@click.option(
    "--keep-adders/--merge-adders",
    default=True,
    show_default=True,
    help="Mark sums so that synthesis makes carry chains of them.",
)
@click.option("--amaranth", is_flag=True, help="Write the blocks as modules of Amaranth too.")
@click.option(
    "--simulate",
    "simulators",
    multiple=True,
    type=click.Choice(["icarus", "verilator", "cocotb"]),
    help="Run the test bench with this simulator; repeatable.",
)
@click.option("--prove", is_flag=True, help="Prove the Verilog equal to the Python functions for all inputs.")
@click.option(
    "--synth",
    "family",
    type=click.Choice(["xc2vp", "xc7", "ice40", "ecp5"]),
    help="Count lookup tables, flip-flops and multipliers; place and route for ice40 and ecp5.",
)
@set_option
@blocks_option
@json_option
def rtl(**options: Any) -> int:
    """Write the digital part of a graph as Verilog.

    A self-checking test bench and a report come with it. Exit code 1 if a simulator finds a difference, or a proof
    fails.

    \b
    proofmass rtl graphs/library/accelerometer/self_calibration_fixed.toml -o hardware --simulate icarus
    proofmass rtl sensor.toml --block controller -o hardware --prove --synth ecp5
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.rtl_command import RtlRequest, write_rtl

    return write_rtl(RtlRequest(**options))


@cli.command()
@output_option("the screen")
@blocks_option
@click.option("--json", "as_json", is_flag=True, help="Change nothing: a schema is JSON.")
def schema(output: Path | None, own: Path | None, as_json: bool) -> int:
    """Write the JSON Schema of graphs and studies.

    Editors use it to complete and check files.

    \b
    proofmass schema -o proofmass-graph.json
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.schema_command import write_schema

    return write_schema(output, own)
