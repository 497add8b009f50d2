"""Two exponentials beside a polynomial of fourth order, in registers: what they leave of the zero bias, what they take.

    python -m docs.papers.compensators

Liu, Li and Shen count three multipliers and one pipelined rotation algorithm, used twice, and say that this is smaller
and faster than a polynomial of fourth order. Words are as long in all of them, 24 fraction bits at the output. Counts
are those of Yosys for a Virtex-II Pro and an ECP5, the clock of the latter that of nextpnr, where it is installed.
"""

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from proofmass.blocks import Constant, Ramp
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.design.fit.data import read_table
from proofmass.runner.design.fit.fit import FitReport, fit
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from proofmass.runner.rtl.tools.synth import ChipFamily, Resources, synthesized
from proofmass.runner.run.simulate import simulate

ARITHMETIC = ("digital.first", "digital.second", "digital.model", "digital.difference")  # memory and converters outside


class Compensator(NamedTuple):
    """A part of the library in registers: its file, the term that it takes, its blocks without the memory."""

    file: str
    term: str = "exponential_term"
    blocks: tuple[str, ...] = ()
    ticks: int = 0  # from a temperature to its value

    @property
    def polynomial(self) -> bool:
        """Whether its coefficients are those of a polynomial."""
        return self.file.startswith("polynomial")


COMPENSATORS = {
    "exponentials": Compensator("temperature_compensator", "exponential_term", ARITHMETIC),
    "exponentials, factors preloaded": Compensator("temperature_compensator", "exponential_term_preloaded", ARITHMETIC),
    "exponentials, pipelined": Compensator("temperature_compensator", "exponential_term_pipelined", ARITHMETIC, 22),
    "polynomial": Compensator("polynomial_compensator"),
    "polynomial, pipelined": Compensator("polynomial_compensator_pipelined", ticks=8),
}


@functools.cache
def fitted(device: str) -> FitReport:
    """The fit of a device's readings: two exponentials, and polynomials of third and fourth order."""
    return fit(read_table(library_file(f"zero_bias_{device}.csv")))


def coefficients(device: str, polynomial: bool) -> dict[str, float]:
    """Fitted coefficients of a device by name."""
    return fitted(device).fits[3 if polynomial else 0].values


def part(compensator: Compensator) -> Graph:
    """The part of the library with its term."""
    path = library_file(f"{compensator.file}.toml")
    text = path.read_text(encoding="utf-8").replace("exponential_term.toml", f"{compensator.term}.toml")
    return read_graph_text(text, folder=str(path.parent))


def compensated(device: str, name: str) -> tuple[Any, Any, Any]:
    """The 61 temperatures, what the registers predict there, and what remains of the readings."""
    compensator, readings = COMPENSATORS[name], fitted(device).readings
    digital = part(compensator).with_parameters(coefficients(device, compensator.polynomial))
    steps, before = len(readings.temperature), compensator.ticks
    volts = Ramp(offset=0.6, slope=0.02, unit="V")  # 20 mV a tick
    graph = Graph(
        name="over the temperatures of the table",
        rate=1,
        blocks={"warming": volts, "nothing": Constant(value=0.0, unit="V"), "digital": digital},
        wires=["warming.output -> digital.temperature", "nothing.output -> digital.sensor"],
        probes=["digital.compensated"],
    )
    value = -simulate(graph, samples=steps + before, engine="compiled")["digital.compensated"].values[before:]
    return readings.temperature, value, readings.output - value


def fitted_function(device: str, polynomial: bool, temperature: Any) -> Any:
    """The fitted law in floating point."""
    values = coefficients(device, polynomial)
    if polynomial:
        return sum(values[f"c{power}"] * temperature**power for power in range(5))
    return sum(values[a] * np.exp(values[b] * temperature) for a, b in (("a1", "b1"), ("a2", "b2")))


@functools.cache
def resources(name: str, family: ChipFamily) -> Resources:
    """Cells of a compensator whose coefficients come from outside, and its clock."""
    compensator = COMPENSATORS[name]
    graph = Graph(
        name="compensator",
        rate=1000,
        samples=10,
        blocks={
            "temperature": Constant(value=1.0, unit="V"),
            "sensor": Constant(value=3e-3, unit="V"),
            "digital": part(compensator).with_parameters(coefficients("m1", compensator.polynomial)),
        },
        wires=["temperature.output -> digital.temperature", "sensor.output -> digital.sensor"],
        probes=["digital.compensated"],
    )
    machine = compose(plan(graph, wide=True), compensator.blocks, "hardware")
    return synthesized(machine_text(machine), top_name(machine), family)


def left() -> Iterator[tuple[str, ...]]:
    """What the readings leave, in floating point and in registers, and how far registers are from the function."""
    yield "Peak to peak, before and after", "M1, floating", "M1, registers", "M2, floating", "M2, registers", "off by"
    befores = [fitted(device).before for device in ("m1", "m2")]
    yield "before", *(cell for before in befores for cell in (f"{1e3 * before:.4f} mV", ""))
    for name, compensator in COMPENSATORS.items():
        if name == "exponentials, factors preloaded":
            continue
        cells, off = [], 0.0
        for device in ("m1", "m2"):
            temperature, value, rest = compensated(device, name)
            floating = fitted(device).fits[3 if compensator.polynomial else 0].after
            cells += [f"{1e3 * floating:.4f} mV", f"{1e3 * float(np.ptp(rest)):.4f} mV"]
            exact = fitted_function(device, compensator.polynomial, temperature)
            off = max(off, float(np.abs(value - exact).max()))
        yield name, *cells, f"{1e6 * off:.2f} uV"


def hardware(placed: bool = False) -> Iterator[tuple[str, ...]]:
    """What each takes; the last columns only where all is placed and routed, which takes minutes."""
    yield "In hardware", "latency", "slices", "LUT", "FF", "MULT", "clock", *(("ECP5", "routed") if placed else ())
    for name, compensator in COMPENSATORS.items():
        r = resources(name, "xc2vp")
        clock = f"{r.clock.megahertz:.1f} MHz" if r.clock.megahertz else ""
        row = (str(compensator.ticks), str(r.slices_bound), str(r.luts), str(r.flip_flops), str(r.multipliers), clock)
        if placed and compensator.ticks:
            ecp5 = resources(name, "ecp5")
            routed = f"{ecp5.clock.megahertz:.1f} MHz" if ecp5.clock.megahertz else "not placed"
            row += (f"{ecp5.luts} LUT, {ecp5.multipliers} MULT", routed)
        yield name, *row


def main() -> None:
    """Print both tables."""
    for table in (left(), hardware(placed=True)):
        for row in table:
            print("".join(f"{cell:34}" if n == 0 else f"{cell:18}" for n, cell in enumerate(row)).rstrip(), flush=True)
        print()


if __name__ == "__main__":
    main()
