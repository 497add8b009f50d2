"""Hardware and what was found of it, as text for people."""

from collections.abc import Iterator, Sequence
from typing import Any

from proofmass.runner.output.text_table import text_table
from proofmass.runner.rtl.bench.report import cost_text
from proofmass.runner.rtl.proof.proof import Proof
from proofmass.runner.rtl.proof.smt_solver import SOLVER

_HEAD = ("module", "goals", "proved", "seconds", "solver")


def module_lines(report: dict[str, Any]) -> Iterator[str]:
    """Yield the cost of each module of a report."""
    for module in report["modules"]:
        yield f"{module['name']}: {cost_text(module['cost'])}"


def proof_lines(proofs: Sequence[Proof]) -> Iterator[str]:
    """Yield a table of proofs, and the unproved claims."""
    if not proofs:
        return
    rows = [(p.name, str(p.goals), str(p.proved), f"{p.seconds:.1f}", SOLVER) for p in proofs]
    yield from text_table([_HEAD, *rows], left=(0, len(_HEAD) - 1))
    for proof in proofs:
        yield from (f"{proof.name}.{name}: undecided" for name in proof.undecided)
        yield from (f"{proof.name}.{fault}" for fault in proof.faults)
        yield from (f"{proof.name}.{example}" for example in proof.counter_examples)
