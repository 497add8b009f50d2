"""The ledger of a study: what every run gave, in an SQLite file; killed at any instant it loses what is in flight.

Run and epoch are the primary key, so that a run that is done is never done twice. Numbers are kept as eight-byte floats
to the bit: the columns have no type, by which SQLite leaves them as they are.
"""

import difflib
import errno
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from proofmass.blocks.problem import ModelError, Problem
from proofmass.runner.studies.sensor_runs import SensorRun

FILE = "ledger.sqlite"
_REFUSALS = {  # of the operating system, by the names of SQLite
    "SQLITE_FULL": errno.ENOSPC,
    "SQLITE_IOERR": errno.EIO,
    "SQLITE_READONLY": errno.EROFS,
    "SQLITE_CANTOPEN": errno.ENOENT,
    "SQLITE_PERM": errno.EACCES,
    "SQLITE_BUSY": errno.EBUSY,
}


class Ledger:
    """Runs of one study; `facts` are texts that decide over the bits, and must be those of an earlier start."""

    def __init__(self, path: Path | None, measures: Iterable[str], facts: dict[str, str]) -> None:
        self.measures = tuple(measures)
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
        columns = "".join(f', "{name}"' for name in self.measures)
        key = "PRIMARY KEY (run, epoch)"
        known = dict(self._data.execute("SELECT name, text FROM facts"))
        if not known:
            self._data.execute(
                f"CREATE TABLE runs (run INTEGER, epoch INTEGER, fault TEXT{columns}, {key}) WITHOUT ROWID"
            )
            self._data.executemany("INSERT INTO facts VALUES (?, ?)", facts.items())
        self._data.execute("COMMIT")
        for name, text in facts.items():
            if known and known.get(name) != text:
                raise self._refused(
                    f"belongs to another {name}",
                    _difference(known.get(name, ""), text),
                    "name another folder, or put back what was changed",
                )

    def keep(self, runs: Iterable[SensorRun]) -> None:
        """Write runs, all of them or none."""
        marks = ", ".join("?" * (3 + len(self.measures)))
        nothing = (None,) * len(self.measures)
        rows = [(r.run, r.epoch, r.fault, *(nothing if r.values is None else r.values)) for r in runs]
        with self._explained():
            self._data.execute("BEGIN IMMEDIATE")
            self._data.executemany(f"INSERT OR IGNORE INTO runs VALUES ({marks})", rows)
            self._data.execute("COMMIT")

    def done(self, epochs: int) -> set[int]:
        """Runs that are there at every epoch."""
        rows = self._data.execute("SELECT run FROM runs GROUP BY run HAVING COUNT(*) = ?", (epochs,))
        return {run for (run,) in rows}

    def runs(self, below: int) -> Iterator[SensorRun]:
        """What is there of the runs below a number, in the order of runs and epochs."""
        columns = "".join(f', "{name}"' for name in self.measures)
        rows = self._data.execute(
            f"SELECT run, epoch, fault{columns} FROM runs WHERE run < ? ORDER BY run, epoch", (below,)
        )
        for run, epoch, fault, *values in rows:
            yield SensorRun(run, epoch, None if fault else tuple(values), fault)

    def close(self) -> None:
        """Let go of the file."""
        self._data.close()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Errors of SQLite as what they are: a disk that refuses, or a file that is something else.

        Raises `OSError`, `ModelError`.
        """
        try:
            yield
        except sqlite3.DatabaseError as error:
            name = getattr(error, "sqlite_errorname", "")
            number = next((number for start, number in _REFUSALS.items() if name.startswith(start)), 0)
            if number:
                kept = "; runs that it holds are safe: the same command goes on when this is cured"
                raise OSError(number, f"{error}{kept}", str(self.path)) from None
            raise self._refused("is no ledger of a study", str(error), "name another folder") from None

    def _refused(self, message: str, got: str, hint: str) -> ModelError:
        return ModelError([Problem(message=message, file=str(self.path), got=got, hint=hint)])


def _difference(before: str, now: str) -> str:
    """The first lines that differ: as they were, and as they are."""
    lines = list(difflib.unified_diff(before.splitlines(), now.splitlines(), lineterm="", n=0))
    changed = [line for line in lines[2:] if not line.startswith("@")]
    return "; ".join(changed[:6]) + ("; ..." if len(changed) > 6 else "")
