"""The command `rtl`: the digital part of a graph as Verilog, with a test bench and a report."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_files, print_json, print_text
from proofmass.runner.commands.declarations.graphs import RtlRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.bench.bench import bench_files
from proofmass.runner.rtl.bench.cocotb_bench import cocotb_files
from proofmass.runner.rtl.bench.report import report_data, save_report
from proofmass.runner.rtl.bench.simulators import Played, need_simulator, play
from proofmass.runner.rtl.bench.text import module_lines, proof_lines
from proofmass.runner.rtl.bench.vectors import simulated
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.proof.proof import Proof
from proofmass.runner.rtl.proof.prove_machine import proofs_data, prove_machine
from proofmass.runner.rtl.text.amaranth import amaranth_files
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from proofmass.runner.rtl.tools.synth import ChipFamily, Resources, synthesized


@dataclass(frozen=True)
class _Checks:
    """Results of simulators, solver and synthesis."""

    played: list[Played]
    proofs: list[Proof]
    resources: dict[str, Resources]

    def passed(self) -> bool:
        return all(p.passed for p in self.played) and all(p.proved == p.goals for p in self.proofs)

    def as_data(self) -> dict[str, Any]:
        """Sections of the report; none for what was not asked for."""
        sections: dict[str, Any] = {
            "simulations": {played.simulator: played.as_data() for played in self.played},
            "proofs": proofs_data(self.proofs),
            "resources": {name: resources.as_data() for name, resources in self.resources.items()},
        }
        return {name: section for name, section in sections.items() if section}


def write_rtl(request: RtlRequest) -> int:
    """Write the Verilog of a graph, check it as asked, and return the exit code."""
    for simulator in request.simulators:
        need_simulator(simulator)
    graph = graph_of(request.graph, request.own, request.changes)
    planned = plan(graph, wide=True)
    machine = compose(planned, request.names, request.graph.stem)
    vectors = simulated(planned, machine, request.ticks)
    verilog = machine_text(machine, keep_adders=request.keep_adders)
    files = {f"{top_name(machine)}.v": verilog, **bench_files(machine, vectors)}
    if request.amaranth:
        files |= amaranth_files(machine)
    if "cocotb" in request.simulators:
        files |= cocotb_files(machine, vectors.clocks)
    _write(files, request.out)
    played = [play(simulator, machine, files) for simulator in dict.fromkeys(request.simulators)]
    proofs = list(prove_machine(planned, machine, verilog)) if request.prove else []
    checks = _Checks(played, proofs, _resources(machine, verilog, request.family))
    report = report_data(graph, machine, vectors.clocks, checks.as_data())
    names = [*files, *(path.name for path in save_report(graph, report, request.out))]
    if request.as_json:
        print_json(report)
    else:
        print_text(module_lines(report))
        print_text(map(str, checks.played))
        print_text(proof_lines(checks.proofs))
        print_text(f"{name}: {resources}" for name, resources in checks.resources.items())
    print_files(request.out, names, request.as_json)
    return DONE if checks.passed() else WRONG_MODEL


def _write(files: Mapping[str, str], out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (out / name).write_text(text, encoding="utf-8")


def _resources(machine: Machine, verilog: str, family: ChipFamily | None) -> dict[str, Resources]:
    """Return the resources of each module in a family of FPGAs, the top included."""
    if family is None:
        return {}
    modules = dict.fromkeys((*(module.name for module in machine.modules), top_name(machine)))
    return {name: synthesized(verilog, name, family) for name in modules}
