"""Random chains and loops through carriers, choppers, gates, converters, averages and delays at several rates.

What such a graph does is told by its run alone: the rms of white noise that goes through a chain, and how fast a loop
grows that begins next to rest.
"""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from proofmass import Block, Graph, Input, RunError, param, simulate
from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Decimator,
    Delay,
    Difference,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    Gain,
    LowPass,
    MovingAverage,
    Product,
    RepeatingSequence,
    Sine,
    TransferFunction,
    UnitDelay,
    WhiteNoise,
)

RATE = 80_000  # Hz
_PARTS = 8  # of a run, whose scatter says how well its rms is known
_BEGINS, _LASTS = 8_000, 48_000  # ticks until a response stands, and in which it is read


class ClockedGate(Block):
    """Gate of a clock: its input, but its negative, or nothing, in some of the ticks of a turn."""

    length: int = param("1", "Ticks of a turn.", default=4)
    first: int = param("1", "Number of the tick from which on it is turned.", default=2)
    part: float = param("1", "What is left of the input from there on.", default=-1.0)
    input = Input("1", "Signal.")


@ClockedGate.output("1")
def gated(p: ClockedGate, input: float, tick: int) -> float:
    """The input or a part of it."""
    return p.part * input if tick % p.length >= p.first else input


@dataclass
class Path:
    """A chain of blocks that grows at its end `at`."""

    draw: random.Random
    at: str
    blocks: dict[str, Block]
    wires: list[str] = field(default_factory=list)
    rates: dict[str, Fraction] = field(default_factory=dict)
    offsets: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, block: Block, into: str = "input", out: str = "output") -> None:
        """Put a block at the end."""
        self.blocks[name] = block
        self.wires.append(f"{self.at} -> {name}.{into}")
        self.at = f"{name}.{out}"

    def slow(self, name: str) -> None:
        """Let a block tick more seldom, perhaps, and later than others."""
        divisor = self.draw.choice((1, 1, 2, 3, 4, 6))
        if divisor > 1:
            self.rates[name] = Fraction(RATE, divisor)
            if self.draw.random() < 0.5:
                self.offsets[name] = f"{self.draw.randrange(divisor) / RATE} s"

    def carrier(self, name: str) -> str:
        """Return the end of a source that repeats in 2 to 16 ticks: a sine, in steps of a converter too, or a list."""
        draw, ticks = self.draw, self.draw.choice((2, 3, 4, 5, 6, 8, 8, 12, 16))
        phase = draw.choice((0.0, math.pi / ticks, 0.5 * math.pi + math.pi / ticks, draw.uniform(-3.0, 3.0)))
        kind = draw.choice(("sine", "sine", "steps", "list", "chopper"))
        if kind in ("sine", "steps"):
            size = draw.uniform(1.6, 3.4) if kind == "steps" else draw.uniform(0.5, 2.0)
            unit = "V" if kind == "steps" else "1"
            self.blocks[name] = Sine(frequency=RATE / ticks, phase=phase, amplitude=size, unit=unit)
        else:
            half = draw.choice((1, 2, 3, 5))
            values = tuple(draw.choice((1.0, 1.0, -1.0, 0.5)) for _ in range(ticks))
            self.blocks[name] = RepeatingSequence(values=values if kind == "list" else (1.0,) * half + (-1.0,) * half)
        if kind != "steps":
            return f"{name}.output"
        self.blocks[f"{name}_steps"] = AnalogToDigital(bits=3, reference=4.0)
        self.wires.append(f"{name}.output -> {name}_steps.voltage")
        return f"{name}_steps.number"

    def grow(self, number: int, kinds: tuple[str, ...]) -> None:
        """Put one of some kinds at the end."""
        draw, name = self.draw, f"e{number}"
        match draw.choice(kinds):
            case "mixer":
                carrier = self.carrier(f"c{number}")
                for end in (name, f"{name}_back")[: draw.choice((1, 2))]:
                    self.add(end, Product(), "first")
                    self.wires.append(f"{carrier} -> {end}.second")
            case "gate":
                length = draw.choice((2, 3, 4, 6, 9))
                gate = ClockedGate(length=length, first=draw.randrange(1, length), part=draw.choice((-1.0, 0.0, 0.5)))
                self.add(name, gate, out="gated")
            case "delay":
                self.add(name, draw.choice((UnitDelay(), Delay(ticks=draw.choice((2, 3, 7, 16))))))
                self.slow(name)
            case "low pass":
                self.add(name, LowPass(corner_frequency=draw.choice((300.0, 3000.0, 20_000.0))))
            case "resonator":
                w = 2.0 * math.pi * 3000.0
                damping = draw.choice((0.1, 0.5))
                self.add(name, TransferFunction(numerator=(1.0,), denominator=(w**-2, 2.0 * damping / w, 1.0)))
            case "filter":
                self.add(name, DiscreteTransferFunction(numerator=(0.2, 0.1), denominator=(1.0, -0.9, 0.2)))
            case "gain":
                self.add(name, Gain(gain=draw.uniform(0.5, 2.0)))
                self.slow(name)
            case "average":
                self.add(name, MovingAverage(length=draw.choice((2, 3, 5))), out="mean")
                self.slow(name)
            case "decimator":
                if not any(isinstance(block, Decimator) for block in self.blocks.values()):
                    self.add(name, Decimator(ratio=draw.choice((2, 3, 4))), out="mean")
            case "converter":
                self.add(f"{name}_volts", Gain(output_unit="V"))
                self.add(name, AnalogToDigital(bits=draw.choice((10, 12)), reference=40.0), "voltage", "number")
                self.slow(name)

    def graph(self, **more: Any) -> Graph:
        """Return the graph."""
        return Graph(
            name="carriers", rate=RATE, blocks=self.blocks, wires=self.wires, rates=self.rates, offsets=self.offsets,
            **more,
        )  # fmt: skip


