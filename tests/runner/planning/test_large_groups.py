"""Continuous groups of many states: the same bits from the loop that sums rows as from plain Python, in seconds."""

import numpy as np
import pytest
import scipy.linalg

from proofmass.blocks import LowPass, Sine, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.continuous.exact_hold import MANY_COLUMNS
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engines import choose
from proofmass.runner.run.estimates import interpreting_seconds
from proofmass.runner.run.simulate import simulate
from proofmass.runner.targets.native import CompiledLoop

STATES, CORNER, RATE = 60, 100.0, 10_000.0


@pytest.fixture(scope="module")
def chain() -> Graph:
    return chain_of(STATES)


def chain_of(states: int) -> Graph:
    """Low-pass filters in a row, all of one group."""
    blocks: dict[str, Block] = {"source": Sine(frequency=37.0)}
    wires, last = [], "source.output"
    for number in range(states):
        blocks[f"filter_{number}"] = LowPass(corner_frequency=CORNER)
        wires.append(f"{last} -> filter_{number}.input")
        last = f"filter_{number}.output"
    return Graph(name="chain", rate=RATE, blocks=blocks, wires=wires, probes=[last, "filter_9.output", "source.output"])


@pytest.mark.exhaustive
@pytest.mark.defect("H4", before="60 states compiled for minutes (100 s of CPU for 50)", after="10 s of CPU")
def test_both_engines_give_the_same_bits(chain: Graph) -> None:
    assert STATES > MANY_COLUMNS
    plain, compiled = (simulate(chain, samples=80, engine=engine) for engine in ("python", "compiled"))
    for name, trace in plain.traces.items():
        assert np.array_equal(trace.values, compiled[name].values), name


def test_the_largest_products_that_plain_python_writes_out_take_longest() -> None:
    """A column of each is the input. NumPy multiplies larger matrices, fifty times as fast."""
    fewer, most, more = (interpreting_seconds(plan(chain_of(MANY_COLUMNS - 1 + number)), 0) for number in (-1, 0, 1))
    assert more < fewer < most


def test_the_group_is_the_matrix_exponential(chain: Graph) -> None:
    """x[n+1] = exp(A T) x[n] + A^-1 (exp(A T) - 1) B u[n], A with -w on its diagonal and w below it."""
    w = 2.0 * np.pi * CORNER
    a = w * (np.eye(STATES, k=-1) - np.eye(STATES))
    transition = scipy.linalg.expm(a / RATE)
    entry = np.linalg.solve(a, transition - np.eye(STATES)) @ (w * np.eye(STATES)[:, 0])
    found = simulate(chain, samples=80, engine="python")
    x, last = np.zeros(STATES), []
    for u in found["source.output"].values:
        last.append(x[9])
        x = transition @ x + entry * u
    assert max(last) > 1e-4
    assert found["filter_9.output"].values == pytest.approx(last, rel=0.0, abs=1e-12 * max(last))


@pytest.mark.exhaustive
@pytest.mark.defect("H4", before="auto compiled 1,000 blocks in a row for minutes", after="plain Python unless it pays")
def test_the_choice_of_an_engine_counts_what_large_graphs_take_to_compile() -> None:
    """Compiling takes seconds for a thousand of them, more than plain Python for a few hundred ticks."""
    blocks: dict[str, Block] = {"source": Sine(frequency=37.0)}
    wires, last = [], "source.output"
    for number in range(1000):
        blocks[f"delay_{number}"] = UnitDelay()
        wires.append(f"{last} -> delay_{number}.input")
        last = f"delay_{number}.output"
    planned = plan(Graph(name="row", rate=RATE, blocks=blocks, wires=wires, probes=[last]))
    assert choose(planned, 300, "auto") == "python"
    assert choose(planned, 10_000, "auto") == "compiled"


@pytest.mark.defect("H4", before="400 states: 43 ticks in 18 s", after="matrices made once a run")
def test_matrices_are_made_in_the_first_call_alone(chain: Graph) -> None:
    """Many calls give the bits of one; matrices that are zeroed between two calls stay so, and the states with them."""
    planned = plan(chain)

    def run(*ends: int, emptied: bool = False) -> np.ndarray:
        loop = CompiledLoop(planned, seed=0)
        last = np.full(ends[-1], np.nan)
        for end in ends:
            rows = [last[loop.tick : end], *(np.empty(end - loop.tick) for _ in planned.probes[1:])]
            assert loop.advance(end, rows)
            if emptied:
                loop._scratch[np.isfinite(loop._scratch) & (loop._scratch != 1.0)] = 0.0
        return last

    whole = run(90)
    assert np.array_equal(whole, run(1, 2, 30, 90))
    assert whole[89] != 0.0
    assert not run(30, 90, emptied=True)[31:].any()
