"""Quantities of a graph that goals, requirements and worst cases name: of loops, noise, responses, measures, yields."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.blocks.declaration.units import convert, short_unit
from proofmass.graphs.model.call_numbers import real
from proofmass.graphs.model.derived import measure_units
from proofmass.graphs.model.flatten import FlatGraph, inside
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.names import Missing, find_output, output_of_a_loop

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
RESPONSE_FIGURES = {  # of a response, with units; empty: that of the gain
    "gain": "",
    "phase": "deg",
    "peak": "",
    "bandwidth": "Hz",
    "delay": "s",
    "rise_time": "s",
    "settling_time": "s",
    "overshoot": "%",
}
AT_FREQUENCY = ("gain", "phase")  # figures of a response that need a frequency
PARTS = ("scale_factor", "bias")
QUANTITY_KEYS = {
    "loop": "Name of a loop, or the output at which it is opened; `figure` says what of it.",
    "figure": f"Figure of the loop: {', '.join(FIGURES)}; or of the response: {', '.join(RESPONSE_FIGURES)}.",
    "noise": "Output of which the rms noise counts.",
    "scale_factor": "Output of which the scale factor from `input` counts.",
    "bias": "Output of which the value at zero `input` counts.",
    "response": "Output of which the response from `input` counts; `figure` says what of it, the gain unless said.",
    "input": "Output of a source: noise is referred to it, a scale factor or a response starts from it.",
    "band": 'Band of the noise: ["1 Hz", "100 Hz"]; all frequencies when nothing is said.',
    "frequency": 'Frequency of the gain or phase of a response: "100 Hz".',
    "measure": "Name of a measure of the graph, which a run gives; it may be a formula of others.",
    "yield": "true: the part of the study's sensors that keep all limits; or a limit of it, by its name.",
}
QUANTITIES = ("loop", "noise", "response", *PARTS, "measure", "yield")


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
class ResponseFigure:
    """A figure of the linear response from one output to another; gain and phase at a frequency."""

    figure: str
    output: str
    input: str
    frequency: float | None
    unit: str

    def __str__(self) -> str:
        of = f"{self.figure.replace('_', ' ')} from {self.input} to {self.output}"
        return of if self.frequency is None else f"{of} at {self.frequency:g} Hz"


@dataclass(frozen=True)
class MeasureOf:
    """A measure of a run."""

    measure: str
    unit: str

    def __str__(self) -> str:
        return f"measure {self.measure}"


@dataclass(frozen=True)
class YieldOf:
    """The part of the study's sensors that keep one of its limits, or all if none is named."""

    limit: str
    unit: str = "1"

    def __str__(self) -> str:
        return f"yield of {self.limit}" if self.limit else "yield"


Quantity = LoopFigure | Noise | TransferPart | ResponseFigure | MeasureOf | YieldOf


_SUITED = {
    "loop": {"figure"},
    "noise": {"input", "band"},
    "response": {"input", "figure", "frequency"},
    "measure": set[str](),
    "yield": set[str](),
}


def quantity_table(quantity: Quantity) -> dict[str, Any]:
    """Return the table that names a quantity, as goals and requirements have it."""
    if isinstance(quantity, LoopFigure):
        return {"loop": quantity.loop, "figure": quantity.figure}
    if isinstance(quantity, MeasureOf):
        return {"measure": quantity.measure}
    if isinstance(quantity, YieldOf):
        return {"yield": quantity.limit or True}
    if isinstance(quantity, TransferPart):
        return {quantity.part: quantity.output, "input": quantity.input}
    if isinstance(quantity, Noise):
        more: dict[str, Any] = {"input": quantity.input} if quantity.input else {}
        return {"noise": quantity.output, **more} | ({"band": list(quantity.band)} if quantity.band else {})
    table = {"response": quantity.output, "input": quantity.input, "figure": quantity.figure}
    return table | ({} if quantity.frequency is None else {"frequency": quantity.frequency})


def checked_quantity(table: Mapping[str, Any], flat: FlatGraph) -> Quantity:
    """Return the quantity of a table that names nothing else; raises `Refusal`."""
    for key in table:
        if key not in QUANTITY_KEYS:
            hint = key_hint(str(key), QUANTITY_KEYS, table)
            raise Refusal("unknown key", hint, key=str(key), got=shown(key))
    return read_quantity_of(table, flat)


