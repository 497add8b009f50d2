"""The blocks that become hardware, each alone: with defaults, with other formats, as graphs of the library set them."""

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

from proofmass.blocks import (
    FixedCordicExponentialPipeline,
    FixedCorrelationCell,
    FixedMassSpringDamper,
    FixedPID,
    FixedStiffnessController,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import FOLDER
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.rtl.machine.compose import fits_hardware

RATE = Fraction(4800)  # of blocks that no graph gives one
SOFTWARE = {"Correlator"}  # its sums are plain integers, of which no format says how large they grow
WORDS = ("large_format", "damping_format", "small_format", "step_format")
OTHERS: tuple[Block, ...] = (
    FixedCordicExponentialPipeline(fraction_bits=8, iterations=6),
    FixedCorrelationCell(lag=3, order=3),
    FixedMassSpringDamper(method="forward_euler", overflow="wrap"),
    FixedMassSpringDamper(method="leapfrog"),
    FixedMassSpringDamper(**dict.fromkeys(WORDS, Fixed(32, 24))),
    FixedPID(rounding="floor", overflow="wrap"),
    FixedStiffnessController(rounding="toward_zero", overflow="wrap"),
)


class Alone(NamedTuple):
    """A block by itself: `where` is the graph and the path that it comes from, or empty."""

    block: Block
    rate: Fraction
    where: str = ""

    @property
    def kind(self) -> str:
        """The name of its class."""
        return type(self.block).__name__

    @property
    def name(self) -> str:
        """What it is called in the table, and may be on the command line."""
        return self.where or repr(self.block).removesuffix("()")


def blocks_alone() -> Iterator[Alone]:
    """Every one once: at another rate it is the same where its constants are."""
    seen = set()
    for alone in _found():
        if fits_hardware(alone.block) and alone.kind not in SOFTWARE:
            constants = type(alone.block).functions.get("constants")
            key = alone.block, constants and str(constants.function(alone.block, float(1 / alone.rate)))
            if key not in seen:
                yield alone
            seen.add(key)


def _found() -> Iterator[Alone]:
    yield from (Alone(kind(), RATE) for _, kind in sorted(all_blocks().items()))
    yield from (Alone(block, RATE) for block in OTHERS)
    for path in sorted(FOLDER.rglob("*.toml")):
        if "[blocks" not in path.read_text(encoding="utf-8"):
            continue  # a study that names its graph
        graph = flatten(read_graph(path))
        for name, block in graph.blocks.items():
            yield Alone(block, graph.rates.get(name, graph.rate) or RATE, f"{path.stem}.{name}")
