"""Checks that a block computes the same in every engine, on ordinary numbers and at the edges of arithmetic."""

from collections import Counter
from collections.abc import Iterator, Sequence

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.contract import outcomes
from proofmass.runner.contract.cases import Case
from proofmass.runner.contract.foreign import Foreign, ForeignError
from proofmass.runner.contract.outcomes import outcome, packed
from proofmass.runner.contract.places import problem
from proofmass.runner.contract.verdict import ContractVerdict, verdict
from proofmass.runner.output.counts import count
from proofmass.runner.program.listing import listing

_SHOWN = 3  # differences of a check


def native(kind: type[Block], cases: Sequence[Case]) -> ContractVerdict:
    """Machine code has the bits of plain Python."""
    texts = (text for c in cases for text in outcomes.native_differences(c.compiled, c.sensors, c.outcomes))
    return _verdict(kind, "machine code", texts, cases)


def lanes(kind: type[Block], cases: Sequence[Case]) -> ContractVerdict:
    """Runs side by side have the bits that each has alone."""
    texts = (text for c in cases for text in outcomes.lane_differences(c.sensors, c.outcomes, c.given, len(c.sensors)))
    return _verdict(kind, "lanes", texts, cases)


def foreign(kind: type[Block], cases: Sequence[Case], compiler: Foreign) -> ContractVerdict:
    """The program has the same bits when another compiler has made it."""
    lacks = compiler.lacks(cases[0].compiled.written.program)
    if lacks:
        return ContractVerdict(compiler.name, "not run", lacks)
    alike: dict[str, list[Case]] = {}  # one program runs them all
    for case in cases:
        alike.setdefault(listing(case.compiled.written.program), []).append(case)
    try:
        texts = [text for some in alike.values() for text in _foreign(compiler, some)]
    except ForeignError as error:
        texts = [str(error)]
    return _verdict(kind, compiler.name, iter(texts), cases)


def _foreign(compiler: Foreign, cases: Sequence[Case]) -> Iterator[str]:
    runs = [run for case in cases for run in case.runs]
    sensors, expected = [sensor for sensor, _ in runs], [outcome for _, outcome in runs]
    return outcomes.foreign_differences(compiler, cases[0].compiled, sensors, expected)


def interrupted(kind: type[Block], cases: Sequence[Case]) -> ContractVerdict:
    """A run that is begun anew, or goes on in another engine half-way, comes to the same: its state is all it has."""

    def texts() -> Iterator[str]:
        for case in cases:
            for sensor, expected in case.runs[:1]:
                again = outcome(sensor, case.ticks)
                if (again.ticks, packed(again.memory)) != (expected.ticks, packed(expected.memory)):
                    yield f"run {sensor.run} comes to something else when it is run again"
            yield from outcomes.resumed_differences(case.compiled, case.sensors[:2], case.outcomes[:2])

    return _verdict(kind, "state", texts(), cases, "keep what it remembers in its state, and return that from update")


def faults(ordinary: Sequence[Case], hostile: Sequence[Case]) -> ContractVerdict:
    """Tell what ends runs early; the checks of engines see that all end in the same tick."""
    parts = [f"{_ended(ordinary)} of {_runs(ordinary)} runs end early", f"{_ended(hostile)} of {_runs(hostile)}"]
    total: Counter[str] = sum((case.faults() for case in (*ordinary, *hostile)), Counter())
    said = ", ".join(f"{name} ({number})" for name, number in total.most_common())
    return ContractVerdict(
        "faults", "passed", f"{parts[0]}, {parts[1]} at the edges of arithmetic" + (f": {said}" if said else "")
    )


def _ended(cases: Sequence[Case]) -> int:
    return sum(case.faults().total() for case in cases)


def _runs(cases: Sequence[Case]) -> int:
    return sum(len(case.sensors) for case in cases)


def _verdict(
    kind: type[Block], check: str, texts: Iterator[str], cases: Sequence[Case], hint: str = ""
) -> ContractVerdict:
    first = [text for _, text in zip(range(_SHOWN), texts, strict=False)]
    hint = hint or "this is a defect of proofmass: please report it with the file of the block"
    ticks = sum(o.ticks for case in cases for o in case.outcomes)
    detail = f"{count(_runs(cases), 'run')}, {count(ticks, 'tick')}: the same bits"
    return verdict(check, [_different(kind, check, text, hint) for text in first], detail)


def _different(kind: type[Block], check: str, text: str, hint: str) -> Problem:
    message = "it remembers more than its state" if check == "state" else f"{check} and plain Python differ"
    return problem(kind, "", message, got=text, hint=hint)
