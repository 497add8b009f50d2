"""Every block that becomes hardware, in one machine: its Verilog, compiled, gives the bits of plain Python.

That the compiled loop gives them too is the matter of test_engines_agree.py.
"""

from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.runner.contract.around import graph_around
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.bench.vectors import simulated
from proofmass.runner.rtl.machine.compose import compose, fits_hardware
from proofmass.runner.rtl.machine.reference import reference_of
from proofmass.runner.rtl.model import cxxrtl
from proofmass.runner.rtl.model.cxxrtl import VerilogModel
from proofmass.runner.rtl.text.machine_verilog import machine_text

pytest.importorskip("pyosys")

CLOCKS = 400
SOFTWARE = {"Correlator"}  # sums of codes: no format says how large they grow
CONSTANT = "fixedcoefficientmemory"
SHORT = {  # so that every output moves in so few clocks
    "ChipCounter": {"chips": 31},
    "Counter": {"modulus": 3},
    "FixedCorrelationCell": {"order": 4, "lag": 2},
    "MeasurementSlots": {"settling": 1e-4, "averaging": 1e-4},
}


@pytest.mark.parametrize("apart", [24, pytest.param(1, marks=pytest.mark.exhaustive)])
@pytest.mark.skipif(cxxrtl.compiler() is None, reason="needs a C++ compiler")
def test_every_block_does_in_a_model_what_it_does_in_python(
    apart: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every block, or every `apart`-th."""
    monkeypatch.setattr(cxxrtl, "_FLAGS", ("-O0", *cxxrtl._FLAGS[1:]))  # the model is built once and run for an instant
    kinds = [kind for name, kind in all_blocks().items() if fits_hardware(kind()) and name not in SOFTWARE]
    blocks = {kind.__name__.lower(): kind(**SHORT.get(kind.__name__, {})) for kind in kinds[::apart]}
    planned = plan(graph_around(blocks, tmp_path))
    machine = compose(planned)
    vectors = simulated(planned, machine, CLOCKS)
    found = VerilogModel(reference_of(planned, machine), machine_text(machine)).run(vectors.inputs, CLOCKS)
    signals = {port.name: port.text for port in machine.outputs}
    assert {text.partition("[")[0] for text in signals.values()} >= {
        f"{name}.{output}" for name, block in blocks.items() for output in type(block).outputs
    }
    different = [signals[name] for name, column in vectors.outputs.items() if not np.array_equal(found[name], column)]
    assert not different
    still = [signals[name] for name, column in vectors.outputs.items() if not np.diff(column).any()]
    assert all(signal.startswith(CONSTANT) for signal in still), still
