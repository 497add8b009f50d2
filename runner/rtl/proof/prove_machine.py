"""Proofs of a machine: of each of its modules alone, and of the whole."""

from collections.abc import Iterable, Iterator
from typing import Any

from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.reference import MachineReference, ModuleReference, Reference
from proofmass.runner.rtl.proof.proof import Proof, prove
from proofmass.runner.rtl.proof.smt_solver import SOLVER


def prove_machine(planned: Plan, machine: Machine, verilog: str) -> Iterator[Proof]:
    """Prove the text of a machine, module by module and then the whole; raises `ModelError` as `prove` does."""
    guesses = {(node.low, node.high) for module in machine.modules for node in module.live}
    references: list[Reference] = [ModuleReference(each) for each in machine.modules]
    if not machine.single:
        references.append(MachineReference(planned, machine))
    for reference in references:
        yield prove(reference, verilog, guesses)


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
