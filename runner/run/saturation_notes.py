"""Converters that stood at the end of their range: what a run tells by their codes alone."""

from collections.abc import Iterator

import numpy as np

from proofmass.blocks.declaration.catalog import family_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import split
from proofmass.runner.run.result import Result, pieces

NOTICED = 0.01  # part of the rows
FEWEST_BITS = 6  # with fewer, codes at the ends of the range are the rule, as in modulators


def saturation_notes(result: Result) -> Iterator[Problem]:
    """Yield a note for each recorded code of a converter that is its largest or smallest in over 1 % of the rows."""
    flat = flatten(result.graph)
    written = {probe.signal: shown.signal for probe, shown in zip(flat.probes, result.graph.probes, strict=True)}
    for signal, name in written.items():
        owner, port = split(signal)
        block = flat.blocks[owner]
        bits = getattr(block, "bits", 0)
        if port != "code" or family_of(type(block)) != "converters" or bits < FEWEST_BITS or name not in result.traces:
            continue
        values = result.traces[name].values
        end = 2 ** (bits - 1) - 1
        rows = sum(int((np.abs(values[first:last]) >= end).sum()) for first, last in pieces(len(values)))
        if rows > NOTICED * len(values):
            yield flat.placed(
                Problem(
                    message="the code stood at the end of its range",
                    got=f"{rows:,} of {len(values):,} rows at {end:,} or beyond",
                    hint="raise its reference, or lower the gain before it",
                    note=True,
                    path=("blocks", owner),
                )
            )
