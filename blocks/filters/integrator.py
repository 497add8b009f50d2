"""Integrator: x' = gain u, gain / s; continuous."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class Integrator(Block):
    """Integral over time: of a velocity, a current in a capacitor. At ticks DiscreteIntegrator."""

    gain: float = param("({output_unit})/({input_unit})/s", "Growth of the output per second and input.", default=1.0)
    initial: float = param("{output_unit}", "Output at the start.", default=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="s")

    input = Input("{input_unit}", "Signal to integrate.")


class State(NamedTuple):
    total: float


@Integrator.start
def start(p: Integrator) -> State:
    return State(p.initial)


@Integrator.output("{output_unit}")
def output(p: Integrator, x: State) -> float:
    """The integral."""
    return x.total


@Integrator.derivative(linear=True)
def derivative(p: Integrator, x: State, input: float) -> State:
    return State(p.gain * input)
