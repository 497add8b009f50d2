"""Size of the traces of a run: do memory and disk hold them, and does a folder wait for more?"""

import math
import shutil
from pathlib import Path

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.plan.planned import Plan

IN_MEMORY = 256 << 20  # bytes of traces; more goes to files
LONG = 100_000_000  # ticks: some seconds at some tens of nanoseconds each


def trace_bytes(planned: Plan, ticks: int) -> int:
    """Bytes of all traces."""
    return sum(p.rows(0, ticks) * math.prod(p.shape) * (1 if p.dtype is bool else 8) for p in planned.probes)


def size_text(planned: Plan, ticks: int) -> str:
    """Return how many ticks a long run has, and what it writes; empty for a short one.

    Long is what takes more than some seconds, or traces of more than 256 MiB.
    """
    size = trace_bytes(planned, ticks)
    if ticks < LONG and size <= IN_MEMORY:
        return ""
    return f"{ticks:,} ticks, {size / 2**20:,.0f} MiB of traces"


def refuse_full(planned: Plan, ticks: int, folder: Path) -> None:
    """Raise `ModelError` where the disk of a folder has no room for the traces and the results made of them."""
    size, above = trace_bytes(planned, ticks), folder
    while not above.is_dir():
        above = above.parent
    kept = sum(file.stat().st_size for file in above.glob("*.npy")) if above == folder else 0  # of this run before
    free = shutil.disk_usage(above).free + kept
    if size > free:
        problem = Problem(
            message="the traces do not fit on the disk",
            got=f"{size / 2**30:,.1f} GiB",
            expected=f"at most {free / 2**30:,.1f} GiB, which {above} has left",
            hint="run for a shorter time, thin a probe: every = 1000, or write to another folder",
            path=("probes",),
        )
        raise planned.graph.placed(problem).error


def refuse_large(planned: Plan, ticks: int, largest: int = IN_MEMORY) -> None:
    """Raise `ModelError` where the traces need a folder to be written to."""
    size = trace_bytes(planned, ticks)
    if size > largest:
        problem = Problem(
            message="the traces are too large for memory",
            got=f"{size / 2**20:,.0f} MiB",
            expected=f"at most {largest >> 20} MiB without a folder",
            hint="say --out FOLDER to write them as they come, or thin a probe: every = 1000",
            path=("probes",),
        )
        raise planned.graph.placed(problem).error
