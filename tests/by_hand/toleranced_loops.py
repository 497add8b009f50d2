"""Random sampled loops with tolerances, as graphs and as equations of a tick written down by hand.

A loop is a chain: minus, a gain, some elements, and back. In each tick every element that ticks puts out, then moves
on; what an element of a slower rate put out is held. The matrix of a period is what these equations do to unit vectors.
With T the period of the element, u its input and y its output:

    integrator   y = x,   x' = x + g T u
    leak         y = x,   x' = x + g T (u - b x): an integrator with a gain about it
    delay        y is u of n ticks before
    flexure      J a'' + c a' + k a = u between ticks, y = a
    PID          y = Kp u + Ki T (sum of u) + d,   d = p d' + Kd (1 - p) (u - u') / T,   p = exp(-2 pi f T)
"""

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg
import scipy.optimize

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph

Values = Mapping[str, float]
RATE = 1024  # Hz: its period is an exact double


@dataclass
class Element:
    """An element of the chain: its blocks as TOML, its wires, and its equations."""

    name: str
    first: str  # the input of its first block
    last: str  # its output
    text: str
    values: dict[str, float]  # nominal parameters
    size: int  # numbers of its state
    output: Callable[[Values, Any, Any], Any]  # of the parameters, the state and the input
    update: Callable[[Values, Any, Any], Any]
    through: bool = False  # whether the output follows the input in the same tick
    every: int = 1  # base ticks
    wires: list[str] = field(default_factory=list)


def _rate(every: int) -> str:
    return f'rate = "{RATE}/{every} Hz"\n'


def integrator(name: str, draw: random.Random, every: int) -> Element:
    t = every / RATE
    return Element(
        name, f"{name}.input", f"{name}.output",
        f'[blocks.{name}]\nkind = "DiscreteIntegrator"\noutput_unit = "1"\n{_rate(every)}',
        {f"{name}.gain": draw.uniform(5.0, 120.0) / every}, 1,
        lambda v, x, u: x[0], lambda v, x, u: [x[0] + v[f"{name}.gain"] * t * u], every=every,
    )  # fmt: skip


def leak(name: str, draw: random.Random, every: int) -> Element:
    t = every / RATE
    text = "".join(
        f'[blocks.{block}]\nkind = "{kind}"\n{_rate(every)}'
        for block, kind in ((f"{name}_in", "Difference"), (f"{name}_back", "Gain"), (name, "DiscreteIntegrator"))
    )
    return Element(
        name, f"{name}_in.first", f"{name}.output", text + 'output_unit = "1"\n',
        {f"{name}.gain": draw.uniform(5.0, 100.0), f"{name}_back.gain": draw.uniform(0.5, 6.0)}, 1,
        lambda v, x, u: x[0],
        lambda v, x, u: [x[0] + v[f"{name}.gain"] * t * (u - v[f"{name}_back.gain"] * x[0])], every=every,
        wires=[f"{name}_in.output -> {name}.input", f"{name}.output -> {name}_back.input",
               f"{name}_back.output -> {name}_in.second"],
    )  # fmt: skip


def delay(name: str, draw: random.Random, every: int) -> Element:
    ticks = draw.randint(1, 3)
    return Element(
        name, f"{name}.input", f"{name}.output",
        f'[blocks.{name}]\nkind = "Delay"\nticks = {ticks}\n{_rate(every)}', {}, ticks,
        lambda v, x, u: x[0], lambda v, x, u: [*x[1:], u], every=every,
    )  # fmt: skip


