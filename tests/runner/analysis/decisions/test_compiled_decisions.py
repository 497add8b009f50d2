"""Which sources of noise are recorded beside a quantiser of one bit."""

from collections.abc import Hashable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, simulate
from proofmass.blocks import Comparator, Constant, Difference, DiscreteIntegrator, Sum, WhiteNoise
from proofmass.runner.analysis.decisions import compiled_decisions
from proofmass.runner.analysis.decisions.compiled_decisions import (
    _decisions,
    _sources,
    _watching,
    compiled_runs,
)
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import RunOptions, simulate_plan


def modulator() -> Graph:
    """A loop of one bit that hears noise at its own rate, and at a slower one."""
    return Graph(
        name="",
        rate=1000,
        blocks={
            "hiss": WhiteNoise(density=0.1),
            "slow": WhiteNoise(density=0.1),
            "elsewhere": WhiteNoise(density=0.1),
            "level": Constant(value=0.1),
            "noisy": Sum(),
            "both": Sum(),
            "error": Difference(),
            "total": DiscreteIntegrator(output_unit="1"),
            "bit": Comparator(),
        },
        rates={"slow": 100},
        wires=[
            *("hiss.output -> noisy.first", "level.output -> noisy.second"),
            *("noisy.output -> both.first", "slow.output -> both.second"),
            *("both.output -> error.first", "bit.sign -> error.second"),
            *("error.output -> total.input", "total.output -> bit.input"),
        ],
    )


def test_sources_that_draw_a_number_at_each_decision() -> None:
    """Not one at another rate, none that the quantiser does not hear, and nothing that draws no number."""
    planned = plan(modulator())
    assert list(_sources(planned, set(planned.blocks) - {"elsewhere"}, {"bit": "sign"})) == ["hiss.output"]


@pytest.mark.parametrize(
    ("tick", "samples", "first"), [(0, 40, 16), (30, 41, 20), (2, 100, 32), (2, 1_024, 32), (17, 1_024, 64)]
)
def test_decisions_count_once_the_loop_has_settled(
    tick: int, samples: int, first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a multiple of 16 on, or of 1/32 of the run, or from its half: each sum of the loop beside its sign."""
    monkeypatch.setattr(compiled_decisions, "SETTLING", 16)
    graph, ports = modulator(), {"bit": "sign"}
    planned = plan(graph)
    watching, _ = _watching(planned, set(planned.blocks) - {"elsewhere"}, ports, 0)
    result = simulate_plan(watching, watching.graph.root, RunOptions(samples=samples))
    found = _decisions(watching, result, "bit", "sign").settled(tick)
    plain = simulate(replace(graph, probes=("total.output", "bit.sign")), samples=samples)
    expected = [np.asarray(plain[signal].values, dtype=float)[first:] for signal in ("total.output", "bit.sign")]
    np.testing.assert_allclose([found.values, found.levels], expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("tick", [0, 1_000])
def test_sources_are_those_that_the_decisions_have_heard(tick: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run of their own draws the same numbers, from the first decision that counts on."""
    monkeypatch.setattr(compiled_decisions, "_SHOWN", 100)
    graph = modulator()
    heard = set(graph.blocks) - {"elsewhere"}
    runs = compiled_runs(plan(graph), tick, heard, {"bit": "sign"}, (3, 4), 0, {})
    assert runs is not None
    run_for = tick + compiled_decisions.FEWEST + compiled_decisions.SETTLING
    first = run_for - len(runs["bit"].first.values)
    assert tick + compiled_decisions.SETTLING <= first < 0.1 * run_for
    for seed, run in zip((3, 4), (runs["bit"].first, runs["bit"].second), strict=True):
        plain = simulate(replace(graph, probes=("hiss.output", "total.output")), samples=first + 100, seed=seed)
        (drawn,) = run.sources
        np.testing.assert_array_equal(drawn, plain["hiss.output"].values[first:])
        np.testing.assert_allclose(run.values[:100], plain["total.output"].values[first:], atol=1e-12)


def test_operating_points_near_each_other_have_the_same_decisions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those from another place in the run on are others, and are drawn anew."""
    monkeypatch.setattr(compiled_decisions, "_SHOWN", 100)
    planned, kept = plan(modulator()), dict[Hashable, Any]()
    heard = set(planned.blocks) - {"elsewhere"}
    near, nearer, far = (
        compiled_runs(planned, tick, heard, {"bit": "sign"}, (3, 4), 0, kept) for tick in (1, 400, 40_000)
    )
    assert near is nearer
    assert near is not None
    assert far is not None
    assert len(far["bit"].first.values) < len(near["bit"].first.values)


def test_short_spans_take_fewer_decisions_than_long_ones() -> None:
    planned = plan(modulator())
    few, many = (_watching(planned, {*planned.blocks}, {"bit": "sign"}, span)[1] for span in (0, 1 << 30))
    assert few < 0.2 * many
