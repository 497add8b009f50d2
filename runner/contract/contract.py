"""The contract that every block keeps, as checks in the order in which they are run."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.contract import declared, engines, functions
from proofmass.runner.contract.cases import cases
from proofmass.runner.contract.foreign import FOREIGN
from proofmass.runner.contract.verdict import ContractVerdict

SETS = 3  # of parameters

STILL: Mapping[str, Callable[[type[Block]], ContractVerdict]] = {
    "documents": declared.documents,
    "units": declared.units,
    "bounds": declared.bounds,
    "functions": functions.compiled,
    "purity": functions.repeatable,
}
RUN = ("machine code", "lanes", *(compiler.name for compiler in FOREIGN), "state", "faults")


@dataclass(frozen=True)
class Report:
    """Verdicts of all checks of one block."""

    kind: str
    verdicts: tuple[ContractVerdict, ...]

    @property
    def passed(self) -> bool:
        """True if no check failed."""
        return all(verdict.status != "FAILED" for verdict in self.verdicts)

    def as_data(self) -> dict[str, Any]:
        """The report as plain data, for `--json`."""
        return {"kind": self.kind, "passed": self.passed, "checks": [verdict.as_data() for verdict in self.verdicts]}


def check_block(kind: type[Block], sets: int = SETS) -> Report:
    """Run all checks of one kind of block, with its default parameters and some drawn by chance: `sets` in all."""
    still = [check(kind) for check in STILL.values()]
    failed = {verdict.check for verdict in still if verdict.status == "FAILED"}
    if failed & {"functions", "purity"} or not kind.outputs:
        return Report(kind.__name__, (*still, *_not_run("its functions have to be cured first")))
    return Report(kind.__name__, (*still, *_run(kind, sets)))


def _run(kind: type[Block], sets: int) -> Iterator[ContractVerdict]:
    """The checks that run the block."""
    with TemporaryDirectory() as name:
        try:
            ordinary = cases(kind, Path(name), hostile=False, sets=sets)
            hostile = cases(kind, Path(name), hostile=True, sets=sets)
        except ModelError as error:
            problems = error.problems
            yield ContractVerdict(RUN[0], "FAILED", "it cannot be planned", problems)
            yield from _not_run("it cannot be planned", 1)
            return
        together = [*ordinary, *hostile]
        yield engines.native(kind, together)
        yield engines.lanes(kind, together)
        for compiler in FOREIGN:
            yield engines.foreign(kind, together, compiler)
        yield engines.interrupted(kind, ordinary)
        yield engines.faults(ordinary, hostile)


def _not_run(why: str, first: int = 0) -> list[ContractVerdict]:
    return [ContractVerdict(check, "not run", why) for check in RUN[first:]]
