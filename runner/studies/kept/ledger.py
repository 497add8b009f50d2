"""The ledger of a study: the outcome of every run, in an SQLite file; a kill loses only runs in flight.

A row is a stretch of consecutive runs, under the number of the first, with eight-byte floats in the order of runs,
epochs and measures: a row for each run would take as long as the run itself where runs are short. No run is in two
of them, so no run is done twice.
"""

import difflib
import errno
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.run.result import Array
from proofmass.runner.studies.outcome.outcomes import Outcomes, together

FILE = "ledger.sqlite"
_HELD = "<f8"
_REFUSALS = {  # of the operating system, by the names of SQLite
    "SQLITE_FULL": errno.ENOSPC,
    "SQLITE_IOERR": errno.EIO,
    "SQLITE_READONLY": errno.EROFS,
    "SQLITE_CANTOPEN": errno.ENOENT,
    "SQLITE_PERM": errno.EACCES,
    "SQLITE_BUSY": errno.EBUSY,
}


class Ledger:
    """Runs of one study at all its epochs. `facts` determine the bits; a later start must have the same ones."""

    def __init__(self, path: Path | None, measures: Iterable[str], epochs: int, facts: dict[str, str]) -> None:
        self.measures, self.epochs = tuple(measures), epochs
        self.path = path
        with self._explained():
            self._data = sqlite3.connect(path or ":memory:", isolation_level=None)
        try:
            with self._explained():
                self._begin(facts)
        except BaseException:
            self.close()
            raise

    def _begin(self, facts: dict[str, str]) -> None:
        self._data.execute("PRAGMA journal_mode = WAL")
        self._data.execute("BEGIN IMMEDIATE")
        self._data.execute("CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, text TEXT)")
        before = dict(self._data.execute("SELECT name, text FROM facts"))
        if not before:
            self._data.execute("CREATE TABLE stretches (first INTEGER PRIMARY KEY, runs INTEGER, numbers BLOB)")
            self._data.execute(
                "CREATE TABLE faults (run INTEGER, epoch INTEGER, text TEXT, PRIMARY KEY (run, epoch)) WITHOUT ROWID"
            )
            self._data.executemany("INSERT INTO facts VALUES (?, ?)", facts.items())
        self._data.execute("COMMIT")
        for name, text in facts.items():
            if before and before.get(name) != text:
                raise self._refused(
                    f"belongs to another {name}",
                    _difference(before.get(name, ""), text),
                    "name another folder, or put back what was changed",
                )

    def keep(self, outcomes: Sequence[Outcomes]) -> None:
        """Write runs, all of them or none; runs that are there already are not changed."""
        all_of_them = together(outcomes, self.epochs, len(self.measures))
        with self._explained():
            self._data.execute("BEGIN IMMEDIATE")
            new = all_of_them.chosen(~np.isin(all_of_them.numbers, self._numbers(all_of_them.numbers)))
            for part in new.stretches():
                numbers = np.ascontiguousarray(part.values, dtype=_HELD).tobytes()
                row = (int(part.numbers[0]), len(part.numbers), numbers)
                self._data.execute("INSERT INTO stretches VALUES (?, ?, ?)", row)
            faults = ((run, epoch, text) for (run, epoch), text in new.faults.items())
            self._data.executemany("INSERT INTO faults VALUES (?, ?, ?)", faults)
            self._data.execute("COMMIT")

    def outcomes(self, below: int) -> Outcomes:
        """Return the outcomes of runs below a number, in their order."""
        rows = self._data.execute("SELECT first, runs, numbers FROM stretches WHERE first < ? ORDER BY first", (below,))
        parts = [
            Outcomes(np.arange(first, first + runs), np.frombuffer(blob, dtype=_HELD).reshape(self._shape(runs)), {})
            for first, runs, blob in rows
        ]
        found = together(parts, self.epochs, len(self.measures))
        faults = self._data.execute("SELECT run, epoch, text FROM faults")
        every = found._replace(faults={(run, epoch): text for run, epoch, text in faults})
        return every.chosen(every.numbers < below)

    def _shape(self, runs: int) -> tuple[int, int, int]:
        return runs, self.epochs, len(self.measures)

    def _numbers(self, about: Array) -> Array:
        """Return the numbers of runs in the ledger, between the least and the greatest of `about`."""
        if not len(about):
            return about
        least, greatest = int(about.min()), int(about.max())
        asked = "SELECT first, runs FROM stretches WHERE first <= ? AND first + runs > ? ORDER BY first"
        return _spelt_out(self._data.execute(asked, (greatest, least)))

    def close(self) -> None:
        """Close the file."""
        self._data.close()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn errors of SQLite into `OSError` for the disk, or `ModelError` for a file that is not a ledger.

        Raises `OSError`, `ModelError`.
        """
        try:
            yield
        except sqlite3.DatabaseError as error:
            name = getattr(error, "sqlite_errorname", "")
            number = next((number for start, number in _REFUSALS.items() if name.startswith(start)), 0)
            if number:
                kept = "; its runs are safe: repeat the command once this is cured"
                raise OSError(number, f"{error}{kept}", str(self.path)) from None
            raise self._refused("is not the ledger of a study", str(error), "name another folder") from None

    def _refused(self, message: str, got: str, hint: str) -> ModelError:
        return ModelError([Problem(message=message, file=str(self.path), got=got, hint=hint)])


def _difference(before: str, now: str) -> str:
    """Return the first lines that differ, before and now."""
    lines = list(difflib.unified_diff(before.splitlines(), now.splitlines(), lineterm="", n=0))
    changed = [line for line in lines[2:] if not line.startswith("@")]
    return "; ".join(changed[:6]) + ("; ..." if len(changed) > 6 else "")


def _spelt_out(stretches: Iterable[tuple[int, int]]) -> Array:
    """Return every number in stretches of consecutive ones."""
    return np.concatenate([np.empty(0, dtype=np.int64), *(np.arange(first, first + n) for first, n in stretches)])
