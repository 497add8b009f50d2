"""Parameters that are true or false are a part of the loop: a plan with others has a loop of its own."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from proofmass import read_graph
from proofmass.graphs.files.library import library_file
from proofmass.runner.plan.keys import ConstantOf
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.reference.interpret import Interpreter
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

TICKS = 40


def rows_of(engine: Any, planned: Plan) -> bytes:
    """What the probes of the first ticks hold."""
    rows = [np.zeros((probe.rows(0, TICKS), *probe.shape), dtype=probe.dtype) for probe in planned.probes]
    engine.advance(TICKS, rows)
    return b"".join(array.tobytes() for array in rows)


@pytest.mark.parametrize(("name", "parameter"), [("plates", "push_pull"), ("coriolis_on_sense", "positive")])
def test_another_truth_is_another_loop(name: str, parameter: str) -> None:
    first = plan(read_graph(library_file("vibratory_gyroscope.toml")))
    block: Any = first.blocks[name]
    other = varied(first, {name: dataclasses.replace(block, **{parameter: not getattr(block, parameter)})})
    stiffer: Any = first.blocks["drive"]
    alike = varied(first, {"drive": dataclasses.replace(stiffer, stiffness=150.0)})
    compiled = CompiledPlan(first)
    assert ConstantOf(name, parameter) not in compiled.written.constants.kinds
    assert alike.same_sizes(first) and not other.same_sizes(first)  # noqa: PT018
    made = {}
    for planned in (first, other, alike):
        made[id(planned)] = rows_of(CompiledLoop(planned, 1, memory=start(planned), compiled=compiled), planned)
        assert made[id(planned)] == rows_of(Interpreter(planned, 1), planned)
    assert len(set(made.values())) == 3
