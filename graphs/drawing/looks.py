"""Looks of blocks: summing circles, gain triangles, boxes with their ports, and open subgraphs."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from proofmass.graphs.drawing.items import Shape
from proofmass.graphs.drawing.links import WiredPorts
from proofmass.graphs.drawing.picture import Box
from proofmass.graphs.drawing.texts import unit_in_print, width_of

HEAD, LINE, ROW = 40, 20, 20  # of a block: name and kind, a setting, one port
NAME = 20  # above a symbol
SYMBOL = 40  # width of one
PAD = 20  # around what is inside an opened subgraph
FAN = 30  # beside a block, where wires part from a bundle
FLAG_ROOM = 22  # of the flag of a probe, which reaches up beside the port above
ARROW, BELOW_TAB = 20, 11  # from a tab to the input, or to the driven parameter above it
_CURVE = 2.7  # from the edge of a circle to where a wire 10 above its middle meets it
_MOST_SETTINGS = 2
_SIGNS = {  # of circles, by input
    "Sum": {"first": "+", "second": "+", "third": "+", "fourth": "+"},
    "Difference": {"first": "+", "second": "\N{MINUS SIGN}"},
    "Product": {"first": "×", "second": "×"},
    "Quotient": {"numerator": "×", "denominator": "÷"},
}
_TRIANGLES = {"Gain": "", "Negation": "\N{MINUS SIGN}1"}  # with the text inside
_SILENT = ("input", "output")  # names that need not be written where the port is alone on its side


@dataclass(frozen=True)
class Look:
    """Look of a block: shape for the layout, symbol, lines of text, and the pins' depth."""

    shape: Shape
    symbol: str  # "box", "circle", "triangle", "tab", "open"
    settings: tuple[str, ...] = ()
    labels: frozenset[str] = frozenset()  # ports whose names are written
    signs: Mapping[str, str] = field(default_factory=dict)
    rate: str = ""
    insets: Mapping[str, float] = field(default_factory=dict)  # by port
    tabs: Mapping[str, tuple[int, int]] = field(default_factory=dict)  # how far from the block, and how wide, by port


class _Drawn(NamedTuple):
    """A block as its look wants it: the ports that have pins, and what stands beside and inside."""

    name: str
    box: Box
    needed: list[str]  # inputs
    driven: list[str]  # parameters
    rate: str
    into: Mapping[str, str]
    inner: tuple[int, int] | None  # size of what an opened subgraph shows
    room: "_Room"
    tabs: Mapping[str, tuple[int, int]]


class _Room(NamedTuple):
    """Room around a block, and what its layout depends on beside its size and its pins."""

    label: int
    exit: bool
    noise: bool
    entry: int
    tabbed: frozenset[str]


def look_of(name: str, box: Box, wired: WiredPorts, rate: str, inner: tuple[int, int] | None) -> Look:
    """Return the look of a block; `inner` is the size of what an opened subgraph shows."""
    into = wired.into[name]
    needed = [port for port, declared in box.inputs.items() if declared.default is None or port in into]
    driven = sorted(port for port in into if port not in box.inputs)
    tabs = _tabs(name, box, wired)
    leaving, entering = (FAN if name in fans else 0 for fans in (wired.leaves, wired.enters))
    labels = (sum(tabs[port]) + 4 if port in tabs else _label(name, box, wired, port) for port in wired.used[name])
    entries = (sum(tabs[port]) + 4 for port in tabs if port in box.inputs)
    room = _Room(
        max(labels, default=0) + leaving,
        bool(wired.probed[name]),
        box.noise,
        max(entries, default=entering),
        frozenset(tabs).intersection(driven),
    )
    if not box.kind:
        return replace(_tab(name, box, room), tabs=tabs)
    return replace(_look(_Drawn(name, box, needed, driven, rate, into, inner, room, tabs)), tabs=tabs)


def _label(name: str, box: Box, wired: WiredPorts, port: str) -> int:
    """Return the room for the unit of an output and its flag."""
    return width_of(unit_in_print(box.outputs[port]), 10) + 4 + 14 * (port in wired.probed[name])


def _tabs(name: str, box: Box, wired: WiredPorts) -> dict[str, tuple[int, int]]:
    """Return how far the tabs of named wires are from a block, and how wide."""
    tabs: dict[str, tuple[int, int]] = {}
    for port, label in wired.tabs[name].items():
        before = BELOW_TAB
        if port in box.outputs:
            before = max(_label(name, box, wired, port) + 4, FLAG_ROOM * bool(wired.probed[name]))
        elif port in box.inputs:
            before = FAN if name in wired.enters else ARROW
        tabs[port] = before, _tens(width_of(label, 10) + 16)
    return tabs


def _look(of: _Drawn) -> Look:
    if of.inner is None and not of.driven and len(of.box.outputs) == 1 and not of.box.subgraph:
        kind = of.box.kind.removeprefix("Fixed")
        if kind in _TRIANGLES and len(of.needed) == 1:
            return _triangle(of, kind)
        if kind in _SIGNS and len(of.needed) > 1 and set(of.needed) <= set(_SIGNS[kind]):
            return _circle(of, kind)
    return _boxed(of) if of.inner is None else _opened(of, of.inner)


