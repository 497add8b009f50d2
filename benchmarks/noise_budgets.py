"""Noise budgets of every noisy graph of the library beside its own runs.

python -m benchmarks.noise_budgets [NAME ...]

A row is an output that is probed or measured and that noise reaches. The noise of a run is what two runs of different
seeds differ by, over sqrt(2): signals drop out. Columns: the rms by the budget and by these runs; how many lines of the
Welch spectrum lie in the band that holds 99 % of them; by how many standard errors the mean square of 1,000 runs in
lanes differs from the predicted one, which should be 3 at most. What misses a criterion has a `!`.

Expected lines are those of the window: the predicted density, spread by its transform. The mean square of an output
that settles slowly, or not at all, is that of its increment over half the run, with a `d`: a density S gives it
integral of 4 S sin^2(pi f t).

Where no operating point comes back, as with carriers that fit no period, and where there is one value a run, as of a
calibration, the row is that of `deviation_over_runs`, and ends with the time of the value. The lines are those of the
last values of 200 runs. What is refused has its reason in the place of numbers; the last line counts all.
"""

import signal
import sys
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import proofmass
from benchmarks.noise_comparison import (
    LARGE_NOISE,
    AtEnd,
    Case,
    NothingToCompareError,
    Row,
    Subject,
    at_end,
    noisy_graphs,
    row,
    scatters,
)
from proofmass import ModelError

PATIENCE = 120  # seconds of processor time for a row, and for the last values of all outputs of a graph
PROCESSES = 2
ENOUGH, MOST_ERRORS = 0.95, 3.0  # part of the lines, and standard errors, that the criteria ask for
ROUNDING = "rounding alone"


@dataclass(frozen=True)
class Compared:
    """A line of the table: an output with its figures, or with the reason for which there are none."""

    output: str
    row: Row | None = None
    errors: float | None = None  # of the mean square of many runs, in standard errors
    last: AtEnd | None = None
    kind: str = ""  # of the reason
    reason: str = ""

    @property
    def inside(self) -> float | None:
        """Part of the lines of the spectrum, where there is one."""
        return self.row.inside if self.row else self.last.inside if self.last else None

    @property
    def spectrum_holds(self) -> bool:
        """Return whether enough lines of the spectrum lie in their band."""
        return self.inside is not None and self.inside >= ENOUGH

    @property
    def rms_holds(self) -> bool:
        """Return whether the mean square of many runs is near the predicted one."""
        return self.errors is not None and abs(self.errors) <= MOST_ERRORS


class OutOfTimeError(BaseException):
    """What takes too long; not an `Exception`, which a block that fails raises."""


def _out_of_time(*_: Any) -> None:
    raise OutOfTimeError


def compared(path: Path, outputs: Sequence[str]) -> list[Compared]:
    """Return the lines of a graph."""
    signal.signal(signal.SIGPROF, _out_of_time)
    subject = Subject(proofmass.read_graph(path))
    lines = {output: _line(subject, path, output) for output in outputs}
    rows = [line.row for line in lines.values() if line.row]
    for one, errors in zip(rows, scatters(subject, rows) if rows else (), strict=True):
        lines[one.case.output] = replace(lines[one.case.output], errors=errors)
    left = [output for output, line in lines.items() if not line.row and line.kind not in (ROUNDING, LARGE_NOISE)]
    if left:
        for output, answer in zip(left, _last_values(subject, left), strict=True):
            line = lines[output]
            lines[output] = (
                replace(line, last=answer, errors=answer.errors)
                if isinstance(answer, AtEnd)
                else replace(line, reason=f"{line.reason}; {answer}")
            )
    return list(lines.values())


