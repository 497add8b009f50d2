"""The loop of a plan as a page carries it: a module of WebAssembly, its memory at tick 0, and the
place of everything.

The page computes the bits of the command line: constants that follow from parameters are made in
the module itself, by the functions of the blocks, and groups of continuous blocks keep the method
of the plan.
"""

import base64
import gzip
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.instance import format_of, unit_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.measures import MEASURES
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.plot import holds
from proofmass.runner.plan.keys import ConstantOf, ParameterOf, WireOf
from proofmass.runner.plan.measuring import planned_derived
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan, PlannedMeasure, PlannedProbe
from proofmass.runner.program.form import Program
from proofmass.runner.program.measure_formulas import measure_formulas
from proofmass.runner.program.slots import INTEGERS
from proofmass.runner.program.tick import write_tick
from proofmass.runner.program.tick_loop import TickLoop
from proofmass.runner.targets.llvm_functions import externals
from proofmass.runner.targets.llvm_text import ENTRY, content_of
from proofmass.runner.targets.native import arrays_of, dtype_of, finite_places, moving
from proofmass.runner.targets.wasm import WasmModule, wasm_module

SHOWN_IN = " as "  # between a unit and that in which its values are shown
_LINE = 64  # bytes that arrays are aligned to
_DTYPES = {float: "float64", int: "int64", bool: "bool"}
_MOST_MODULES = 8
_modules: dict[str, WasmModule] = {}


@dataclass(frozen=True)
class CarriedLoop:
    """A loop that takes the parameters `varied` anew in every run."""

    plan: Plan
    written: TickLoop
    module: WasmModule
    varied: tuple[Endpoint, ...]

    def as_data(self) -> dict[str, Any]:
        """Plain data, for the page."""
        arrays = self._arrays()
        image, places = bytearray(), []
        for array in arrays:
            image += bytes(-len(image) % _LINE)
            places.append({"at": len(image), "length": array.size})
            image += array.tobytes()
        rate = self.plan.schedule.base_rate
        formulas = [_described(one) | {"read": None} for one in planned_derived(self.plan)]
        shown_in = {probe.signal: probe.unit for probe in self.plan.graph.root.probes}
        return {
            "entry": ENTRY,
            "module": packed(self.module.code),
            "own": self.module.constants,
            "image": packed(bytes(image)),
            "imageLength": len(image),
            "arrays": places,  # constants, state, scratch, vectors
            "rate": [rate.numerator, rate.denominator],
            "probes": [self._probe(probe, shown_in[probe.signal]) for probe in self.plan.probes],
            "measures": [*map(self._measure, self.plan.measures), *formulas],
            "formulas": _formulas(self.plan),
            "parameters": {".".join(node): self._place(node) for node in self.varied},
            "wires": list(self._wires()),
            "watched": finite_places(self.plan, self.written),
            "refused": self.written.memory.counts[INTEGERS],
        }

    def _arrays(self) -> list[AnyArray]:
        """Everything that the program reads and writes but rows, at tick 0."""
        written, memory = self.written, start(self.plan)
        values = {key: moving(memory, key) for key in written.memory.kinds}
        vectors = [
            np.array(memory.vector(node), dtype=dtype_of(kind))
            for node, kind in zip(written.vectors, written.vector_kinds, strict=True)
        ]
        scratch = np.zeros(written.scratch + 1)
        return [
            *arrays_of(written.constants, written.constant_values).values(),
            *arrays_of(written.memory, values).values(),
            scratch,
            *vectors,
        ]

    def _place(self, node: Endpoint) -> int:
        """The place of a parameter among the constants."""
        kinds = self.written.constants.kinds
        return (kinds.get(ParameterOf(*node)) or kinds[ConstantOf(*node)])[1]

    def _wires(self) -> Iterator[dict[str, Any]]:
        """The scalar outputs that the loop keeps, by names in the flat graph, and their places."""
        kinds = self.written.memory.kinds
        for name, block in self.plan.blocks.items():
            for port, declared in type(block).outputs.items():
                kind = kinds.get(WireOf(name, port))
                if kind is None or name.startswith(f"{MEASURES}."):
                    continue
                fixed = declared.dtype is FixedValue
                yield {
                    "name": f"{name}.{port}",
                    "unit": unit_of(block, declared),
                    "doc": declared.doc,
                    "integer": kind[0] is not float,
                    "held": holds(block, kind[0] is not float),
                    "place": kind[1],
                    "fraction": format_of(block, port).fraction if fixed else 0,
                }

    def _probe(self, probe: PlannedProbe, shown_in: str) -> dict[str, Any]:
        return {
            "signal": probe.signal,
            "unit": scale_key(probe.unit, shown_in),
            "doc": probe.doc,
            "stride": probe.stride,
            "phase": probe.phase,
            "type": _DTYPES[probe.dtype],
            "bytes": np.dtype(probe.dtype).itemsize,
            "held": holds(self.plan.blocks.get(probe.node[0]), probe.dtype is not float),
            "shape": list(probe.shape),
            "fraction": probe.format.fraction if probe.format else None,
        }

    def _measure(self, measure: PlannedMeasure) -> dict[str, Any]:
        kind, place = self.written.memory.kinds[WireOf(*measure.node)]
        return _described(measure) | {"read": {"first": measure.first, "integer": kind is not float, "place": place}}


def carried_loop(plan: Plan, varied: Collection[Endpoint]) -> CarriedLoop:
    """The loop with as many of the parameters varied as a browser can; raises `ModelError` where none runs it."""
    written = write_tick(plan, (), measured=True)
    called = sorted(external.symbol for external in externals(written.program).values())
    if called:
        message = f"the graph calls {', '.join(called)} of the C library, which browsers compute to other bits"
        hint = "use the functions of proofmass.blocks.arithmetic.elementary in your blocks"
        raise Problem(message=message, key="--live", hint=hint).error
    numbers = tuple(varied)
    written = write_tick(plan, numbers, measured=True)
    if externals(written.program):
        # the constants that follow from the others need functions that no browser has to the bit
        numbers = tuple(node for node in varied if not externals(write_tick(plan, [node], measured=True).program))
        written = write_tick(plan, numbers, measured=True)
    return CarriedLoop(plan, written, _module(written.program), numbers)


def _described(measure: PlannedMeasure) -> dict[str, Any]:
    return {
        "name": measure.name,
        "signal": measure.signal,
        "statistic": measure.statistic,
        "unit": scale_key(measure.unit, measure.shown_in),
    }


def _formulas(plan: Plan) -> dict[str, Any] | None:
    """The module of the measures given by formulas, functions such as sines included."""
    if not plan.derived:
        return None
    module = _module(measure_formulas(plan))
    return {"module": packed(module.code), "own": module.constants}


def _module(program: Program) -> WasmModule:
    """The module of a program; those of the last few are kept, since most changes of a graph are of numbers."""
    key = content_of(program)
    if key not in _modules:
        while len(_modules) >= _MOST_MODULES:
            del _modules[next(iter(_modules))]
        _modules[key] = wasm_module(program)
    return _modules[key]


def scale_key(unit: str, shown_in: str) -> str:
    """Return the name of a table of scales: the unit, and in which other one values are shown."""
    return f"{unit}{SHOWN_IN}{shown_in}" if shown_in else unit


def packed(data: bytes) -> str:
    """Return bytes as text: gzipped and in base 64."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()