_IN_CHAINS = (
    "mixer", "mixer", "gate", "delay", "low pass", "resonator", "filter", "gain", "average", "decimator", "converter",
)  # fmt: skip
_IN_RESPONSES = tuple(kind for kind in _IN_CHAINS if kind != "converter")
_IN_LOOPS = tuple(kind for kind in _IN_CHAINS if kind not in ("average", "converter"))


def random_chain(seed: int) -> tuple[Graph, str]:
    """White noise of variance one through 2 to 5 elements, and the end."""
    draw = random.Random(seed)
    path = Path(draw, "noise.output", {"noise": WhiteNoise(density=math.sqrt(2.0 / RATE))})
    for number in range(draw.randint(2, 5)):
        path.grow(number, _IN_CHAINS)
    return path.graph(samples=120_000, probes=[path.at]), path.at


def random_response(seed: int, source: Block) -> tuple[Graph, str]:
    """Return a source through 2 to 5 elements without converters, and the end."""
    draw = random.Random(seed)
    path = Path(draw, "source.output", {"source": source})
    for number in range(draw.randint(2, 5)):
        path.grow(number, _IN_RESPONSES)
    return path.graph(samples=_BEGINS + _LASTS, probes=[path.at]), path.at


def gain_of_run(graphs: Sequence[Graph], output: str, frequency: float) -> complex:
    """Return the gain that runs have at a frequency: with a cosine of size one at the input, a sine, and nothing."""
    lines = []
    for graph in graphs:
        signal = simulate(graph)[output]
        times, values = np.asarray(signal.times), np.asarray(signal.values, dtype=float)
        window = np.hanning(np.count_nonzero(times >= _BEGINS / RATE))
        lines.append(
            np.dot(window, (values * np.exp(-2j * math.pi * frequency * times))[-len(window) :]) / window.sum()
        )
    cosine, sine, nothing = lines
    return complex(cosine - nothing + 1j * (sine - nothing))


def rms_of_run(graph: Graph, output: str) -> tuple[float, float]:
    """Return the rms of an output in a run, and a bound of how far it may be from that of all runs."""
    values = np.asarray(simulate(graph)[output].values, dtype=float)
    squares = [float(np.mean(part**2)) for part in np.array_split(values[len(values) // 16 :], _PARTS)]
    rms = math.sqrt(sum(squares) / _PARTS)
    scatter = float(np.std(squares)) / math.sqrt(_PARTS) / max(rms, 1e-300)
    return rms, 4.0 * 0.5 * scatter + 0.015 * rms


def random_loop(seed: int) -> Graph:
    """An integrator, a gain, an error and 1 to 4 elements between, from an integrator that begins at one."""
    draw = random.Random(seed)
    path = Path(draw, "error.output", {"rest": Constant(value=0.0), "error": Difference()})
    path.wires = ["rest.output -> error.first", "gain.output -> error.second"]
    for number in range(draw.randint(1, 4)):
        path.grow(number, _IN_LOOPS)
    path.add("sum", DiscreteIntegrator(gain=draw.choice((300.0, 3000.0)), output_unit="1", initial=1.0))
    if draw.random() < 0.3:
        path.slow("sum")
    path.add("gain", Gain(gain=draw.choice((1.0, 1.0, -1.0))))
    loops = {"main": {"open_at": draw.choice(("gain.output", "sum.output"))}}
    return path.graph(samples=40_000, probes=["sum.output"], loops=loops)


def growth_of_run(graph: Graph, factor: float = 1.0) -> float:
    """Return by how much a loop grows in a tick of its run, with a factor in it: the logarithm, negative if it decays.

    From two thirds of a run to its end what decays fast is gone. A run that ends for its size grows.
    """
    gain = graph.blocks["gain"]
    assert isinstance(gain, Gain)
    try:
        result = simulate(graph.with_parameters({"gain.gain": gain.gain * factor}))
    except RunError:
        return math.inf
    sizes = np.abs(np.asarray(result["sum.output"].values, dtype=float))
    first, last = (float(part.max()) for part in np.array_split(sizes, 6)[2::3])
    return math.log(max(last, 1e-300) / max(first, 1e-300)) / (0.5 * len(sizes))
