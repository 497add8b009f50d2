"""The commands that check, run, draw and show graphs, and run studies."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from proofmass.runner.commands.declarations.completion import outputs, parameters
from proofmass.runner.commands.declarations.options import (
    AT,
    DURATION,
    OWN,
    PROBES,
    QUIET,
    SET,
    Answered,
    Changed,
    LibraryFile,
    Request,
    Whole,
    argument,
    engine_option,
    file_argument,
    file_option,
    flag,
    option,
    out_option,
    output_option,
    plot_option,
    seed_option,
    several,
)
from proofmass.runner.run.engine_table import EngineName

if TYPE_CHECKING:
    from proofmass.runner.rtl.bench.simulators import Simulator
    from proofmass.runner.rtl.tools.synth import ChipFamily


class RunRequest(Answered, does="run_command.run_graph"):
    """Run a graph once and show what its probes recorded.

    \b
    proofmass run library:closed_loop_accelerometer
    proofmass run library:template --duration "2 s" --set adc.bits=24 --out results
    proofmass run library:scale_factor_drift --sweep adc.bits=16,20,24 --measure noise
    """

    graph: Path = file_argument(library=True)
    duration: str | None = DURATION
    samples: int | None = option("Run this many ticks of the base rate, instead of for a duration.", type=Whole(1))
    seed: int | None = seed_option("as the graph says")
    engine: EngineName = engine_option()
    changes: tuple[str, ...] = SET
    probes: tuple[str, ...] = PROBES
    out: Path | None = out_option("Write traces, plot and report to this folder (default: none is written).")
    formats: tuple[str, ...] = several(
        "Choose the format of traces; repeatable (default: netcdf, or csv where that is not installed).",
        "--format",
        type=click.Choice(["netcdf", "csv", "parquet"]),
    )
    picture: Path | None = plot_option("Draw the traces")
    live: bool = flag("Add the running model to the report, with a slider for each parameter.")
    budgets: tuple[str, ...] = several(
        "Put the noise budget of this output into the report, and into noise.json; repeatable.",
        "--noise",
        metavar="OUTPUT",
        shell_complete=outputs,
    )
    resume: bool = flag("Continue the interrupted run in --out (default: if there is one).")
    restart: bool = flag("Remove an interrupted run in --out and start at tick 0.")
    swept: tuple[str, ...] = several(
        "Run once for each value, as in adc.bits=10,12,14 or mass.mass=1g:1kg:4:log, for its measures; repeatable.",
        "--sweep",
        metavar="NAME=VALUE,VALUE",
        shell_complete=parameters,
    )
    zipped: bool = flag("Combine the values of all --sweep in order, instead of trying all combinations.", "--zip")
    measures: tuple[str, ...] = several("Show this measure of a sweep; repeatable.", "--measure", metavar="NAME")
    show_source: bool = flag("Print the program of the loop, with its lines of Python, instead of running it.")
    profile: bool = flag("Show where the time goes: phases of the run, and each block in a tick.")
    quiet: bool = QUIET

    def check(self) -> None:
        if self.duration is not None and self.samples is not None:
            raise click.UsageError("give --duration or --samples, not both")
        if self.resume and self.out is None:
            raise click.UsageError("--resume needs --out, the folder of the interrupted run")
        if self.resume and self.restart:
            raise click.UsageError("give --resume or --restart, not both")
        if self.swept and (self.resume or self.show_source or self.live or self.picture or self.engine == "cxxrtl"):
            raise click.UsageError("--sweep goes without --resume, --show-source, --plot, --live and --engine cxxrtl")
        if self.profile and (self.swept or self.resume or self.show_source or self.engine not in ("auto", "compiled")):
            raise click.UsageError(
                "--profile goes without --sweep, --resume, --show-source and other engines: it times"
            )
        if (self.zipped or self.measures) and not self.swept:
            raise click.UsageError("--zip and --measure need --sweep")
        if self.live and self.out is None:
            raise click.UsageError("--live needs --out, the folder to write to")
        if self.budgets and self.out is None:
            raise click.UsageError("--noise needs --out, the folder of the report")
        if self.formats and self.out is None:
            raise click.UsageError("--format needs --out, the folder to write to")


class CheckRequest(Changed, does="check_command.check_graph"):
    """List everything that is wrong with a graph or a study.

    Files that it names are read, and it is planned as for a run. Exit code 1 if it cannot run, or
    if a loop misses a margin that the graph requires.

    \b
    proofmass check library:closed_loop_accelerometer
    """

    graph: Path = file_argument(library=True)


class MarginsRequest(Changed, does="margins_command.show_margins"):
    """Show how stable the loops of a graph are.

    The answer has margins, closed-loop poles and, if asked for, sensitivities to parameters and
    limit cycles.

    \b
    proofmass margins library:closed_loop_accelerometer --plot loop.png
    proofmass margins library:closed_loop_accelerometer --loop dac.voltage --set pid.integral=12
    proofmass margins library:closed_loop_accelerometer --sensitivity acceleration.output dac.voltage
    proofmass margins library:sigma_delta_accelerometer --loop second --gain second.quantiser=0.7
    proofmass margins library:sigma_delta_accelerometer --loop second --limit-cycle second.quantiser
    proofmass margins library:coupled_axes --together --plot together.png
    proofmass margins library:closed_loop_accelerometer --over "pid.proportional=0.03..0.12"
    """

    graph: Path = file_argument(library=True)
    loop: str = option("Choose a loop by name, or by the output to open it at.", default="", metavar="NAME")
    at: str = AT
    sensitivity: tuple[str, str] | None = option(
        "Rank parameters by their effect on scale factor and bias between two outputs, and on the margins.",
        nargs=2,
        metavar="INPUT OUTPUT",
    )
    gains: tuple[str, ...] = several(
        "Replace a quantiser, comparator or relay by a gain; repeatable.", "--gain", metavar="BLOCK=GAIN"
    )
    amplitudes: tuple[str, ...] = several(
        "Replace a block by its gain for a sine of this amplitude (its describing function); repeatable.",
        "--amplitude",
        metavar="BLOCK=AMPLITUDE",
    )
    limit_cycle: str = option("Predict limit cycles by this describing function.", default="", metavar="BLOCK")
    together: bool = flag("Perturb all loops at once, each by its own factor.")
    others: tuple[str, ...] = several("Perturb this loop together with --loop; repeatable.", "--with", metavar="NAME")
    over: str = option(
        "Show margins over a parameter, or over a study's age.", default="", metavar="PARAMETER=LOW..HIGH[:N]|age"
    )
    picture: Path | None = plot_option("Draw Bode, Nyquist and step response")


class DrawRequest(Changed, does="draw_command.draw_graph"):
    """Draw the block diagram of a graph.

    In a diagram larger than a page, wires longer than a page is wide end in tabs with their name.

    \b
    proofmass draw library:closed_loop_accelerometer -o sensor.svg
    proofmass draw library:closed_loop_accelerometer --format mermaid
    proofmass draw library:closed_loop_gyroscope -o gyroscope.svg --unfold drive --overlay rates
    """

    graph: Path = file_argument(library=True)
    output: Path | None = output_option("the screen")
    form: str | None = option(
        "Choose the format (default: by the file's ending, else svg).",
        "--format",
        type=click.Choice(["svg", "mermaid", "dot"]),
    )
    unfold: tuple[str, ...] = several("Draw what is inside a subgraph, or inside all; repeatable.", metavar="SUBGRAPH")
    overlay: str | None = option(
        "Colour rates, loops or types of signals.", type=click.Choice(["rates", "loops", "formats"])
    )


class MontecarloRequest(Answered, does="montecarlo_command.run_montecarlo"):
    """Run a study of many sensors, spread and aged.

    It shows their measures, and how many keep the limits. STUDY is a file that names its graph, or
    a graph file with a table [study].

    \b
    proofmass montecarlo library:scale_factor_drift --runs 20 --out drift
    proofmass montecarlo library:scale_factor_drift --run 17 --epoch 5
    proofmass montecarlo library:scale_factor_drift --set adc.bits=20 --runs 20
    """

    study: Path = file_argument(library=True)
    runs: int | None = option("Simulate this many sensors (default: as the study says).", type=Whole(1, 2**32))
    seed: int | None = seed_option("as the study says")
    engine: EngineName = engine_option(studies=True)
    changes: tuple[str, ...] = SET
    out: Path | None = out_option(
        "Write ledger, tables and report to this folder; a study that is there already is continued."
    )
    threads: int | None = option("Use this many threads (default: one per processor).", type=Whole(1, 1024))
    lanes: int | None = option(
        "Run this many sensors side by side in a thread, or the next power of two; 0 for one at a time (default:"
        " automatic).",
        type=Whole(0, 64),
    )
    dask: str | None = option(
        "Run on the Dask cluster at ADDRESS, or start N local workers.", metavar="ADDRESS|local[:N]"
    )
    formats: tuple[str, ...] = several(
        "Write tables in this format too; repeatable (default: netCDF, or CSV where that is not installed).",
        "--format",
        type=click.Choice(["csv", "parquet"]),
    )
    picture: Path | None = plot_option("Draw fans and histograms of the measures")
    report: bool = option("Write plots, influences and report.html.", "--report/--no-report", default=True)
    repair: bool = flag("Keep the whole runs of a damaged ledger in --out; run the others again.")
    run: int | None = option("Replay only this run, with the traces of all probes.", type=Whole(0))
    epoch: int = option("Replay the run at this epoch, the first being 0.", type=Whole(0), default=0)
    variant: str | None = option("Run this variant of the study only.", metavar="NAME")
    quiet: bool = QUIET

    def check(self) -> None:
        if self.repair and self.out is None:
            raise click.UsageError("--repair needs --out: the folder of the study")
        if self.dask is not None and self.threads is not None:
            raise click.UsageError("give --threads or --dask, not both: Dask's workers have threads of their own")


class ReportRequest(Answered, does="report_command.report_study"):
    """Write a study as one HTML file.

    The page has tables, histograms, fans, a tornado, and the runs worth a look. STUDY is the folder
    of `proofmass montecarlo --out`, even while the study runs, or the study file. Of a file it
    takes the folder of the last run, beside the file or here, and the limits
    that the file has now.

    \b
    proofmass montecarlo library:scale_factor_drift --runs 20 --out drift --no-report
    proofmass report drift
    """

    study: Path = argument(type=LibraryFile(path_type=Path))
    output: Path | None = output_option("report.html in the folder of the study")
    proof: Path | None = file_option("Show what this certificate of prove has proved of the same graph.", "--proof")


class LiveRequest(Request, does="live_command.serve_live"):
    """Show a graph in the browser, and update it after every save.

    The page has a slider for each parameter; traces, spectra, measures, margins and noise follow.
    It is served to this machine alone. Mistakes in the file are shown with their lines, above the
    last good run.

    \b
    proofmass live library:closed_loop_accelerometer
    proofmass live library:closed_loop_accelerometer --no-browser
    proofmass live library:scale_factor_drift --study library:margin_tolerance_study
    """

    graph: Path = file_argument(library=True)
    changes: tuple[str, ...] = SET
    probes: tuple[str, ...] = PROBES
    study: Path | None = option(
        "Run this study meanwhile (default: that of the graph file, if it has one).",
        type=LibraryFile(dir_okay=False, path_type=Path),
        metavar="FILE",
    )
    edit: bool = flag("Let the page save its sliders into the file, which it does not write otherwise.")
    browser: bool = option("Open the page in a browser.", "--browser/--no-browser", default=True)
    own: Path | None = OWN


class RtlRequest(Changed, does="rtl_command.write_rtl"):
    """Write the digital part of a graph as Verilog.

    A self-checking test bench and a report come with it. Exit code 1 if a simulator finds a
    difference, or a proof fails.

    \b
    proofmass rtl library:self_calibration_fixed -o hardware --simulate icarus
    proofmass rtl library:self_calibration_fixed --block stiffness -o proved --prove --synth ecp5
    """

    graph: Path = file_argument(library=True)
    names: tuple[str, ...] = several("Write this block or subgraph only; repeatable.", "--block", metavar="NAME")
    out: Path = out_option("Write to this folder.", required=True)
    ticks: int | None = option(
        "Test this many clocks (default: the graph's duration, at most 10,000).", type=Whole(1, 10**7)
    )
    keep_adders: bool = option(
        "Mark sums so that synthesis makes carry chains of them.", "--keep-adders/--merge-adders", default=True
    )
    amaranth: bool = flag("Write the blocks as modules of Amaranth too.")
    simulators: "tuple[Simulator, ...]" = several(
        "Run the test bench with this simulator; repeatable.",
        "--simulate",
        type=click.Choice(["icarus", "verilator", "cocotb"]),
    )
    prove: bool = flag("Prove the Verilog equal to the Python functions for all inputs.")
    family: "ChipFamily | None" = option(
        "Count lookup tables, flip-flops and multipliers; place and route for ice40 and ecp5.",
        "--synth",
        type=click.Choice(["xc2vp", "xc7", "ice40", "ecp5"]),
    )


class SchemaRequest(Request, does="schema_command.write_schema"):
    """Write the JSON Schema of graphs, or of study files.

    Editors use it to complete and check files.

    \b
    proofmass schema -o proofmass-graph.json
    proofmass schema --study -o proofmass-study.json
    """

    output: Path | None = output_option("the screen")
    study: bool = flag("Write the schema of study files instead.")
    own: Path | None = OWN
    as_json: bool = flag("Change nothing: a schema is JSON.", "--json")
