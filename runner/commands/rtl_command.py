"""The command `rtl`: the digital part of a graph as Verilog, with a test bench and a report."""

import json
from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.options import blocks_option, graph_argument, json_option, set_option


@click.command()
@graph_argument
@click.option("--block", "names", multiple=True, metavar="NAME", help="Only this block, or all in this subgraph.")
@click.option(
    "-o", "--output", "out", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder to write to."
)
@click.option(
    "--ticks",
    type=click.IntRange(1, 10**7),
    help="Clocks of the test bench; else the graph's duration, at most 10,000.",
)
@click.option(
    "--keep-adders/--merge-adders",
    default=True,
    show_default=True,
    help="Mark sums, so that synthesis makes carry chains of them.",
)
@click.option("--amaranth", is_flag=True, help="Also write the blocks as modules of Amaranth.")
@click.option(
    "--simulate",
    "simulators",
    multiple=True,
    type=click.Choice(["icarus", "verilator", "cocotb"]),
    help="Play the test bench with this simulator; may be given for each.",
)
@click.option(
    "--prove", is_flag=True, help="Prove for all inputs and registers that the Verilog does what Python does."
)
@click.option(
    "--synth",
    "family",
    type=click.Choice(["xc2vp", "xc7", "ice40", "ecp5"]),
    help="Count lookup tables, flip-flops and multipliers in this family; ice40 and ecp5 are placed and routed.",
)
@set_option
@blocks_option
@json_option
def rtl(**options: Any) -> int:
    """Write the digital part of a graph as Verilog, with a self-checking test bench and a report.

    Exit code 1 where a simulator finds another output, or a proof fails.

    \b
    proofmass rtl graphs/library/accelerometer/self_calibration_fixed.toml -o hardware --simulate icarus
    proofmass rtl sensor.toml --block controller -o hardware --prove --synth ecp5
    """
    return write_rtl(**options)


def write_rtl(
    graph: Path,
    names: tuple[str, ...],
    out: Path,
    ticks: int | None,
    keep_adders: bool,
    amaranth: bool,
    simulators: tuple[Any, ...],
    prove: bool,
    family: Any,
    changes: tuple[str, ...],
    own: Path | None,
    as_json: bool,
) -> int:
    """Everything that `proofmass rtl` does; returns the exit code."""
    from proofmass.graphs.files.toml_reader import read_graph
    from proofmass.runner.commands.run_command import changed, own_blocks
    from proofmass.runner.planning.plan import plan
    from proofmass.runner.rtl.bench.bench import bench_files
    from proofmass.runner.rtl.bench.cocotb_bench import cocotb_files
    from proofmass.runner.rtl.bench.report import cost_text, report_data, save_report
    from proofmass.runner.rtl.bench.simulators import need_simulator, play
    from proofmass.runner.rtl.bench.vectors import simulated
    from proofmass.runner.rtl.machine.compose import compose
    from proofmass.runner.rtl.proof.prove_machine import proof_lines, proofs_data, prove_machine
    from proofmass.runner.rtl.text.amaranth import amaranth_files
    from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
    from proofmass.runner.rtl.tools.synth import synthesized

    for simulator in simulators:
        need_simulator(simulator)
    loaded = changed(read_graph(graph, own_blocks(own)), changes, ())
    planned = plan(loaded, wide=True)
    machine = compose(planned, names, graph.stem)
    vectors = simulated(planned, machine, ticks)
    verilog = machine_text(machine, keep_adders=keep_adders)
    files = {f"{top_name(machine)}.v": verilog}
    files |= bench_files(machine, vectors)
    if amaranth:
        files |= amaranth_files(machine)
    if "cocotb" in simulators:
        files |= cocotb_files(machine, vectors.clocks)
    out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (out / name).write_text(text, encoding="utf-8")
    played = [play(simulator, machine, files) for simulator in dict.fromkeys(simulators)]
    proofs = list(prove_machine(planned, machine, verilog)) if prove else None
    modules = dict.fromkeys((*(module.name for module in machine.modules), top_name(machine)))
    resources = {name: synthesized(verilog, name, family) for name in modules} if family else {}
    found: dict[str, Any] = {
        "simulations": {each.simulator: each.as_data() for each in played},
        "proofs": proofs_data(proofs) if proofs else {},
        "resources": {name: found.as_data() for name, found in resources.items()},
    }
    data = report_data(loaded, machine, vectors.clocks, {key: each for key, each in found.items() if each})
    written = [*files, *(path.name for path in save_report(loaded, data, out))]
    if as_json:
        click.echo(json.dumps(data, indent=2))
    else:
        for module in data["modules"]:
            click.echo(f"{module['name']}: {cost_text(module['cost'])}")
        for each in played:
            click.echo(str(each))
        for line in proof_lines(proofs) if proofs else ():
            click.echo(line)
        for name, counted in resources.items():
            click.echo(f"{name}: {counted}")
    click.echo(f"written to {out}: {', '.join(written)}", err=as_json)
    proved = all(proof.proved == proof.goals for proof in proofs or ())
    return 0 if proved and all(each.passed for each in played) else 1