def _line(subject: Subject, path: Path, output: str) -> Compared:
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        return Compared(output, row(Case(path.name, output), subject))
    except ModelError as error:
        problem = error.problems[0]
        return Compared(output, kind=_kind(problem.message), reason=f"{problem.message} ({problem.got})")
    except NothingToCompareError as error:
        return Compared(output, kind=error.args[0], reason=error.args[1])
    except OutOfTimeError:
        return Compared(output, kind="too slow", reason=f"more than {PATIENCE} s of processor time")
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def _last_values(subject: Subject, outputs: Sequence[str]) -> list[AtEnd | str]:
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        return at_end(subject, outputs)
    except OutOfTimeError:
        return [f"its run takes more than {PATIENCE} s of processor time to follow"] * len(outputs)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def _kind(message: str) -> str:
    """Return a refusal without names and numbers."""
    kinds = {"does not repeat": "the operating point does not repeat", "no noise reaches": "no noise reaches it"}
    return next((kind for part, kind in kinds.items() if part in message), message)


def printed(graph: str, line: Compared) -> str:
    """Return a line of the table."""
    start = f"{graph:<32} {line.output:<31} "
    if line.row:
        budget, first = line.row.budget, line.row.budget.sources[0]
        figures, seconds = (budget.rms, line.row.rms), line.row.seconds
        end = f"{first.block} {100.0 * first.share:.0f} %{', ' + line.row.at if line.row.at else ''}"
    elif line.last:
        value = line.last.value
        figures, seconds = (value.deviation, line.last.deviation), line.last.seconds
        block, part = next(iter(value.sources.items()))
        end = f"{block} {100.0 * (part / value.deviation) ** 2:.0f} %, at {value.time:g} s"
    else:
        return start + line.reason
    inside = "one value " if line.inside is None else f"{100.0 * line.inside:.1f} %{_mark(line.spectrum_holds)} "
    errors = f"{line.errors or 0.0:+.2f} SE{_mark(line.rms_holds)}"
    return (
        f"{start}{figures[0]:10.4g} {figures[1]:10.4g} {inside:>10} {errors:>11}"
        f"{'d' if line.row and line.row.increments else ' '} {seconds:6.2f} s  {end}"
    )


def _mark(holds: bool) -> str:
    return " " if holds else "!"


def summary(lines: Sequence[Compared]) -> str:
    """Return how many outputs keep the criteria, and how many are left out for which reasons."""
    figures = [line for line in lines if line.row or line.last]
    spectra = [line for line in figures if line.inside is not None]
    both = sum(line.spectrum_holds and line.rms_holds for line in spectra)
    single = [line for line in figures if line.inside is None]
    left = Counter(line.kind for line in lines if not line.row and not line.last)
    reasons = ", ".join(f"{count} ({kind})" for kind, count in left.most_common())
    return (
        f"{len(figures)} of {len(lines)} outputs are compared. Of {len(spectra)} with a spectrum"
        f" {sum(line.spectrum_holds for line in spectra)} keep it, {sum(line.rms_holds for line in spectra)} the rms,"
        f" {both} both. Of {len(single)} with one value a run {sum(line.rms_holds for line in single)} keep the rms."
        f" Left out are {reasons or 'none'}."
    )


def main() -> None:
    """Print the table."""
    began, everything = time.perf_counter(), list[Compared]()
    graphs = [(path, outputs) for path, _, outputs in noisy_graphs(sys.argv[1:])]
    heads = f"{'predicted':>10} {'of runs':>10} {'inside':>10} {'1,000 runs':>11} {'budget':>9}  largest source"
    print(f"{'graph':<32} {'output':<31} {heads}")
    with ProcessPoolExecutor(min(PROCESSES, len(graphs))) as pool:
        waiting = {pool.submit(compared, path, outputs): path for path, outputs in graphs}
        for number, done in enumerate(as_completed(waiting), 1):
            lines = done.result()
            everything += lines
            for line in lines:
                print(printed(waiting[done].stem, line), flush=True)
            print(f"{number} of {len(graphs)} graphs, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    print(summary(everything))


if __name__ == "__main__":
    main()
