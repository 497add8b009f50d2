"""Margins say where a block of the loop has levels alone."""

import pytest

from proofmass import Graph, margins
from proofmass.blocks import DiscreteIntegrator, Gain, SigmaDeltaModulator


@pytest.mark.parametrize(("loop", "said"), [("modulator.output", True), ("plain.output", False)])
def test_a_modulator_in_the_loop_is_told_and_one_elsewhere_is_not(loop: str, said: bool) -> None:
    blocks = {
        "minus": Gain(gain="-1 V/(V*s)", input_unit="V*s", output_unit="V"),
        "modulator": SigmaDeltaModulator(),
        "integrator": DiscreteIntegrator(input_unit="V", output_unit="V*s"),
        "plain_minus": Gain(gain="-1 V/(V*s)", input_unit="V*s", output_unit="V"),
        "plain": DiscreteIntegrator(input_unit="V", output_unit="V*s"),
    }
    wires = [
        "minus.output -> modulator.input",
        "modulator.output -> integrator.input",
        "integrator.output -> minus.input",
        "plain.output -> plain_minus.input",
        "plain_minus.output -> plain.input",
    ]
    graph = Graph(name="two loops", rate="1 MHz", blocks=blocks, wires=wires)
    notes = margins(graph, loop).as_data()["notes"]
    assert any(note.startswith("modulator chooses one of some levels") for note in notes) == said
