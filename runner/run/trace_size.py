"""How large the traces of a run are, and whether a run without a folder can hold them."""

import math

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.plan.planned import Plan

IN_MEMORY = 256 << 20  # bytes of traces; more goes to files
_BYTES = {float: 8, int: 8, bool: 1}


def trace_bytes(planned: Plan, ticks: int) -> int:
    """Bytes of all traces."""
    return sum(p.rows(0, ticks) * math.prod(p.shape) * _BYTES[p.dtype] for p in planned.probes)


def refuse_large(planned: Plan, ticks: int, largest: int = IN_MEMORY) -> None:
    """Raise `ModelError` where the traces need a folder to be written to."""
    size = trace_bytes(planned, ticks)
    if size > largest:
        problem = Problem(
            message="the traces are too large for memory",
            key="probes",
            got=f"{size / 2**20:,.0f} MiB",
            expected=f"at most {largest >> 20} MiB without a folder",
            hint="say --out FOLDER to write them as they come, or thin a probe: every = 1000",
            path=("probes",),
        )
        raise ModelError([planned.graph.placed(problem)])
