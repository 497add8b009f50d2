"""Vectors against the traces of a simulation."""

import numpy as np
import pytest

from proofmass.blocks import FixedMassSpringDamper, FixedQuantiser, Sine
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.bench.vectors import simulated
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.simulate import simulate
from tests.by_hand.machines import differences, loop_at_rates, made


def test_slow_signals_are_held_between_their_ticks() -> None:
    graph = loop_at_rates()
    _, vectors = made(graph)
    result = simulate(graph, engine="python")
    assert vectors.clocks == result.ticks == 121
    slow = result["integrator.output"].mantissas
    assert np.array_equal(vectors.outputs["integrator_output"], np.repeat(slow, 3)[:121])
    assert np.array_equal(vectors.outputs["error_output"], result["error.output"].mantissas)


def test_a_slow_block_alone_is_seen_at_its_own_ticks() -> None:
    graph = loop_at_rates()
    machine, vectors = made(graph, "integrator", clocks=30)
    assert machine.rate == 2000
    result = simulate(graph, samples=90, engine="python")
    assert np.array_equal(vectors.outputs["output_"], result["integrator.output"].mantissas)


def test_more_than_64_bits_inside_are_simulated_too() -> None:
    """All words of 32 bits, the reference model whose 21 multipliers Sarraf et al. 2012 give in table 3."""
    wide = dict.fromkeys(("large_format", "damping_format", "small_format", "step_format"), Fixed(32, 20))
    sources = {name: FixedQuantiser(output_format=Fixed(32, 20), unit=unit) for name, unit in UNITS.items()}
    graph = Graph(
        name="wide",
        rate="2.4576 MHz",
        samples=40,
        blocks={
            **{f"{name}_in": Sine(amplitude=900.0, frequency=9e4, unit=unit) for name, unit in UNITS.items()},
            **sources,
            "model": FixedMassSpringDamper(**wide),
        },
        wires=[f"{name}_in.output -> {name}.input" for name in UNITS]
        + [f"{name}.output -> model.{name}" for name in UNITS],
        probes=["model.displacement"],
    )
    with pytest.raises(ModelError, match="wider than the 64 bits of compiled code"):
        plan(graph)
    machine, vectors = made(graph)
    assert len(set(vectors.outputs["displacement"].tolist())) > 30
    assert differences(machine, vectors) == []


UNITS = {"acceleration": "um/ms^2", "stiffness": "1/ms^2", "damping": "1/ms"}


def test_without_a_length_the_graph_must_say_one() -> None:
    graph = loop_at_rates()
    planned = plan(
        Graph(
            name="g",
            rate=graph.rate,
            blocks=graph.blocks,
            rates=graph.rates,
            wires=[str(wire) for wire in graph.wires],
            probes=["integrator.output"],
        )
    )
    with pytest.raises(ModelError, match="how long to run is not said"):
        simulated(planned, compose(planned))


def test_a_simulation_that_fails_is_told() -> None:
    blocks = {
        "sine": Sine(amplitude=9.0),
        "in": FixedQuantiser(overflow="refuse"),
        "gain": loop_at_rates().blocks["error"],
    }
    graph = Graph(
        name="g",
        rate=1000,
        blocks=blocks,
        wires=["sine.output -> in.input", "in.output -> gain.first", "in.output -> gain.second"],
        probes=["gain.output"],
    )
    with pytest.raises(RunError, match=r"in\.output"):
        made(graph, clocks=1000)
