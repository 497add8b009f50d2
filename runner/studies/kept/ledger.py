"""The ledger of a study: the outcome of every run, in an SQLite file; a kill loses only runs in flight.

A row is a stretch of consecutive runs, under the number of the first, with eight-byte floats in the
order of runs, epochs and measures: a row for each run would take as long as the run itself where
runs are short. No run is in two of them, so no run is done twice. Each has a check sum of itself
and of the facts that determine its bits.
"""

import difflib
import errno
import hashlib
import json
import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.kept.pages import stored_rows
from proofmass.runner.studies.outcome.outcomes import Outcomes, together

FILE = "ledger.sqlite"
VERSION = 2  # of the form of the file; the first had no check sums
_FLOATS = "<f8"
_REPAIR = "proofmass montecarlo --repair keeps the runs that are whole, and runs the others again"
_REFUSALS = {  # of the operating system, by the names of SQLite
    "SQLITE_FULL": errno.ENOSPC,
    "SQLITE_IOERR": errno.EIO,
    "SQLITE_READONLY": errno.EROFS,
    "SQLITE_CANTOPEN": errno.ENOENT,
    "SQLITE_PERM": errno.EACCES,
    "SQLITE_BUSY": errno.EBUSY,
}


class Ledger:
    """Runs of one study at all its epochs. `facts` determine the bits; a later start must have the same ones.

    Raises `ModelError` if the file is of another study, or is damaged; `OSError` if the disk
    refuses.
    """

    def __init__(self, path: Path | None, measures: Iterable[str], epochs: int, facts: dict[str, str]) -> None:
        self.measures, self.epochs = tuple(measures), epochs
        self.path = path
        self._facts = _told(facts)
        with self._explained():
            self._data = sqlite3.connect(_address(path), isolation_level=None, uri=True)
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
            self._data.execute(f"PRAGMA user_version = {VERSION}")
            self._data.execute(
                "CREATE TABLE stretches (first INTEGER PRIMARY KEY, runs INTEGER, numbers BLOB, faults TEXT, sum BLOB)"
            )
            self._data.executemany("INSERT INTO facts VALUES (?, ?)", facts.items())
        self._data.execute("COMMIT")
        self._facts = _told(before or facts)
        for name, text in facts.items():
            if before and before.get(name) != text:
                raise self._refused(
                    f"belongs to another {name}",
                    _difference(before.get(name, ""), text),
                    "name another folder, or put back what was changed",
                )
        (version,) = self._data.execute("PRAGMA user_version").fetchone()
        if version != VERSION:
            hint = "name another folder: its runs have no check sums"
            raise self._refused("is the ledger of another version of proofmass", f"form {version}", hint)

    def keep(self, outcomes: Sequence[Outcomes]) -> None:
        """Write runs, all of them or none; runs that are there already are not changed."""
        all_of_them = together(outcomes, self.epochs, len(self.measures))
        with self._explained():
            self._data.execute("BEGIN IMMEDIATE")
            new = all_of_them.chosen(~np.isin(all_of_them.numbers, self._numbers(all_of_them.numbers)))
            for part in new.stretches():
                first, runs = int(part.numbers[0]), len(part.numbers)
                numbers = np.ascontiguousarray(part.values, dtype=_FLOATS).tobytes()
                faults = json.dumps([[*key, text] for key, text in part.faults.items()])
                row = (first, runs, numbers, faults, _sum(self._facts, first, runs, numbers, faults))
                self._data.execute("INSERT INTO stretches VALUES (?, ?, ?, ?, ?)", row)
            self._data.execute("COMMIT")

    def outcomes(self, below: int) -> Outcomes:
        """Return the outcomes of runs below a number, in their order; raises `ModelError` if a row is damaged."""
        with self._explained():
            (word,) = self._data.execute("PRAGMA quick_check(1)").fetchone()
            if word != "ok":
                raise self._damaged(word)
            parts = list(self._stretches(0, below))
        every = together(parts, self.epochs, len(self.measures))
        if (np.diff(every.numbers) < 1).any():
            raise self._damaged("runs stand in two rows")
        return every.chosen(every.numbers < below)

    def _stretches(self, first: int, below: int) -> Iterator[Outcomes]:
        asked = "SELECT first, runs, numbers, faults, sum FROM stretches WHERE first >= ? AND first < ? ORDER BY first"
        for *row, kept in self._data.execute(asked, (first, below)):
            if kept != _sum(self._facts, *row):
                raise self._damaged(f"the row of the runs from {row[0]} on differs from its check sum")
            yield _held(row, self.epochs, len(self.measures))

    def _numbers(self, about: AnyArray) -> AnyArray:
        """Return the numbers of runs in the ledger, between the least and greatest of `about`."""
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
                told = f"{error}; {self._kept()}repeat the command once this is cured"
                raise OSError(number, told, str(self.path)) from None
            if name.startswith(("SQLITE_CORRUPT", "SQLITE_CONSTRAINT")):
                raise self._damaged(str(error)) from None
            raise self._refused("is not the ledger of a study", str(error), "name another folder") from None

    def _kept(self) -> str:
        """Return what became of runs that were written before the disk refused; empty where they cannot be read."""
        try:
            self._data.rollback()
            (rows,) = self._data.execute("SELECT count(*) FROM stretches").fetchone()
        except (sqlite3.DatabaseError, AttributeError):  # without the table, or the file
            return ""
        return "its runs are safe: " if rows else "no run is kept: "

    def _damaged(self, got: str) -> ModelError:
        return self._refused("is damaged", got, _REPAIR)

    def _refused(self, message: str, got: str, hint: str) -> ModelError:
        return Problem(message=message, file=str(self.path), got=got, hint=hint).error


