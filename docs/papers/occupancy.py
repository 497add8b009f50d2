"""Occupation of the Virtex-II Pro family by the self-calibration, as Sarraf et al. 2012 count it in tables 3 and 4.

    python -m docs.papers.occupancy

A slice has two four-input lookup tables and two flip-flops. Slices, and 18 by 18 multipliers, of each device are those
of its data sheet (Xilinx DS083, table 1). Ours are what Yosys makes of the graphs in registers; no open tool packs
slices for this family, so slices are a bound: all of them full. The paper's are 1.10 and 1.13 times that of its own
counts.
"""

import functools
from collections.abc import Iterator
from fractions import Fraction
from importlib.resources import as_file
from typing import NamedTuple

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from proofmass.runner.rtl.tools.synth import Resources, synthesized

DEVICES = {  # slices, multipliers
    "XC2VP2": (1408, 12),
    "XC2VP7": (4928, 44),
    "XC2VP30": (13696, 136),
    "XC2VP70": (33088, 328),
    "XC2VP100": (44096, 444),
}


class Cells(NamedTuple):
    """What a design takes."""

    slices: int
    flip_flops: int
    luts: int
    multipliers: int


GENERATOR = Cells(12, 11, 1, 0)  # [P], in both tables
PAPER = {"accelerometer": Cells(3547, 1857, 6461, 21), "gyroscope": Cells(4686, 3646, 8275, 35)}  # [P]
# [P]: slices, flip-flops, lookup tables, multipliers; None is N/A
PERCENT: dict[str, dict[str, tuple[float | None, ...]]] = {
    "accelerometer": {
        "XC2VP2": (None, 65.94, None, None),
        "XC2VP7": (71.97, 18.84, 65.55, 47.72),
        "XC2VP30": (25.89, 6.77, 23.58, 15.44),
        "XC2VP70": (10.71, 2.80, 9.76, 6.40),
        "XC2VP100": (8.04, 2.10, 7.32, 4.72),
    },
    "gyroscope": {
        "XC2VP2": (None, None, None, None),
        "XC2VP7": (95.08, 36.9, 83.95, 79.54),
        "XC2VP30": (34.21, 13.31, 30.2, 25.73),
        "XC2VP70": (14.16, 5.5, 12.5, 10.67),
        "XC2VP100": (10.62, 4.13, 9.38, 7.88),
    },
}
GRAPHS = {"accelerometer": "self_calibration_fixed", "gyroscope": "self_calibration_gyroscope_fixed"}


def occupied(cells: Cells, device: str) -> tuple[Fraction, ...]:
    """Percentages of a device: slices, flip-flops, lookup tables, multipliers."""
    slices, multipliers = DEVICES[device]
    there = Cells(slices, 2 * slices, 2 * slices, multipliers)
    return tuple(Fraction(100 * used, all_) for used, all_ in zip(cells, there, strict=True))


def agreements() -> tuple[int, int, int]:
    """Percentages that follow from the paper's counts to the last place, all of them, and what fits but is N/A."""
    follow = printed = fit = 0
    for design, rows in PERCENT.items():
        for device, row in rows.items():
            for theirs, exact in zip(row, occupied(PAPER[design], device), strict=True):
                if theirs is None:
                    fit += exact <= 100
                    continue
                printed += 1
                digits = len(str(theirs).partition(".")[2])
                follow += abs(Fraction(str(theirs)) - exact) < Fraction(1, 10**digits)
    return follow, printed, fit


def three_axes(accelerometer: Cells, gyroscope: Cells, generator: Cells) -> Cells:
    """Two accelerometers and a gyroscope with one generator."""
    return Cells(*(2 * a + g - 2 * s for a, g, s in zip(accelerometer, gyroscope, generator, strict=True)))


@functools.cache
def synthesis(design: str, blocks: tuple[str, ...] = ()) -> Resources:
    """Resources of a graph in registers, or of some of its blocks."""
    with as_file(library_file(f"{GRAPHS[design]}.toml")) as path:
        machine = compose(plan(read_graph(path), wide=True), blocks, "hardware")
    return synthesized(machine_text(machine), top_name(machine), "xc2vp")


def ours(design: str, blocks: tuple[str, ...] = ()) -> Cells:
    """Cells of ours, with the least number of slices."""
    found = synthesis(design, blocks)
    return Cells(found.slices_bound, found.flip_flops, found.luts, found.multipliers)


def our_three_axes() -> Cells:
    """Ours, of all three axes."""
    return three_axes(ours("accelerometer"), ours("gyroscope"), ours("accelerometer", ("chips",)))


def rows() -> Iterator[tuple[str, ...]]:
    """The table: percentages of slices, flip-flops, lookup tables, multipliers, theirs and ours."""
    yield "Occupied, %: slices / FF / LUT / MULT", "paper", "ours, slices at least"
    for design, table in PERCENT.items():
        for device, row in table.items():
            theirs = " / ".join("N/A" if each is None else f"{each:g}" for each in row)
            mine = " / ".join(f"{float(each):.2f}" for each in occupied(ours(design), device))
            yield f"{design}, {device}", theirs, mine
    for device in ("XC2VP7", "XC2VP30"):
        sums = three_axes(PAPER["accelerometer"], PAPER["gyroscope"], GENERATOR), our_three_axes()
        theirs, mine = (" / ".join(f"{float(each):.2f}" for each in occupied(each, device)) for each in sums)
        yield f"three axes, {device}", theirs, mine


if __name__ == "__main__":
    for first, second, third in rows():
        print(f"{first:40}{second:34}{third}")
    for design in GRAPHS:
        print(f"{design}: {synthesis(design)}")