def flexure(name: str, draw: random.Random, every: int) -> Element:
    inertia = draw.uniform(0.5, 2.0)
    stiffness = inertia * draw.uniform(20.0, 200.0) ** 2
    damping = 2.0 * draw.uniform(0.1, 0.9) * math.sqrt(stiffness * inertia)
    gain = stiffness * draw.uniform(0.3, 1.5)

    def update(v: Values, x: Any, u: Any) -> Any:
        j, c, k = (v[f"{name}.{of}"] for of in ("inertia", "damping", "stiffness"))
        rows = [[0.0, 1.0, 0.0], [-k / j, -c / j, 1.0 / j], [0.0, 0.0, 0.0]]
        held = scipy.linalg.expm(np.array(rows) / RATE)[:2]
        return list(held @ np.array([*x, v[f"{name}_force.gain"] * u]))

    return Element(
        name, f"{name}_force.input", f"{name}.angle",
        f'[blocks.{name}]\nkind = "FlexurePendulum"\n'
        f'[blocks.{name}_force]\nkind = "Gain"\noutput_unit = "N*m"\n{_rate(1)}',  # held, also after another flexure
        {f"{name}.inertia": inertia, f"{name}.damping": damping, f"{name}.stiffness": stiffness,
         f"{name}_force.gain": gain}, 2,
        lambda v, x, u: x[0], update, wires=[f"{name}_force.output -> {name}.torque"],
    )  # fmt: skip


def pid(name: str, draw: random.Random, every: int) -> Element:
    t = every / RATE

    def parts(v: Values, x: Any, u: Any) -> tuple[Any, Any]:
        pole = math.exp(-2.0 * math.pi * v[f"{name}.derivative_pole"] * t)
        slope = v[f"{name}.derivative_gain"] * (1.0 - pole) / t
        return x[0] + v[f"{name}.integral"] * t * u, pole * x[1] + slope * (u - x[2])

    values = {
        "proportional": draw.uniform(0.2, 1.2),
        "integral": draw.uniform(0.5, 20.0),
        "derivative_gain": draw.uniform(0.1, 3.0) * 1e-3,
        "derivative_pole": draw.uniform(30.0, 200.0),
    }
    return Element(
        name, f"{name}.error", f"{name}.output", f'[blocks.{name}]\nkind = "PID"\n{_rate(every)}',
        {f"{name}.{key}": value for key, value in values.items()}, 3,
        lambda v, x, u: v[f"{name}.proportional"] * u + sum(parts(v, x, u)),
        lambda v, x, u: [*parts(v, x, u), u], through=True, every=every,
    )  # fmt: skip


