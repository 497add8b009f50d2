"""Random graphs with noise: several rates, clock offsets, carriers, switches, converters, driven parameters and loops.

A graph grows from sources of noise. Each further element takes a signal that is there, one of the last most often.
What is not linear is given a level beside which noise is small, so that budgets hold for it.
"""

import math
import random
from collections.abc import Callable
from fractions import Fraction

from proofmass.blocks import (
    Absolute,
    AnalogToDigital,
    CascadedIntegratorComb,
    ChopperModulator,
    Comparator,
    Constant,
    CorrelatedDoubleSampling,
    Decimator,
    Delay,
    Difference,
    DigitalDemodulator,
    DiscreteTransferFunction,
    FirstOrderHold,
    FlickerNoise,
    FractionalDelay,
    Gain,
    GaussMarkov,
    InPhaseQuadratureDemodulator,
    LowPass,
    MovingAverage,
    Notch,
    Power,
    Product,
    Pulse,
    Quotient,
    RepeatingSequence,
    SampleAndHold,
    SecondOrderSection,
    Sine,
    Sum,
    Switch,
    SynchronousDemodulator,
    TransferFunction,
    UnitDelay,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph

RATE, DIVISORS = 1000, (1, 1, 1, 1, 2, 2, 3, 4, 6)


def noisy_graph(number: int) -> tuple[Graph, str]:
    """Return a random graph, and an output of it that noise may reach."""
    grown = _Grown(random.Random(number))
    grown.source()
    for _ in range(grown.dice.randint(2, 7)):
        grown.element()
    return grown.graph(number), grown.signals[-1]


class _Grown:
    """A graph as it grows."""

    def __init__(self, dice: random.Random) -> None:
        self.dice = dice
        self.blocks, self.divisors = dict[str, Block](), dict[str, int]()
        self.wires, self.signals = list[str](), list[str]()

    def graph(self, number: int) -> Graph:
        offsets = dict[str, Fraction]()
        if self.dice.random() < 0.25:
            late = [name for name in self.divisors if self.dice.random() < 0.3]
            offsets = {name: Fraction(self.dice.randint(1, 2 * self.divisors[name] - 1), 2 * RATE) for name in late}
        return Graph(
            name=f"noisy {number}",
            rate=RATE,
            duration="2 s",
            blocks=self.blocks,
            wires=self.wires,
            rates={name: Fraction(RATE, divisor) for name, divisor in self.divisors.items()},
            offsets=offsets,
            probes=self.signals[-1:],
        )

    def add(self, block: Block, divisor: int = 0, **wires: str) -> str:
        """Return the name of a new block, which is not in the order of the wires by the alphabet."""
        name = f"{self.dice.choice('abcdefgh')}_{len(self.blocks)}"
        self.blocks[name] = block
        if not type(block).continuous():
            self.divisors[name] = divisor or self.dice.choice(DIVISORS)
        self.wires += [f"{signal} -> {name}.{port}" for port, signal in wires.items()]
        return name

    def any(self) -> str:
        """Return a signal, one of the last most often."""
        return self.dice.choice(self.signals[-4:] if self.dice.random() < 0.7 else self.signals)

    def near(self, low: float, high: float) -> float:
        return round(self.dice.uniform(low, high), 4)

    def source(self) -> None:
        size = 10.0 ** self.dice.uniform(-3.5, -2.5)
        match self.dice.randint(0, 4):
            case 0:
                flicker = FlickerNoise(level=0.1 * size, lowest_frequency=20.0, highest_frequency=400.0)
                self.signals.append(f"{self.add(flicker)}.deviation")
            case 1:
                wander = GaussMarkov(standard_deviation=size, correlation_time=self.dice.choice([2e-3, 1e-2]))
                self.signals.append(f"{self.add(wander)}.deviation")
            case _:
                white = WhiteNoise(density=size * math.sqrt(2.0 / RATE))
                self.signals.append(f"{self.add(white)}.output")

    def element(self) -> None:
        """Add an element behind a signal, or another source."""
        kinds: list[Callable[[], None]] = [self.filtered] * 8 + [self.summed, self.source, self.converted]
        kinds += [self.mixed, self.chopped, self.switched, self.demodulated, self.driven, self.bent, self.loop] * 2
        self.dice.choice(kinds)()

    def filtered(self) -> None:
        self.chain(*self.filter())

    def chain(self, block: Block, entry: str, exit: str) -> None:
        self.signals.append(f"{self.add(block, **{entry: self.any()})}.{exit}")

    def filter(self) -> tuple[Block, str, str]:
        """Return a filter with its input and output."""
        near, dice, plain = self.near, self.dice, ("input", "output")
        size, angle, w = near(0.3, 0.97), near(0.1, 3.0), 10.0 ** near(1.8, 3.8)
        window = dice.randint(2, 5)
        table: list[tuple[Block, str, str]] = [
            (Gain(gain=near(-2.0, 2.0)), *plain),
            (UnitDelay(), *plain),
            (Delay(ticks=dice.randint(1, 5)), *plain),
            (FractionalDelay(delay=near(1.0, 5.0)), *plain),
            (FirstOrderHold(ratio=dice.randint(2, 4), delayed=dice.random() < 0.5), *plain),
            (MovingAverage(length=window), "input", "mean"),
            (Decimator(ratio=window), "input", "mean"),
            (CascadedIntegratorComb(order=dice.randint(1, 3), ratio=window), "input", "output"),
            (CorrelatedDoubleSampling(window=window, second=window - 1, unit="1"), "input", "difference"),
            (Notch(frequency=near(20.0, 150.0), quality=near(0.5, 5.0)), *plain),
            (DiscreteTransferFunction(numerator=(1.0, near(-1, 1)), denominator=(1.0, near(-0.9, 0.9))), *plain),
            (SecondOrderSection(b0=near(-1, 1), b1=near(-1, 1), a1=-2 * size * math.cos(angle), a2=size**2), *plain),
            (LowPass(corner_frequency=10.0 ** near(0.8, 2.8)), *plain),
            (TransferFunction(numerator=(w * near(0, 1), w * w), denominator=(1.0, w * near(0.1, 2.0), w * w)), *plain),
        ]
        return dice.choice(table)

    def summed(self) -> None:
        self.signals.append(f"{self.add(Sum(), first=self.any(), second=self.any())}.output")

    def converted(self) -> None:
        """A converter whose steps are small beside all noise."""
        volts = self.add(Gain(output_unit="V"), 1, input=self.any())
        adc = self.add(AnalogToDigital(bits=24, reference=2.0), voltage=f"{volts}.output")
        self.signals.append(f"{self.add(Gain(gain=2.0**-23), input=f'{adc}.number')}.output")

    def carrier(self) -> str:
        values = tuple(self.near(-1.0, 2.0) for _ in range(self.dice.randint(2, 6)))
        sine = Sine(frequency=self.dice.choice([50.0, 100.0, 125.0, 200.0, 250.0]), phase=self.near(0.0, 6.0))
        length = self.dice.choice([4e-3, 1e-2])
        pulse = Pulse(amplitude=self.near(0.5, 2.0), offset=self.near(-1.0, 0.0), repetition=length)
        return f"{self.add(self.dice.choice([sine, pulse, RepeatingSequence(values=values)]))}.output"

    def mixed(self) -> None:
        self.signals.append(f"{self.add(Product(), first=self.any(), second=self.carrier())}.output")

    def chopped(self) -> None:
        self.chain(ChopperModulator(half_period=self.dice.randint(1, 4), unit="1"), "input", "output")

    def switched(self) -> None:
        on = f"{self.add(Comparator(threshold=self.near(-0.3, 0.3)), input=self.carrier())}.on"
        if self.dice.random() < 0.5:
            block = self.add(Switch(), first=self.any(), second=self.any(), choose_first=on)
        else:
            block = self.add(SampleAndHold(), signal=self.any(), hold=on)
        self.signals.append(f"{block}.output")

    def demodulated(self) -> None:
        ratio, port = self.dice.choice([4, 5, 8]), self.dice.choice(["in_phase", "quadrature"])
        if self.dice.random() < 0.3:
            self.chain(DigitalDemodulator(samples=ratio, phase=self.near(0.0, 3.0)), "number", "amplitude")
            return
        sine, cosine = (
            f"{self.add(Sine(frequency=RATE / ratio, phase=phase), 1)}.output" for phase in (0.0, 0.5 * math.pi)
        )
        lowpass = InPhaseQuadratureDemodulator(corner_frequency=self.near(10.0, 80.0), unit="1")
        block = self.dice.choice([SynchronousDemodulator(ratio=ratio, unit="1"), lowpass])
        self.signals.append(f"{self.add(block, 1, signal=self.any(), sine=sine, cosine=cosine)}.{port}")

    def level(self, value: float) -> str:
        """Return a signal about a level."""
        constant = self.add(Constant(value=value), 1)
        return f"{self.add(Sum(), 1, first=self.any(), second=f'{constant}.output')}.output"

    def driven(self) -> None:
        """A gain, or a corner of a low-pass, that noise moves."""
        if self.dice.random() < 0.5:
            block = self.add(Gain(), input=self.level(self.near(0.5, 1.5)))
            self.wires.append(f"{self.level(1.0)} -> {block}.gain")
        else:
            hertz = self.add(Gain(gain=self.near(20.0, 120.0), output_unit="Hz"), 1, input=self.level(1.0))
            block = self.add(LowPass(), input=self.level(1.0))
            self.wires.append(f"{hertz}.output -> {block}.corner_frequency")
        self.signals.append(f"{block}.output")

    def bent(self) -> None:
        if self.dice.random() < 0.3:
            self.chain(Absolute(), "input", "output")
            self.wires[-1] = f"{self.level(-1.0)} -> {self.wires[-1].split(' -> ')[1]}"
        elif self.dice.random() < 0.5:
            power = self.add(Power(exponent=self.dice.choice([2.0, 0.5, 3.0])), input=self.level(self.near(0.5, 1.5)))
            self.signals.append(f"{power}.output")
        else:
            bottom = self.level(self.near(0.6, 2.0))
            self.signals.append(f"{self.add(Quotient(), numerator=self.level(1.0), denominator=bottom)}.output")

    def loop(self) -> None:
        """Feedback about a filter, or two."""
        error = self.add(Difference(), first=self.any())
        before, self.signals = self.signals, [f"{error}.output"]
        for _ in range(self.dice.randint(1, 2)):
            self.filtered()
        back = self.add(Gain(gain=self.near(-0.4, 0.4)), input=self.signals[-1])
        self.wires.append(f"{self.add(UnitDelay(), input=f'{back}.output')}.output -> {error}.second")
        self.signals = before + self.signals[1:]
