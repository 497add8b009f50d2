"""Proofs of a machine: of each of its modules alone, and of the whole."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.reference import MachineReference, ModuleReference, Reference
from proofmass.runner.rtl.proof.proof import Proof, prove
from proofmass.runner.rtl.proof.smt_solver import SOLVER

_HEAD = ("module", "goals", "proved", "seconds", "solver")


def prove_machine(planned: Plan, machine: Machine, verilog: str) -> Iterator[Proof]:
    """Prove the text of a machine, module by module and then the whole; raises `ModelError` as `prove` does."""
    guesses = {(node.low, node.high) for module in machine.modules for node in module.live}
    references: list[Reference] = [ModuleReference(each) for each in machine.modules]
    if not machine.single:
        references.append(MachineReference(planned, machine))
    for reference in references:
        yield prove(reference, verilog, guesses)


def proof_lines(proofs: Sequence[Proof]) -> Iterator[str]:
    """A table for the screen, and what is not proved."""
    rows = [_HEAD, *((p.name, str(p.goals), str(p.proved), f"{p.seconds:.1f}", SOLVER) for p in proofs)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEAD))]
    for name, *cells, solver in rows:
        right = (cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=False))
        yield "  ".join([name.ljust(widths[0]), *right, solver])
    for proof in proofs:
        yield from (f"{proof.name}.{name}: undecided" for name in proof.undecided)
        yield from (f"{proof.name}.{fault}" for fault in proof.faults)
        yield from (f"{proof.name}.{example}" for example in proof.counter_examples)


def proofs_data(proofs: Iterable[Proof]) -> dict[str, Any]:
    """Proofs as plain data, by module."""
    return {
        proof.name: {
            "goals": proof.goals,
            "proved": proof.proved,
            "seconds": round(proof.seconds, 3),
            "solver": SOLVER,
            "undecided": list(proof.undecided),
            "faults": list(proof.faults),
            "counter_examples": [
                {
                    "name": e.name,
                    "python": e.python,
                    "verilog": e.verilog,
                    "ticks_late": e.late,
                    "stimulus": dict(e.stimulus),
                }
                for e in proof.counter_examples
            ],
        }
        for proof in proofs
    }
