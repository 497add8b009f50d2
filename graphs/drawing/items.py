"""Parts of a layout that move: shapes, items of a layer, and the wires between two layers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.routing import GRID, GridPoint

NetName = tuple[str, str]  # of the wires of one output: block and port
TAB_ROWS = 3  # of the grid, below a block whose driven parameters have tabs


@dataclass(frozen=True)
class Shape:
    """Size of a block and places of its pins: ports from the top, parameters from the left."""

    width: int
    height: int
    inputs: Mapping[str, int]
    outputs: Mapping[str, int]
    driven: Mapping[str, int]
    label: int  # room beside the outputs
    exit: bool  # whether a probe or an export reads an output
    noise: bool
    entry: int  # room beside the inputs
    tabbed: frozenset[str]  # driven parameters with a tab instead of a wire

    def row(self, parameter: str) -> int:
        """Return how far below the top of the block the wire of a driven parameter arrives."""
        wired = [name for name in self.driven if name not in self.tabbed]
        return self.height + GRID * (2 + TAB_ROWS * bool(self.tabbed) + wired.index(parameter))

    def reserved(self) -> int:
        """The height reserved for it."""
        wired = [name for name in self.driven if name not in self.tabbed]
        tabs = GRID * TAB_ROWS * bool(self.tabbed)
        return self.row(wired[-1]) if wired else self.height + tabs


class Spot(NamedTuple):
    """The upper left corner of a block, and whether its inputs are on the right."""

    x: int
    y: int
    mirrored: bool


@dataclass(frozen=True)
class Layout:
    """A diagram in pixels: blocks, the corner points of each wire, and dots where wires branch."""

    width: int
    height: int
    spots: Mapping[str, Spot]
    paths: Mapping[Link, tuple[GridPoint, ...]]
    dots: frozenset[GridPoint]


@dataclass(eq=False)
class Item:
    """An item of a layer: a block, or a wire that passes through."""

    name: str  # empty for a wire
    height: int
    rank: tuple[int, str, str]  # order at the start
    backward: bool
    width: int = 0
    x: int = 0
    top: int = 0
    pins: tuple[list["Pin"], list["Pin"]] = field(default_factory=lambda: ([], []))  # on the left, on the right


class Pin(NamedTuple):
    """A place where a wire meets an item."""

    item: Item
    below: int  # the top of the item
    across: int  # from the left of the item
    net: "Net"

    @property
    def y(self) -> int:
        """Height in the layout."""
        return self.item.top + self.below


@dataclass(eq=False)
class Net:
    """The wires of one output in one gap between layers: pins on the left and the right."""

    left: list[Pin] = field(default_factory=list)
    right: list[Pin] = field(default_factory=list)
