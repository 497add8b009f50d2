"""An orbit that a run is far from: a slow filter of one pole, played a sequence, against its closed form."""

import pytest

from proofmass.blocks import DiscreteTransferFunction, Product, RepeatingSequence, Sine, UnitDelay
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.periodic import periodic_point
from proofmass.runner.planning.plan import plan

VALUES = (1.0, -2.0, 0.5, 3.0)


@pytest.mark.parametrize("pole", [0.5, 1.0 - 1e-4, 1.0 - 1e-6, -1.0 + 1e-6])
@pytest.mark.defect("S780", before="Newton's method moved the filter's coefficients: 2,555 for 625,001", after="states")
def test_newtons_method_moves_what_a_period_moves_alone(pole: float) -> None:
    """x[n+1] = a x[n] + u[n]: before each period x = (a^3 u0 + a^2 u1 + a u2 + u3) / (1 - a^4)."""
    graph = Graph(
        name="slow",
        rate="1 kHz",
        blocks={
            "drive": RepeatingSequence(values=VALUES),
            "filter": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -pole)),
        },
        wires=["drive.output -> filter.input"],
    )
    point = periodic_point(Course(plan(graph)))
    held = point.memory.buffers
    assert held["drive", "levels"] == list(VALUES)
    assert held["filter", "backward"] == [1.0, -pole]
    expected = sum(pole ** (3 - i) * value for i, value in enumerate(VALUES)) / (1.0 - pole**4)
    assert held["filter", "delays"][0] == pytest.approx(expected, rel=1e-9)


def test_a_carrier_that_no_state_reads_must_come_back_too() -> None:
    """Its product with a delayed sequence is an output, whose slopes follow it."""
    blocks = {"drive": RepeatingSequence(values=VALUES), "delay": UnitDelay(), "carrier": Sine(frequency=123.456789)}
    wires = ["drive.output -> delay.input", "delay.output -> product.first", "carrier.output -> product.second"]
    graph = Graph(name="", rate="1 kHz", blocks={**blocks, "product": Product()}, wires=wires)
    with pytest.raises(ModelError, match="a signal of the time does not fit it"):
        periodic_point(Course(plan(graph)))
