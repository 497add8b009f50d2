"""Results made by hand, for the tests of what is written and drawn from them."""

import dataclasses
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from proofmass.blocks import Constant, ShiftRegister, Sine
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.result import Result, Trace

RATE = Fraction(50_000)

GRAPH = Graph(
    name="a sine and bits",
    description="Two sources.",
    rate=RATE,
    blocks={
        "sine": Sine(amplitude="3 uV", frequency="1 kHz", unit="V"),
        "bits": ShiftRegister(length=4, taps=0xC, seed=1),
        "level": Constant(value="2.5 V", unit="V"),
    },
    probes=["sine.output", "bits.bit"],
)


def made_trace(signal: str, values: Any, unit: str = "1", stride: int = 1, doc: str = "What it is.") -> Trace:
    """A trace at the base rate of 50 kHz divided by `stride`."""
    return Trace(signal, unit, doc, stride, RATE, np.asarray(values))


def made_result(traces: Iterable[Trace], graph: Graph = GRAPH, **changes: Any) -> Result:
    """A finished result of these traces."""
    by_name = {trace.signal: trace for trace in traces}
    rows = max((len(trace.values) * trace.stride for trace in by_name.values()), default=0)
    facts = {"graph_hash": "0123abcd", "engine": "python", "proofmass": "0.1.0", "date": "2026-01-02T03:04:05+00:00"}
    result = Result(graph, by_name, rows, rows, RATE, 7, 0.25, 0.125, facts)
    return dataclasses.replace(result, **changes)


def mixed_result() -> Result:
    """A voltage, bits, a slower code and a vector of sums, on two axes of time."""
    rng = np.random.default_rng(3)
    return made_result(
        [
            made_trace("sine.output", rng.normal(size=60) * 1e-6, "V", doc="The sine wave."),
            made_trace("bits.bit", rng.integers(0, 2, 60).astype(bool)),
            made_trace("adc.code", rng.integers(-(2**62), 2**62, 6), stride=10, doc=""),
            made_trace("cells.sums", rng.integers(-9, 9, (6, 4)), "V/s", stride=10, doc="Sums, one per lag."),
        ]
    )
