"""Random chains of fixed-point blocks behind noise, each with the formats that it has, and with many more bits."""

import math
import random
from typing import Any

from proofmass.blocks import (
    FixedCast,
    FixedDelay,
    FixedDifference,
    FixedFiniteImpulseResponse,
    FixedGain,
    FixedMovingAverage,
    FixedQuantiser,
    FixedSecondOrderSection,
    FixedSum,
    FixedToNumber,
    LowPass,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.fixed_format import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph

RATE = 1000
INTEGER_BITS, FINE = 12, 24
GAINS = 0.125, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0, 1.002, 0.505, 0.334, 1.49
RULES = "half_even", "half_even", "half_up", "floor"
OUTPUT = "number.output"


class _Chain:
    """A chain as it grows; where it is `fine` its blocks drop next to nothing."""

    def __init__(self, number: int, fine: bool) -> None:
        self.dice, self.number, self.fine = random.Random(number), number, fine
        self.blocks, self.wires = dict[str, Block](), list[str]()
        self.fraction = self.dice.randint(0, 8)
        self.format = Fixed(self.fraction + INTEGER_BITS, self.fraction)

    def graph(self) -> Graph:
        step = 2.0**-self.fraction * 10.0 ** self.dice.uniform(-0.5, 1.5)
        signal = self.add("noise", WhiteNoise(density=step * math.sqrt(2.0 / RATE)), "output")
        if self.dice.random() < 0.4:
            signal = self.add("corner", LowPass(corner_frequency=10.0 ** self.dice.uniform(1.3, 2.5)), "output", signal)
        signal = self.add("quantiser", FixedQuantiser(output_format=self.format), "output", signal)
        for place in range(self.dice.randint(1, 4)):
            signal = self.element(f"{self.dice.choice('abcxyz')}{place}", signal)
        self.add("number", FixedToNumber(input_format=self.format), "output", signal)
        name = f"chain {self.number}"
        return Graph(name=name, rate=RATE, blocks=self.blocks, wires=self.wires, probes=[OUTPUT])

    def add(self, name: str, block: Block, output: str, signal: str = "", port: str = "input") -> str:
        self.blocks[name] = block
        self.wires += [f"{signal} -> {name}.{port}"] if signal else []
        return f"{name}.{output}"

    def element(self, name: str, signal: str) -> str:
        """Return the output of another element."""
        dice, before = self.dice, self.format
        self.fraction = dice.randint(max(0, self.fraction - 4), min(9, self.fraction + 2))
        self.format = output = Fixed(FINE + INTEGER_BITS, FINE) if self.fine else self.near(0)
        formats: dict[str, Any] = {"input_format": before, "output_format": output, "rounding": dice.choice(RULES)}
        taps = [dice.choice((-0.5, 0.25, 0.5, 0.75, 1.0, round(dice.uniform(-0.7, 0.7), 2))) for _ in range(3)]
        match dice.randint(0, 6):
            case 0:
                return self.add(name, FixedCast(**formats), "output", signal)
            case 1 | 2:
                gain = dice.choice(GAINS) if dice.random() < 0.7 else round(dice.uniform(0.1, 2.0), 3)
                return self.add(name, FixedGain(gain=gain, **formats), "output", signal)
            case 3:
                kind = dice.choice((FixedSum, FixedDifference))
                late = self.add(f"{name}_late", FixedDelay(format=before, ticks=dice.randint(1, 3)), "output", signal)
                self.wires.append(f"{late} -> {name}.second")
                return self.add(name, kind(**formats), "output", signal, "first")
            case 4:
                return self.add(
                    name,
                    FixedFiniteImpulseResponse(taps=tuple(taps), tap_format=Fixed(16, 14), **formats),
                    "output",
                    signal,
                )
            case 5:
                return self.add(name, FixedMovingAverage(order=dice.randint(1, 2), **formats), "mean", signal)
        size, angle = round(dice.uniform(0.2, 0.8), 2), round(dice.uniform(0.3, 2.8), 2)
        b0, b1, b2 = taps
        poles = {"a1": -2.0 * size * math.cos(angle), "a2": size**2}
        state = self.near(dice.randint(0, 3))
        formats |= {"state_format": output if self.fine else state}
        return self.add(name, FixedSecondOrderSection(b0=b0, b1=b1, b2=b2, **poles, **formats), "output", signal)

    def near(self, more: int) -> Fixed:
        return Fixed(self.fraction + more + INTEGER_BITS, self.fraction + more)


def fixed_chain(number: int, fine: bool = False) -> Graph:
    """Return a random chain; the same blocks have many more bits where it is `fine`."""
    return _Chain(number, fine).graph()