@dataclass
class Loop:
    """A random loop, opened behind its gain."""

    elements: list[Element]
    values: dict[str, float]
    tolerances: dict[str, float]  # relative

    @property
    def ticks(self) -> int:
        """Base ticks of a period."""
        return math.lcm(*(element.every for element in self.elements))

    def graph(self, noisy: bool = False) -> Graph:
        """Return the loop as a graph, with numbers of variance one added behind its gain if it is `noisy`."""
        chain = [*self.elements]
        wires = ["minus.output -> gain.input", *(wire for element in chain for wire in element.wires)]
        ends = ["mixed.output" if noisy else "gain.output", *(element.last for element in chain)]
        starts = [*(element.first for element in chain), "minus.input"]
        wires += [f"{a} -> {b}" for a, b in zip(ends, starts, strict=True)]
        wires += ["gain.output -> mixed.first", "hiss.output -> mixed.second"] if noisy else []
        parameters: dict[str, float] = dict(self.values)
        pairs = ", ".join(f'"{wire}"' for wire in wires)
        unit = 'unit = "rad"\n' if self.elements[-1].last.endswith("angle") else ""
        text = f'name = "loop"\nrate = "{RATE} Hz"\nsamples = 64\nwires = [{pairs}]\nprobes = ["gain.output"]\n'
        text += '[loops.main]\nopen_at = "gain.output"\n'
        text += f'[blocks.minus]\nkind = "Negation"\n{unit}[blocks.gain]\nkind = "Gain"\n'
        text += 'input_unit = "rad"\noutput_unit = "1"\n' if unit else ""
        text += "".join(element.text for element in chain)
        if noisy:
            density = math.sqrt(2.0 / RATE)
            text += f'[blocks.mixed]\nkind = "Sum"\n[blocks.hiss]\nkind = "WhiteNoise"\ndensity = {density!r}\n'
        return read_graph_text(text).with_parameters(parameters)

    def matrix(self, values: Values, factor: complex = 1.0) -> Any:
        """Return what a period does to all that is kept from tick to tick, with a factor at the wire."""
        size = sum(element.size + 1 for element in self.elements)
        return np.array([self._period(values, factor, row) for row in np.eye(size)], dtype=complex).T

    def scale_factor(self, values: Values, name: str) -> float:
        """Return what the output of an element settles to, on average, for one added to the wire behind the gain."""
        a, b, c, d = self._pushed(values, name)
        settled = np.linalg.solve(np.eye(len(a)) - a, b.sum(axis=1))
        return float(np.mean(c @ settled + d.sum(axis=1)))

    def peak(self, values: Values, name: str, count: int = 3000) -> float:
        """Return the largest gain at some frequencies from what is added to the wire to the output of an element.

        What comes out at the frequency that goes in: of the period's values those of the output are later by i T / r.
        """
        a, b, c, d = self._pushed(values, name)
        out, into = len(c), b.shape[1]
        turns = np.concatenate([[0.0], np.geomspace(1e-4, 0.5 * min(out, into), count)])  # of a period
        h = np.array([c @ np.linalg.solve(np.exp(2j * np.pi * f) * np.eye(len(a)) - a, b) + d for f in turns])
        after, before = (np.exp(2j * np.pi * np.outer(turns, np.arange(n)) / n) for n in (out, into))
        return float(np.max(np.abs(np.einsum("fi,fik,fk->f", after.conj(), h, before)))) / out

    def rms(self, values: Values, name: str) -> float:
        """Return the rms of the output of an element, for independent numbers of variance one added to the wire."""
        a, b, c, d = self._pushed(values, name)
        covariance = scipy.linalg.solve_discrete_lyapunov(a, b @ b.T)
        return math.sqrt(float(np.trace(c @ covariance @ c.T) + np.sum(d**2)) / len(c))

    def _pushed(self, values: Values, name: str) -> tuple[Any, Any, Any, Any]:
        """Return the map of a period from what is added to the wire in each tick to the outputs of an element."""
        size = sum(element.size + 1 for element in self.elements)
        columns = []
        for row in np.eye(size + self.ticks):
            put_out: list[tuple[str, Any]] = []
            after = self._period(values, 1.0, row[:size], row[size:], put_out)
            columns.append([*after, *(value for of, value in put_out if of == name)])
        whole = np.array(columns, dtype=float).T
        return whole[:size, :size], whole[:size, size:], whole[size:, :size], whole[size:, size:]

    def _period(self, values: Values, factor: complex, memory: Any, push: Any = None, put_out: Any = None) -> list[Any]:
        """Return the memory after a period, with numbers added to the wire; `put_out` takes all outputs."""
        states, held, place = {}, {}, 0
        for element in self.elements:
            states[element.name] = list(memory[place : place + element.size])
            held[element.name] = memory[place + element.size]
            place += element.size + 1
        for tick in range(self.ticks):
            wire: Any = None
            inputs: Any = None
            given: dict[str, Any] = {}
            ordered = self.elements  # the first puts out its state alone: from there all others follow
            for place, element in enumerate(ordered):
                inputs = wire
                if tick % element.every == 0:
                    held[element.name] = element.output(values, states[element.name], inputs)
                    if put_out is not None:
                        put_out.append((element.name, held[element.name]))
                if place:
                    given[element.name] = inputs
                wire = held[element.name]
            given[ordered[0].name] = -wire * values["gain.gain"] * factor + (0.0 if push is None else push[tick])
            for element in ordered:
                if tick % element.every == 0:
                    states[element.name] = list(element.update(values, states[element.name], given[element.name]))
        return [number for element in self.elements for number in (*states[element.name], held[element.name])]

    def gain(self, values: Values, angles: Any) -> Any:
        """Return L(z) at z = exp(j angle), with 1 + L = 0 at a pole: its polynomial is linear in factors.

        That holds where the wire has one value in a period.
        """
        ends = [np.linalg.eigvals(self.matrix(values, factor)) for factor in (0.0, 1.0)]
        opened, closed = (np.prod(np.exp(1j * angles)[:, None] - poles, axis=1) for poles in ends)
        return closed / opened - 1.0

    def delay_margin(self, values: Values) -> float:
        """Return the least delay in s that puts a pole of a stable loop on the circle: exp(-j w m) L = -1."""
        angles = np.geomspace(1e-5, math.pi, 3000)
        sizes = np.log(np.abs(self.gain(values, angles)))
        delays = [math.inf]
        for place in np.flatnonzero(np.diff(np.sign(sizes))):
            angle: Any = scipy.optimize.brentq(
                lambda w: math.log(abs(self.gain(values, np.array([w]))[0])),
                angles[place],
                angles[place + 1],
                xtol=1e-14,
            )
            turn = float(np.angle(-self.gain(values, np.array([angle]))[0])) % (2.0 * math.pi)
            delays.append(turn / angle * self.ticks / RATE)
        return min(delays)

    def disk_margin(self, values: Values) -> float:
        """Return 2 / max |(1 - L) / (1 + L)| of a stable loop: peaks are as narrow as poles near the circle."""
        poles = np.linalg.eigvals(self.matrix(values))
        near = np.angle(poles) + (1.0 - np.abs(poles)) * np.linspace(-3.0, 3.0, 121)[:, None]
        w = np.concatenate([np.geomspace(1e-5, math.pi, 3000), near.ravel()])
        gain = self.gain(values, w[(w >= 1e-5) & (w <= math.pi)])
        return 2.0 / float(np.max(np.abs((1.0 - gain) / (1.0 + gain))))

    def decay_rate(self, values: Values) -> float:
        """Return the rate in 1/s at which the slowest pole decays."""
        return -math.log(self.radius(values)) * RATE / self.ticks

    def radius(self, values: Values, factor: complex = 1.0) -> float:
        """Return the size of the largest pole over a period."""
        return float(max(abs(np.linalg.eigvals(self.matrix(values, factor)))))


