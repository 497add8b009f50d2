"""Loops that go round an orbit, as graphs, with their orbits in closed form or by a program of their own.

- demodulated loop: x' = x + k (u - c^2 (x + x^2 / 2)) with c = sin(n pi / 2) = 0, 1, 0, -1. So x1 = x0 + k u while c is
  zero, and back by x0 = x1 + k (u - x1 - x1^2 / 2): x1 = sqrt(1 + 4 u) - 1. The slope over the four ticks is
  (1 - k (1 + x1))^2, and a factor g at the wire makes it (1 - g k (1 + x1))^2
- averaged loop: an amplitude a is that of the period of the carrier before, a' = cos(p) (x + x^2 / 2), and
  x' = x + k (u - a). So x = sqrt(1 + 2 u / cos(p)) - 1, and the loop is stable up to k cos(p) (1 + x) = 1
- mixed loop: x' = x + k (u + a s - (1 + b s) (d + e d^2)), d' = x, s = sin(2 pi n / p + q)

White noise may be added to what is wanted, u or u + a s.
"""

import math
import re

import numpy as np
import scipy.linalg

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph

DEMODULATED = """
name = "demodulated loop"
rate = "1 kHz"
samples = 400
wires = ["level.output -> error.first", "plant.output -> curve.temperature", "curve.value -> modulator.first",
         "carrier.output -> modulator.second", "modulator.output -> demodulator.first",
         "carrier.output -> demodulator.second", "demodulator.output -> error.second",
         "error.output -> gain.input", "gain.output -> plant.input"]
probes = ["plant.output"]
[loops.main]
open_at = "plant.output"
[blocks.level]
kind = "Constant"
value = 1.0
[blocks.carrier]
kind = "Sine"
frequency = "250 Hz"
[blocks.error]
kind = "Difference"
[blocks.gain]
kind = "Gain"
gain = 100.0
[blocks.modulator]
kind = "Product"
[blocks.demodulator]
kind = "Product"
[blocks.plant]
kind = "DiscreteIntegrator"
output_unit = "1"
[blocks.curve]
kind = "PolynomialModel"
temperature_unit = "1"
unit = "1"
c1 = 1.0
c2 = 0.5
"""

AVERAGED = """
name = "averaged loop"
rate = "125 Hz"
samples = 60
wires = ["level.output -> error.first", "plant.output -> curve.temperature", "curve.value -> modulator.first",
         "carrier.output -> modulator.second", "modulator.output -> demodulator.number",
         "demodulator.amplitude -> error.second", "error.output -> gain.input", "gain.output -> plant.input"]
probes = ["plant.output"]
[loops.main]
open_at = "plant.output"
[blocks]
level = { kind = "Constant", value = 1.0 }
carrier = { kind = "Sine", frequency = "125 Hz", rate = "1 kHz" }
modulator = { kind = "Product", rate = "1 kHz" }
demodulator = { kind = "DigitalDemodulator", rate = "1 kHz", phase = 0.5 }
error = { kind = "Difference" }
gain = { kind = "Gain", gain = 25.0 }
plant = { kind = "DiscreteIntegrator", output_unit = "1" }
curve = { kind = "PolynomialModel", temperature_unit = "1", unit = "1", c1 = 1.0, c2 = 0.5 }
"""

MIXED = """
name = "mixed loop"
rate = "1 kHz"
samples = 3000
wires = ["level.output -> drive.first", "carrier.output -> shake.input", "shake.output -> drive.second",
         "drive.output -> error.first", "plant.output -> delay.input", "delay.output -> curve.temperature",
         "curve.value -> mixer.first", "carrier.output -> depth.input", "depth.output -> around.first",
         "one.output -> around.second", "around.output -> mixer.second", "mixer.output -> error.second",
         "error.output -> gain.input", "gain.output -> plant.input"]
probes = ["plant.output", "delay.output"]
[loops.main]
open_at = "plant.output"
[blocks]
level = { kind = "Constant", value = LEVEL }
one = { kind = "Constant", value = 1.0 }
carrier = { kind = "Sine", frequency = FREQUENCY, phase = PHASE }
shake = { kind = "Gain", gain = SHAKE }
depth = { kind = "Gain", gain = DEPTH }
drive = { kind = "Sum" }
around = { kind = "Sum" }
error = { kind = "Difference" }
gain = { kind = "Gain", gain = GAIN }
mixer = { kind = "Product" }
plant = { kind = "DiscreteIntegrator", output_unit = "1" }
delay = { kind = "UnitDelay" }
curve = { kind = "PolynomialModel", temperature_unit = "1", unit = "1", c1 = 1.0, c2 = BEND }
"""


DENSITY = 0.02
SIGMA = DENSITY * math.sqrt(500.0)  # of a number of white noise in each tick of 1 ms


def with_noise(text: str) -> str:
    """Return a loop in which white noise is added to the first of the two numbers that differ."""
    ((whole, wanted),) = re.findall(r'("(\S+) -> error\.first")', text)
    wires = f'"{wanted} -> shaken.first", "noise.output -> shaken.second", "shaken.output -> error.first"'
    added = f'[blocks.noise]\nkind = "WhiteNoise"\ndensity = {DENSITY}\n[blocks.shaken]\nkind = "Sum"\n'
    return text.replace(whole, wires) + added


