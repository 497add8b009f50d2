"""The oscillator in registers of the library, against integers and as proved Verilog."""

import math

import numpy as np
import pytest

from proofmass.blocks import Constant, FixedQuantiser
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.reference import reference_of
from proofmass.runner.rtl.proof.proof import prove
from proofmass.runner.rtl.text.machine_verilog import machine_text
from proofmass.runner.run.simulate import simulate

FREQUENCY, RATE, TICKS = 8123.0, 1_000_000, 4096


def oscillating() -> Graph:
    part = read_graph(library_file("fixed_oscillator.toml")).with_parameters({"frequency": FREQUENCY})
    return Graph(
        name="oscillator",
        rate=RATE,
        samples=TICKS,
        blocks={"off": Constant(value=0.0), "word": FixedQuantiser(output_format=Fixed(16, 24)), "oscillator": part},
        wires=["off.output -> word.input", "word.output -> oscillator.control"],
        probes=["oscillator.sine", "oscillator.cosine"],
    )


def test_sine_and_cosine_against_integers() -> None:
    result = simulate(oscillating())
    step = round(FREQUENCY / RATE * 2**32)
    upper = (np.arange(TICKS, dtype=np.int64) * step % 2**32) >> 24
    angles = 2.0 * math.pi * (upper + 0.5) / 256.0
    assert (result["oscillator.sine"].values == np.round(np.sin(angles) * 2**14) / 2**14).all()
    assert (result["oscillator.cosine"].values == np.round(np.cos(angles) * 2**14) / 2**14).all()


def test_its_verilog_is_proved() -> None:
    pytest.importorskip("pyosys")
    pytest.importorskip("bitwuzla")
    planned = plan(oscillating())
    machine = compose(planned, name="oscillator")
    guesses = {(node.low, node.high) for module in machine.modules for node in module.live}
    proof = prove(reference_of(planned, machine), machine_text(machine), guesses)
    assert proof.proved == proof.goals > 2
    assert not proof.counter_examples