def random_loop(seed: int) -> Loop:
    """Return a loop of order 1 to 6 with one to five parameters within tolerances, stable or not or borderline."""
    draw = random.Random(seed)
    rates = draw.choice(((1,), (1,), (1, 2), (1, 3)))
    elements = [draw.choice((integrator, leak, delay))("first", draw, draw.choice(rates))]
    room = draw.randint(1, 6) - elements[0].size
    for name in ("second", "third", "fourth"):
        made = draw.choice((integrator, leak, delay, flexure, pid))(name, draw, draw.choice(rates))
        if made.size <= room:
            elements.append(made)
            room -= made.size
    values = {"gain.gain": 1.0} | {key: value for element in elements for key, value in element.values.items()}
    loop = Loop(elements, values, {})
    values["gain.gain"] = largest_gain(loop) * draw.choice((0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0 - 1e-5, 1.2))
    chosen = draw.sample(sorted(values), min(len(values), draw.randint(1, 5)))
    width = draw.choice((0.01, 0.03, 0.1, 0.2))
    loop.tolerances = dict.fromkeys(chosen, width)
    return loop


def largest_gain(loop: Loop) -> float:
    """Return the largest gain below which the loop is stable, or one half where there is none."""
    gains = [1e-3 * 1.2**place for place in range(60)]
    stable = [loop.radius(loop.values | {"gain.gain": gain}) < 1.0 - 1e-9 for gain in gains]
    last = max((place for place in range(59) if stable[place] and not stable[place + 1]), default=None)
    if last is None:
        return 0.5
    low, high = gains[last], gains[last + 1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if loop.radius(loop.values | {"gain.gain": middle}) < 1.0 else (low, middle)
    return low