def repair(path: Path, measures: Sequence[str], epochs: int, facts: dict[str, str]) -> None:
    """Write a damaged ledger anew with all its whole runs; the old file stays beside it as `.damaged`.

    Raises `ModelError` if no run is whole.
    """
    partial = path.with_suffix(".partial")
    found = together(list(whole_stretches(path, epochs, len(measures), facts)), epochs, len(measures))
    if not len(found.numbers):
        hint = "name another folder, or remove the file: its runs are run again"
        raise Problem(message="holds no whole run of this study", file=str(path), hint=hint).error
    partial.unlink(missing_ok=True)
    anew = Ledger(partial, measures, epochs, facts)
    anew.keep([found.chosen(np.unique(found.numbers, return_index=True)[1])])
    anew.close()
    path.replace(path.with_suffix(".damaged"))
    for ending in ("-wal", "-shm"):  # of the old file: SQLite would write them into the new one
        Path(f"{path}{ending}").unlink(missing_ok=True)
    partial.replace(path)


def whole_stretches(path: Path, epochs: int, measures: int, facts: dict[str, str]) -> Iterator[Outcomes]:
    """Yield the stretches that are whole, in any order, whatever is damaged beside them."""
    told = _told(facts)
    for first, *columns in stored_rows(path):
        if len(columns) == 5 and columns[4] == _sum(told, first, *columns[1:4]):
            yield _held([first, *columns[1:4]], epochs, measures)


def _held(row: Sequence[Any], epochs: int, measures: int) -> Outcomes:
    """Return the runs of a row."""
    first, runs, numbers, faults = row
    values = np.frombuffer(numbers, dtype=_FLOATS).reshape(runs, epochs, measures)
    told = {(run, epoch): text for run, epoch, text in json.loads(faults)}
    return Outcomes(np.arange(first, first + runs), values, told)


def _sum(facts: bytes, first: int, runs: int, numbers: bytes, faults: str) -> bytes:
    """Return the check sum of a row: a row of another study differs too."""
    digest = hashlib.sha256(b"%b\0%b\0" % (facts, repr((first, runs, faults)).encode()))
    digest.update(numbers if isinstance(numbers, bytes) else b"damaged")
    return digest.digest()


def _address(path: Path | None) -> str:
    """Return the file as SQLite is told of it: where nothing can be written beside it, that nothing changes it."""
    if path is None:
        return ":memory:"
    still = path.exists() and not os.access(path.parent, os.W_OK) and not Path(f"{path}-wal").exists()
    return f"{path.absolute().as_uri()}{'?immutable=1' if still else ''}"


def _told(facts: dict[str, str]) -> bytes:
    """Return facts as bytes for check sums."""
    return json.dumps(sorted(facts.items())).encode()


def _difference(before: str, now: str) -> str:
    """Return the first lines that differ, before and now."""
    lines = list(difflib.unified_diff(before.splitlines(), now.splitlines(), lineterm="", n=0))
    changed = [line for line in lines[2:] if not line.startswith("@")]
    return "; ".join(changed[:6]) + ("; ..." if len(changed) > 6 else "")


def _spelt_out(stretches: Iterable[tuple[int, int]]) -> AnyArray:
    """Return every number in stretches of consecutive ones."""
    return np.concatenate([np.empty(0, dtype=np.int64), *(np.arange(first, first + n) for first, n in stretches)])
