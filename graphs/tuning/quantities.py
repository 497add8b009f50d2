"""Quantities of a graph that a goal or a tolerance analysis asks for: of a loop, of noise, of a transfer, a measure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.blocks.declaration.units import convert, short_unit
from proofmass.graphs.model.flatten import FlatGraph, inside
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.names import Missing, find_output
from proofmass.graphs.model.statistics import STATISTICS

FIGURES = {  # of a loop, with their units
    "gain_margin": "dB",
    "phase_margin": "deg",
    "delay_margin": "s",
    "disk_margin": "1",
    "sensitivity_peak": "dB",
    "bandwidth": "Hz",
    "overshoot": "%",
    "settling_time": "s",
}
PARTS = ("scale_factor", "bias")
QUANTITY_KEYS = {
    "loop": "Name of a loop, or the output at which it is opened; `figure` says what of it.",
    "figure": f"Figure of the loop: {', '.join(FIGURES)}.",
    "noise": "Output of which the rms noise counts.",
    "scale_factor": "Output of which the scale factor from `input` counts.",
    "bias": "Output of which the value at zero `input` counts.",
    "input": "Output of a source: noise is referred to it, a scale factor starts from it.",
    "band": 'Band of the noise: ["1 Hz", "100 Hz"]; all frequencies when nothing is said.',
    "measure": "Name of a measure of the graph, which a run gives.",
}
_CHOICES = ("loop", "noise", *PARTS, "measure")


@dataclass(frozen=True)
class LoopFigure:
    """A figure of a loop."""

    loop: str
    figure: str
    unit: str

    def __str__(self) -> str:
        return f"{self.figure.replace('_', ' ')} of {self.loop}"


@dataclass(frozen=True)
class Noise:
    """The rms noise of an output in a band, referred to an input if there is one."""

    output: str
    input: str
    band: tuple[float, float] | None
    unit: str

    def __str__(self) -> str:
        of = f"noise of {self.output}" + (f" at {self.input}" if self.input else "")
        return of + (f", {self.band[0]:g} Hz to {self.band[1]:g} Hz" if self.band else "")


@dataclass(frozen=True)
class TransferPart:
    """Scale factor or bias of the settled graph from an input to an output."""

    part: str
    output: str
    input: str
    unit: str

    def __str__(self) -> str:
        return f"{self.part.replace('_', ' ')} from {self.input} to {self.output}"


@dataclass(frozen=True)
class MeasureOf:
    """A measure of a run."""

    measure: str
    unit: str

    def __str__(self) -> str:
        return f"measure {self.measure}"


Quantity = LoopFigure | Noise | TransferPart | MeasureOf


def read_quantity_of(table: Mapping[str, Any], flat: FlatGraph) -> Quantity:
    """Return the quantity that the keys of a table name; raises `Refusal`."""
    kinds = [key for key in _CHOICES if key in table]
    if len(kinds) != 1:
        expected = f"one of {', '.join(_CHOICES)}"
        hint = 'write { loop = "main", figure = "phase_margin", at_least = "60 deg" }'
        raise Refusal("must name one quantity", hint, got=shown(dict(table)), expected=expected)
    (kind,) = kinds
    suited = {"loop": {"figure"}, "noise": {"input", "band"}, "measure": set[str]()}.get(kind, {"input"})
    for key in table:
        if key in QUANTITY_KEYS and key != kind and key not in suited:
            raise Refusal(f"{kind} has no {key}", "leave it out", key=key, got=shown(table[key]))
    if kind == "loop":
        return _loop_figure(table, flat)
    if kind == "measure":
        return _measure(table, flat)
    output, unit = _output(table, kind, flat)
    if kind == "noise":
        source, referred = _output(table, "input", flat) if "input" in table else ("", unit)
        return Noise(output, source, _band(table), referred)
    if "input" not in table:
        raise Refusal(f"{kind} needs an input", 'add input = "acceleration.output"', got=shown(dict(table)))
    source, from_unit = _output(table, "input", flat)
    return TransferPart(kind, output, source, short_unit(f"({unit})/({from_unit})") if kind == PARTS[0] else unit)


def _loop_figure(table: Mapping[str, Any], flat: FlatGraph) -> LoopFigure:
    loop, figure = table["loop"], table.get("figure")
    if figure not in FIGURES:
        hint = did_you_mean(str(figure), FIGURES, "the figures of a loop")
        raise Refusal("there is no such figure", hint, key="figure", got=shown(figure))
    if not isinstance(loop, str) or (loop not in flat.loops and "." not in loop):
        hint = did_you_mean(str(loop), flat.loops, "the loops") if flat.loops else 'name an output: "dac.voltage"'
        raise Refusal("there is no such loop", hint, key="loop", got=shown(loop))
    if loop not in flat.loops:
        _output(table, "loop", flat)
    return LoopFigure(loop, figure, FIGURES[figure])


def _measure(table: Mapping[str, Any], flat: FlatGraph) -> MeasureOf:
    name = table["measure"]
    if name not in flat.measures:
        hint = did_you_mean(str(name), flat.measures, "the measures") if flat.measures else "add it to [measures]"
        raise Refusal("there is no such measure", hint, key="measure", got=shown(name))
    measure = flat.measures[name]
    block, port = split(measure.signal)
    unit = unit_of(flat.blocks[block], type(flat.blocks[block]).outputs[port])
    return MeasureOf(name, STATISTICS[measure.statistic].unit_for(unit))


def _output(table: Mapping[str, Any], key: str, flat: FlatGraph) -> tuple[str, str]:
    """Name and unit of an output."""
    signal = table[key]
    if not isinstance(signal, str):
        raise Refusal("not an output", 'write "block.output"', key=key, got=shown(signal))
    name = inside(flat.root, signal)
    output = find_output(flat, name)
    if isinstance(output, Missing):
        raise Refusal(output.message, output.hint, key=key, got=shown(signal))
    assert not isinstance(output[1], Parameter)
    return signal, short_unit(unit_of(*output))


def _band(table: Mapping[str, Any]) -> tuple[float, float] | None:
    band = table.get("band")
    if band is None:
        return None
    hint = 'write band = ["1 Hz", "100 Hz"]'
    if not isinstance(band, list | tuple) or len(band) != 2:
        raise Refusal("must be two frequencies", hint, key="band", got=shown(band))
    try:
        low, high = (convert(end, "Hz") if isinstance(end, str) else float(end) for end in band)
    except Refusal as error:
        raise error.under("band", band, "two frequencies") from None
    except (TypeError, ValueError):
        raise Refusal("must be two frequencies", hint, key="band", got=shown(band)) from None
    if not (0.0 <= low < high < math.inf):
        raise Refusal("the band is empty", hint, key="band", got=shown(band))
    return low, high
