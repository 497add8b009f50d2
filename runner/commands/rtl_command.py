"""The command `rtl`: the digital part of a graph as Verilog, with a test bench and a report."""

import json
from pathlib import Path
from typing import Any

import click

from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.commands.run_command import changed, own_blocks
from proofmass.runner.engine.plan import plan


def write_rtl(
    graph: Path,
    names: tuple[str, ...],
    out: Path,
    ticks: int | None,
    keep_adders: bool,
    prove: bool,
    family: Any,
    changes: tuple[str, ...],
    own: Path | None,
    as_json: bool,
) -> int:
    """Everything that `proofmass rtl` does; returns the exit code."""
    from proofmass.runner.rtl.bench import bench_files
    from proofmass.runner.rtl.compose import compose
    from proofmass.runner.rtl.machine_verilog import machine_text, top_name
    from proofmass.runner.rtl.prove_machine import proof_lines, proofs_data, prove_machine
    from proofmass.runner.rtl.report import cost_text, report_data, save_report
    from proofmass.runner.rtl.synth import synthesized
    from proofmass.runner.rtl.vectors import simulated

    loaded = changed(read_graph(graph, own_blocks(own)), changes, ())
    planned = plan(loaded, wide=True)
    machine = compose(planned, names, graph.stem)
    vectors = simulated(planned, machine, ticks)
    verilog = machine_text(machine, keep_adders=keep_adders)
    files = {f"{top_name(machine)}.v": verilog}
    files |= bench_files(machine, vectors)
    out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (out / name).write_text(text, encoding="utf-8")
    proofs = list(prove_machine(planned, machine, verilog)) if prove else None
    modules = dict.fromkeys((*(module.name for module in machine.modules), top_name(machine)))
    resources = {name: synthesized(verilog, name, family) for name in modules} if family else {}
    data = report_data(
        loaded,
        machine,
        vectors.clocks,
        proofs=proofs_data(proofs) if proofs else None,
        resources={name: found.as_data() for name, found in resources.items()} if resources else None,
    )
    written = [*files, *(path.name for path in save_report(loaded, data, out))]
    if as_json:
        click.echo(json.dumps(data, indent=2))
    else:
        for module in data["modules"]:
            click.echo(f"{module['name']}: {cost_text(module['cost'])}")
        for line in proof_lines(proofs) if proofs else ():
            click.echo(line)
        for name, found in resources.items():
            click.echo(f"{name}: {found}")
    click.echo(f"written to {out}: {', '.join(written)}", err=as_json)
    return 1 if any(proof.proved < proof.goals for proof in proofs or ()) else 0
