"""proofmass: a block-diagram dataflow simulator for inertial sensors.

    from proofmass import Graph, simulate
    from proofmass.blocks.shift_register import ShiftRegister

The names below are imported when they are first used, so that `import proofmass` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from proofmass.blocks.declare import Block, Buffer, Input, block, param
    from proofmass.blocks.problem import ModelError, Problem
    from proofmass.graphs.graph import Graph, Probe, Wire
    from proofmass.graphs.study import Study
    from proofmass.graphs.study_reader import read_study
    from proofmass.graphs.toml_reader import read_graph
    from proofmass.graphs.toml_writer import write_graph
    from proofmass.runner.engine.faults import RunError
    from proofmass.runner.engine.ready import check
    from proofmass.runner.engine.result import Result, Trace
    from proofmass.runner.engine.simulate import simulate
    from proofmass.runner.margins.linearise import linearise
    from proofmass.runner.margins.margins import Margins
    from proofmass.runner.margins.stability import margins
    from proofmass.runner.studies.result import StudyResult
    from proofmass.runner.studies.study import replay, run_study

__version__ = "0.1.0"

_HOMES = {
    "Block": "blocks.declare",
    "Buffer": "blocks.declare",
    "Graph": "graphs.graph",
    "Input": "blocks.declare",
    "Margins": "runner.margins.margins",
    "ModelError": "blocks.problem",
    "Probe": "graphs.graph",
    "Problem": "blocks.problem",
    "Result": "runner.engine.result",
    "RunError": "runner.engine.faults",
    "Study": "graphs.study",
    "StudyResult": "runner.studies.result",
    "Trace": "runner.engine.result",
    "Wire": "graphs.graph",
    "block": "blocks.declare",
    "check": "runner.engine.ready",
    "linearise": "runner.margins.linearise",
    "margins": "runner.margins.stability",
    "param": "blocks.declare",
    "read_graph": "graphs.toml_reader",
    "read_study": "graphs.study_reader",
    "replay": "runner.studies.study",
    "run_study": "runner.studies.study",
    "simulate": "runner.engine.simulate",
    "write_graph": "graphs.toml_writer",
}

__all__ = [
    "Block",
    "Buffer",
    "Graph",
    "Input",
    "Margins",
    "ModelError",
    "Probe",
    "Problem",
    "Result",
    "RunError",
    "Study",
    "StudyResult",
    "Trace",
    "Wire",
    "block",
    "check",
    "linearise",
    "margins",
    "param",
    "read_graph",
    "read_study",
    "replay",
    "run_study",
    "simulate",
    "write_graph",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f"proofmass.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'proofmass' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
