"""Rows of one probe on their way into a trace."""

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.named_files import named
from proofmass.runner.plan.planned import Plan, PlannedProbe
from proofmass.runner.run.result import Trace


def room(planned: Plan, first: int, last: int) -> list[AnyArray]:
    """Return room for what the probes record in the ticks from `first` to before `last`."""
    return [np.zeros((probe.rows(first, last), *probe.shape), dtype=probe.dtype) for probe in planned.probes]


class Recorder:
    """Rows of one probe as they come: in memory, or in a `.npy` file if a folder is given, behind those that it has."""

    def __init__(self, probe: PlannedProbe, rows: int, folder: Path | None, kept: int = 0) -> None:
        self.probe, self.rows, self.count = probe, rows, kept
        self._path = folder / f"{probe.signal}.npy" if folder else None
        kind = np.float64 if probe.format else probe.dtype
        self._values: AnyArray = np.empty((0 if folder else rows, *probe.shape), dtype=kind)
        if self._path:
            with named(self._path), self._path.open("r+b" if kept else "wb") as file:
                self._write_head(file, rows)  # in place: killed here, the file still has the rows of the checkpoint
                file.truncate(file.tell() + kept * math.prod(probe.shape) * self._values.itemsize)

    def space(self, rows: int) -> AnyArray:
        """An array for the next rows, to be filled and then kept."""
        if self._path or self.probe.format:
            return np.empty((rows, *self.probe.shape), dtype=self.probe.dtype)
        return self._values[self.count : self.count + rows]

    def keep(self, rows: AnyArray) -> None:
        """Keep rows, filled in the array from `space` or brought along; mantissas in the unit of their signal."""
        if self.probe.format and rows.dtype != np.float64:
            rows = np.ldexp(rows.astype(np.float64), -self.probe.format.fraction)
        if self._path:
            with named(self._path), self._path.open("ab") as file:
                file.write(rows.tobytes())
        elif rows.base is not self._values:
            self._values[self.count : self.count + len(rows)] = rows
        self.count += len(rows)

    def finish(self, base_rate: Fraction, shown_in: str = "") -> Trace:
        """The trace of what was kept."""
        values = self._values[: self.count]
        if self._path:
            if self.count < self.rows:
                with named(self._path), self._path.open("r+b") as file:
                    self._write_head(file, self.count)
            values = np.load(self._path, mmap_mode="r")
        probe = self.probe
        facts = probe.signal, probe.unit, probe.doc, probe.stride
        return Trace(*facts, base_rate, values, probe.format, probe.phase, shown_in)

    def _write_head(self, file: Any, rows: int) -> None:
        """A `.npy` head of fixed length, so that the number of rows can be put right after an interruption."""
        head = (
            f"{{'descr': {self._values.dtype.str!r}, 'fortran_order': False, 'shape': {(rows, *self.probe.shape)}, }}"
        )
        file.write(b"\x93NUMPY\x01\x00" + (246).to_bytes(2, "little") + head.ljust(245).encode() + b"\n")