def read_quantity_of(table: Mapping[str, Any], flat: FlatGraph) -> Quantity:
    """Return the quantity that the keys of a table name; raises `Refusal`."""
    kinds = [key for key in QUANTITIES if key in table]
    if len(kinds) != 1:
        expected = f"one of {', '.join(QUANTITIES)}"
        hint = 'write { loop = "main", figure = "phase_margin", at_least = "60 deg" }'
        raise Refusal("must name one quantity", hint, got=shown(dict(table)), expected=expected)
    (kind,) = kinds
    suited = _SUITED.get(kind, {"input"})
    for key in table:
        if key in QUANTITY_KEYS and key != kind and key not in suited:
            raise Refusal(f"{kind} has no {key}", "leave it out", key=key, got=shown(table[key]))
    if kind == "loop":
        return _loop_figure(table, flat)
    if kind == "measure":
        return _measure(table, flat)
    if kind == "yield":
        return _yield(table["yield"])
    output, unit = _output(table, kind, flat)
    if kind == "noise":
        source, referred = _output(table, "input", flat) if "input" in table else ("", unit)
        return Noise(output, source, _band(table), referred)
    if "input" not in table:
        raise Refusal(f"{kind} needs an input", 'add input = "acceleration.output"', got=shown(dict(table)))
    source, from_unit = _output(table, "input", flat)
    if kind == "response":
        return _response(table, output, source, short_unit(f"({unit})/({from_unit})"))
    return TransferPart(kind, output, source, short_unit(f"({unit})/({from_unit})") if kind == PARTS[0] else unit)


def _loop_figure(table: Mapping[str, Any], flat: FlatGraph) -> LoopFigure:
    loop, figure = table["loop"], table.get("figure")
    if not isinstance(figure, str) or figure not in FIGURES:
        hint = did_you_mean(str(figure), FIGURES, "the figures of a loop")
        raise Refusal("there is no such figure", hint, key="figure", got=shown(figure))
    if not isinstance(loop, str) or (loop not in flat.loops and "." not in loop):
        hint = f'name an output: "{output_of_a_loop(flat)}"'
        hint = did_you_mean(str(loop), flat.loops, "the loops") if flat.loops else hint
        raise Refusal("there is no such loop", hint, key="loop", got=shown(loop))
    if loop not in flat.loops:
        _output(table, "loop", flat)
    return LoopFigure(loop, figure, FIGURES[figure])


def _measure(table: Mapping[str, Any], flat: FlatGraph) -> MeasureOf:
    name, units = table["measure"], measure_units(flat)
    if not isinstance(name, str) or name not in units:
        hint = did_you_mean(str(name), units, "the measures") if units else "add it to [measures]"
        raise Refusal("there is no such measure", hint, key="measure", got=shown(name))
    return MeasureOf(name, units[name])


def _yield(limit: object) -> YieldOf:
    """Return the yield of a limit; the study that has it is looked at where it is run."""
    if limit is not True and not (isinstance(limit, str) and limit):
        hint = "write yield = true for all limits of [study], or the name of one"
        raise Refusal("is not a limit", hint, key="yield", got=shown(limit))
    return YieldOf("" if limit is True else limit)


def _response(table: Mapping[str, Any], output: str, source: str, ratio: str) -> ResponseFigure:
    figure, frequency = table.get("figure", "gain"), table.get("frequency")
    if not isinstance(figure, str) or figure not in RESPONSE_FIGURES:
        hint = did_you_mean(str(figure), RESPONSE_FIGURES, "the figures of a response")
        raise Refusal("there is no such figure", hint, key="figure", got=shown(figure))
    if figure not in AT_FREQUENCY:
        if frequency is not None:
            raise Refusal(f"{figure} has no frequency", "leave it out", key="frequency", got=shown(frequency))
        return ResponseFigure(figure, output, source, None, RESPONSE_FIGURES[figure] or ratio)
    hint = f'the {figure} needs one: add frequency = "100 Hz"'
    (hertz,) = _hertz([frequency], "frequency", frequency, "a frequency", hint)
    if isinstance(frequency, bool) or not 0.0 <= hertz < math.inf:
        raise Refusal("must be a frequency", hint, key="frequency", got=shown(frequency))
    return ResponseFigure(figure, output, source, hertz, RESPONSE_FIGURES[figure] or ratio)


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
    low, high = _hertz(band, "band", band, "two frequencies", hint)
    if not (0.0 <= low < high < math.inf):
        raise Refusal("the band is empty", hint, key="band", got=shown(band))
    return low, high


def _hertz(entries: Sequence[Any], key: str, whole: object, wanted: str, hint: str) -> list[float]:
    """Return frequencies of texts and numbers, `whole` as written at a key; raises `Refusal`."""
    try:
        return [convert(entry, "Hz") if isinstance(entry, str) else real(entry) for entry in entries]
    except Refusal as error:
        raise error.under(key, whole, wanted) from None
    except TypeError:
        raise Refusal(f"must be {wanted}", hint, key=key, got=shown(whole)) from None