def _tab(name: str, box: Box, room: _Room) -> Look:
    """Return the look of a port of an opened subgraph, as seen from inside."""
    width = _tens(width_of(name, 11) + 24)
    inputs, outputs = (dict.fromkeys(ports, 10) for ports in (box.inputs, box.outputs))
    return Look(Shape(width, 20, inputs, outputs, {}, *room), "tab")


def _triangle(of: _Drawn, kind: str) -> Look:
    inside = _TRIANGLES[kind]
    value = "" if inside else next(iter(of.box.settings(())), "") or of.box.shown("gain")
    return _symbol(of, "triangle", SYMBOL, value, {of.needed[0]: inside})


def _circle(of: _Drawn, kind: str) -> Look:
    signs = {port: sign for port, sign in _SIGNS[kind].items() if port in of.needed}
    return _symbol(of, "circle", ROW * len(of.needed), "", signs)


def _symbol(of: _Drawn, symbol: str, height: int, value: str, signs: Mapping[str, str]) -> Look:
    """Return a symbol with its name above it, a value and a rate below it."""
    settings = tuple(filter(None, (value, of.rate)))
    words = max(width_of(of.name, 13, bold=True), *(width_of(text, 11) for text in settings), SYMBOL)
    width, last = -(-words // 20) * 20, len(of.needed) - 1
    inputs = {port: NAME + (10 + ROW * i if last else height // 2) for i, port in enumerate(of.needed)}
    (output,) = of.box.outputs
    ends = {port: _CURVE if symbol == "circle" and i in (0, last) else 0.0 for i, port in enumerate(of.needed)}
    insets = {port: (width - SYMBOL) / 2 + end for port, end in {**ends, output: 0.0}.items()}
    shape = Shape(width, NAME + height + LINE * len(settings), inputs, {output: NAME + height // 2}, {}, *of.room)
    return Look(shape, symbol, settings, frozenset(), signs, of.rate, insets)


def _boxed(of: _Drawn) -> Look:
    settings = tuple(of.box.settings(of.into))[:_MOST_SETTINGS]
    sides = [of.needed, list(of.box.outputs)]
    silent = [len(ports) < 2 and set(ports) <= set(_SILENT) for ports in sides]
    labels = frozenset(port for ports, quiet in zip(sides, silent, strict=True) for port in ports if not quiet)
    head = HEAD + LINE * len(settings)
    foot = 10 if of.driven else 0
    if all(silent):
        height = head + (LINE if of.driven else 0)
        inputs, outputs = (dict.fromkeys(ports, height // 20 * 10) for ports in sides)
    else:
        inputs, outputs = ({port: head + 10 + ROW * i for i, port in enumerate(ports)} for ports in sides)
        height = head + ROW * max(*map(len, sides), 1) + 10 + foot
    across, places = _along(of.driven, of.tabs)
    widths = (max((width_of(port, 11) for port in ports if port in labels), default=0) for ports in sides)
    words = max(_heading(of), *(width_of(text, 11) for text in settings), 0)
    width = max(words + 20, sum(widths) + 34, across + 10, 60)
    shape = Shape(_tens(width), height, inputs, outputs, places, *of.room)
    return Look(shape, "box", settings, labels, {}, of.rate)


def _opened(of: _Drawn, inner: tuple[int, int]) -> Look:
    """Return a subgraph opened up: its ports at the edges, what is inside between them."""
    inputs, outputs = (
        {port: HEAD + 10 + ROW * i for i, port in enumerate(ports)} for ports in (of.needed, of.box.outputs)
    )
    across, places = _along(of.driven, of.tabs)
    sides = [max((width_of(port, 11) for port in ports), default=0) for ports in (inputs, outputs)]
    width = max(inner[0] + sum(sides) + 2 * PAD + 40, _heading(of) + 40, across + 10)
    height = HEAD + max(inner[1] + 2 * PAD, ROW * max(len(inputs), len(outputs))) + (ROW if of.driven else 0)
    shape = Shape(_tens(width), _tens(height), inputs, outputs, places, *of.room)
    return Look(shape, "open", (), frozenset({*inputs, *outputs}), {}, of.rate)


def _heading(of: _Drawn) -> int:
    """Return the width of the name, and of kind and rate below it."""
    return max(width_of(of.name, 13, bold=True), width_of(kind_text(of.box) + "  " * bool(of.rate) + of.rate, 11))


def inner_place(look: Look, mirrored: bool) -> tuple[int, int]:
    """Return where the inside of an opened subgraph begins, from its corner."""
    ports = look.shape.outputs if mirrored else look.shape.inputs
    return _tens(max((width_of(port, 11) for port in ports), default=0) + PAD + 10), HEAD + PAD


def kind_text(box: Box) -> str:
    """Return the line below the name: the kind of a block, the file of a subgraph."""
    return box.file or "subgraph" if box.subgraph else box.kind


def _along(driven: list[str], tabs: Mapping[str, tuple[int, int]]) -> tuple[int, dict[str, int]]:
    """Return the places of driven parameters along the bottom, and how far they reach."""
    places: dict[str, int] = {}
    across = 0
    for parameter in driven:
        half = -(-max(width_of(parameter, 11, bold=True), tabs.get(parameter, (0, 0))[1]) // 20) * 10
        places[parameter] = across + half + 10
        across += 2 * half + 10
    return across, places


def _tens(number: int) -> int:
    return -(-number // 10) * 10