def demodulated_rms(level: float, gain: float, error: float = 0.0) -> float:
    """Return the rms of x over the orbit of the demodulated loop, of noise w and an `error` e of what is read.

    Of w and of e, each in every tick, dx1 = dx0 + k w and dx0 = dx1 - k (1 + x1) (dx1 + e) + k w.
    """
    k, slope = 1e-3 * gain, 1.0 + demodulated_orbit(level, gain)[1]
    square, a = (k * SIGMA) ** 2, 1.0 - k * slope
    first = (2.0 * square + (k * slope * error) ** 2) / (1.0 - a * a)  # of x1, as that of x0 is less by the square
    return math.sqrt(first - 0.5 * square)


def demodulated_orbit(level: float, gain: float) -> tuple[float, float]:
    """Return x0 and x1 of the demodulated loop, gain in 1/s."""
    later = math.sqrt(1.0 + 4.0 * level) - 1.0
    return later - 1e-3 * gain * level, later


def demodulated_margin(level: float, gain: float) -> float:
    """Return the largest factor at the wire that the demodulated loop bears."""
    return 2.0 / (1e-3 * gain * (1.0 + demodulated_orbit(level, gain)[1]))


def averaged_margin(level: float, gain: float, phase: float) -> float:
    """Return the largest factor at the wire that the averaged loop bears."""
    rest = math.sqrt(1.0 + 2.0 * level / math.cos(phase)) - 1.0
    return 1.0 / (8e-3 * gain * math.cos(phase) * (1.0 + rest))


class MixedLoop:
    """A mixed loop with some parameters, in units of ticks, by a program of its own."""

    def __init__(self, **given: float) -> None:
        self.given = {"level": 1.0, "shake": 0.3, "depth": 0.5, "gain": 100.0, "bend": 0.3} | given

    def graph(self, cycles: int, ticks: int, phase: float, noisy: bool = False) -> Graph:
        """Return the graph, with a carrier of some cycles in some ticks."""
        text = with_noise(MIXED) if noisy else MIXED
        text = text.replace("FREQUENCY", repr(1000.0 * cycles / ticks)).replace("PHASE", repr(phase))
        for name, value in self.given.items():
            text = text.replace(name.upper(), repr(value))
        return read_graph_text(text)

    def step(self, x: float, d: float, s: float) -> tuple[float, float]:
        """Return the states a tick later."""
        g = self.given
        back = (1.0 + g["depth"] * s) * (d + g["bend"] * d * d)
        return x + 1e-3 * g["gain"] * (g["level"] + g["shake"] * s - back), x

    def orbit(self, carrier: list[float]) -> list[tuple[float, float]] | None:
        """Return the states at each tick of an orbit that a run from zero comes to; None if it comes to none."""
        x = d = 0.0
        before = (x, d)
        for period in range(200_000 // len(carrier)):
            for s in carrier:
                x, d = self.step(x, d, s)
            if not abs(x) < 1e6:
                return None
            if period > 50 and math.dist(before, (x, d)) < 1e-13 * (1.0 + abs(x)):
                break
            before = (x, d)
        else:
            return None
        states = []
        for s in carrier:
            states.append((x, d))
            x, d = self.step(x, d, s)
        return states

    def largest_pole(self, carrier: list[float], factor: float = 1.0) -> float:
        """Return the size of the largest pole over the orbit, with a factor at the wire; infinite without an orbit."""
        slopes, whole = self.slopes(carrier, factor), np.eye(2)
        if slopes is None:
            return math.inf
        for slope in slopes:
            whole = slope @ whole
        return float(np.abs(np.linalg.eigvals(whole)).max())

    def slopes(self, carrier: list[float], factor: float = 1.0) -> list[np.ndarray] | None:
        """Return the derivatives of the states by those of the tick before, all round the orbit; None without one."""
        states, g = self.orbit(carrier), self.given
        if states is None:
            return None
        by = [(1.0 + g["depth"] * s) * (1.0 + 2.0 * g["bend"] * d) for (_, d), s in zip(states, carrier, strict=True)]
        return [np.array([[1.0, -1e-3 * g["gain"] * slope], [factor, 0.0]]) for slope in by]

    def rms(self, carrier: list[float]) -> float:
        """Return the rms of x over the orbit, by the covariance at its start; infinite where it does not decay."""
        if not self.largest_pole(carrier) < 1.0:
            return math.inf
        slopes, entering = self.slopes(carrier) or [], np.diag([(1e-3 * self.given["gain"] * SIGMA) ** 2, 0.0])
        whole, added = np.eye(2), np.zeros((2, 2))
        for slope in slopes:
            whole, added = slope @ whole, slope @ added @ slope.T + entering
        now, squares = scipy.linalg.solve_discrete_lyapunov(whole, added), 0.0
        for slope in slopes:
            squares += now[0, 0] / len(slopes)
            now = slope @ now @ slope.T + entering
        return math.sqrt(squares)


def carrier_of(cycles: int, ticks: int, phase: float) -> list[float]:
    """Return the carrier of a mixed loop, tick by tick, over one turn of it."""
    return [math.sin(2.0 * math.pi * cycles * n / ticks + phase) for n in range(ticks // math.gcd(cycles, ticks))]
