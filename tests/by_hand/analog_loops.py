"""Random loops among continuous blocks, with tolerances: as graphs, and as x' = A x + b u, y = c x written by hand.

A loop is a chain: minus, a gain, some elements, and back.

    integrator   x' = g u, y = x
    leak         x' = g (u - b x), y = x: an integrator with a gain about it
    low pass     x' = 2 pi f (g u - x), y = x
    mass         m v' + c v + k x = g u, x' = v, y = x
    PI           x' = g u, y = x + p u
    lead         x' = 2 pi f (u - x), y = u + d (u - x)
    notch        m v' + c v + k x = u, x' = v, y = u - (c - e) v: zeros have the damping e, poles have c
    unstable     x' = g (u + b x), y = x
"""

import itertools
import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.host.arrays import Array

Values = Mapping[str, float]
Matrices = tuple[Array, Array, Array, float]


@dataclass
class Element:
    """An element of the chain: its blocks as TOML, its wires, and its matrices."""

    first: str  # the input of its first block
    last: str  # its output
    text: str
    values: dict[str, float]
    matrices: Callable[[Values], Matrices]  # A, b, c and d
    wires: tuple[str, ...] = ()


def _of(a: list[list[float]], b: list[float], c: list[float], d: float = 0.0) -> Matrices:
    return np.array(a), np.array(b), np.array(c), d


def _blocks(kinds: Mapping[str, str]) -> str:
    return "".join(f'[blocks.{name}]\nkind = "{kind}"\n' for name, kind in kinds.items())


def integrator(n: str, draw: random.Random) -> Element:
    text = f'[blocks.{n}]\nkind = "Integrator"\noutput_unit = "1"\n'
    values = {f"{n}.gain": draw.uniform(1.0, 40.0)}
    return Element(f"{n}.input", f"{n}.output", text, values, lambda v: _of([[0.0]], [v[f"{n}.gain"]], [1.0]))


def leak(n: str, draw: random.Random) -> Element:
    kinds = {f"{n}_in": "Difference", f"{n}_back": "Gain", n: "Integrator"}
    text = _blocks(kinds) + 'output_unit = "1"\n'
    return Element(
        f"{n}_in.first", f"{n}.output", text,
        {f"{n}.gain": draw.uniform(2.0, 40.0), f"{n}_back.gain": draw.uniform(0.5, 3.0)},
        lambda v: _of([[-v[f"{n}.gain"] * v[f"{n}_back.gain"]]], [v[f"{n}.gain"]], [1.0]),
        (f"{n}_in.output -> {n}.input", f"{n}.output -> {n}_back.input", f"{n}_back.output -> {n}_in.second"),
    )  # fmt: skip


def low_pass(n: str, draw: random.Random) -> Element:
    text = f'[blocks.{n}]\nkind = "LowPass"\n'
    values = {f"{n}.corner_frequency": draw.uniform(0.5, 30.0), f"{n}.gain": draw.uniform(0.5, 2.0)}

    def matrices(v: Values) -> Matrices:
        w = 2.0 * math.pi * v[f"{n}.corner_frequency"]
        return _of([[-w]], [w * v[f"{n}.gain"]], [1.0])

    return Element(f"{n}.input", f"{n}.output", text, values, matrices)


def mass(n: str, draw: random.Random) -> Element:
    w, damping = draw.uniform(5.0, 60.0), draw.uniform(0.1, 0.9)
    text = f'[blocks.{n}]\nkind = "MassSpringDamper"\n[blocks.{n}_force]\nkind = "Gain"\noutput_unit = "N"\n'
    text += f'[blocks.{n}_out]\nkind = "Gain"\ninput_unit = "m"\n'
    values = {
        f"{n}.mass": 1.0, f"{n}.stiffness": w * w, f"{n}.damping": 2.0 * damping * w,
        f"{n}_force.gain": w * w * draw.uniform(0.5, 1.5),
    }  # fmt: skip

    def matrices(v: Values) -> Matrices:
        m, k, c = (v[f"{n}.{name}"] for name in ("mass", "stiffness", "damping"))
        return _of([[0.0, 1.0], [-k / m, -c / m]], [0.0, v[f"{n}_force.gain"] / m], [1.0, 0.0])

    wires = f"{n}_force.output -> {n}.force", f"{n}.displacement -> {n}_out.input"
    return Element(f"{n}_force.input", f"{n}_out.output", text, values, matrices, wires)


def proportional_integral(n: str, draw: random.Random) -> Element:
    kinds = {f"{n}_in": "Gain", f"{n}_part": "Gain", f"{n}_sum": "Sum", n: "Integrator"}
    part = draw.uniform(0.3, 2.0)
    return Element(
        f"{n}_in.input", f"{n}_sum.output", _blocks(kinds) + 'output_unit = "1"\n',
        {f"{n}.gain": part * draw.uniform(0.5, 10.0), f"{n}_part.gain": part},
        lambda v: _of([[0.0]], [v[f"{n}.gain"]], [1.0], v[f"{n}_part.gain"]),
        (
            f"{n}_in.output -> {n}.input", f"{n}_in.output -> {n}_part.input",
            f"{n}.output -> {n}_sum.first", f"{n}_part.output -> {n}_sum.second",
        ),
    )  # fmt: skip


def lead(n: str, draw: random.Random) -> Element:
    kinds = {f"{n}_in": "Gain", f"{n}_high": "Difference", f"{n}_part": "Gain", f"{n}_sum": "Sum", n: "LowPass"}

    def matrices(v: Values) -> Matrices:
        w, d = 2.0 * math.pi * v[f"{n}.corner_frequency"], v[f"{n}_part.gain"]
        return _of([[-w]], [w], [-d], 1.0 + d)

    return Element(
        f"{n}_in.input", f"{n}_sum.output", _blocks(kinds),
        {f"{n}.corner_frequency": draw.uniform(3.0, 30.0), f"{n}_part.gain": draw.uniform(1.0, 8.0)}, matrices,
        (
            f"{n}_in.output -> {n}.input", f"{n}_in.output -> {n}_high.first", f"{n}.output -> {n}_high.second",
            f"{n}_high.output -> {n}_part.input", f"{n}_in.output -> {n}_sum.first",
            f"{n}_part.output -> {n}_sum.second",
        ),
    )  # fmt: skip


def notch(n: str, draw: random.Random) -> Element:
    w, damping, rest = draw.uniform(20.0, 80.0), draw.uniform(0.3, 0.9), draw.uniform(0.0, 0.2)
    kinds = {f"{n}_in": "Gain", f"{n}_sum": "Difference", n: "MassSpringDamper"}
    text = _blocks(kinds) + f'[blocks.{n}_force]\nkind = "Gain"\noutput_unit = "N"\n'
    text += f'[blocks.{n}_out]\nkind = "Gain"\ninput_unit = "m/s"\n'
    values = {
        f"{n}.mass": 1.0, f"{n}.stiffness": w * w, f"{n}.damping": 2.0 * damping * w, f"{n}_force.gain": 1.0,
        f"{n}_out.gain": 2.0 * (damping - rest) * w,
    }  # fmt: skip

    def matrices(v: Values) -> Matrices:
        m, k, c = (v[f"{n}.{name}"] for name in ("mass", "stiffness", "damping"))
        return _of([[0.0, 1.0], [-k / m, -c / m]], [0.0, v[f"{n}_force.gain"] / m], [0.0, -v[f"{n}_out.gain"]], 1.0)

    wires = (
        f"{n}_in.output -> {n}_force.input", f"{n}_force.output -> {n}.force", f"{n}.velocity -> {n}_out.input",
        f"{n}_in.output -> {n}_sum.first", f"{n}_out.output -> {n}_sum.second",
    )  # fmt: skip
    return Element(f"{n}_in.input", f"{n}_sum.output", text, values, matrices, wires)


def unstable(n: str, draw: random.Random) -> Element:
    own = leak(n, draw)
    values = {f"{n}.gain": draw.uniform(2.0, 20.0), f"{n}_back.gain": -draw.uniform(0.1, 1.0)}
    return Element(own.first, own.last, own.text, values, own.matrices, own.wires)


@dataclass
class AnalogLoop:
    """A loop opened behind its gain."""

    elements: list[Element]
    values: dict[str, float]
    tolerances: dict[str, float]  # relative

    def graph(self) -> Graph:
        ends = ["gain.output", *(one.last for one in self.elements)]
        starts = [*(one.first for one in self.elements), "minus.input"]
        wires = ["minus.output -> gain.input", *(wire for one in self.elements for wire in one.wires)]
        wires += [f"{a} -> {b}" for a, b in zip(ends, starts, strict=True)]
        listed = ", ".join(f'"{wire}"' for wire in wires)
        text = f'name = "analog"\nrate = "1 kHz"\nsamples = 20\nwires = [{listed}]\nprobes = ["gain.output"]\n'
        text += (
            '[loops.main]\nopen_at = "gain.output"\n[blocks.minus]\nkind = "Negation"\n[blocks.gain]\nkind = "Gain"\n'
        )
        return read_graph_text(text + "".join(one.text for one in self.elements)).with_parameters(self.values)

    def open(self, values: Values) -> tuple[Array, Array, Array]:
        """Return A, b and c from the wire to what comes back there, with its sign."""
        parts = [one.matrices(values) for one in self.elements]
        size = sum(len(a) for a, *_ in parts)
        whole, into = np.zeros((size, size)), np.zeros(size)
        begin, signal, at_once = 0, np.zeros(size), 1.0  # what goes on: of the states, and of the wire
        for a, b, c, d in parts:
            end = begin + len(a)
            whole[begin:end] = np.outer(b, signal)
            whole[begin:end, begin:end] = a
            into[begin:end] = b * at_once
            signal, at_once = d * signal, d * at_once
            signal[begin:end] = c
            begin = end
        assert at_once == 0.0
        return whole, into, -values["gain.gain"] * signal

    def closed(self, values: Values, factor: complex = 1.0) -> Any:
        a, b, c = self.open(values)
        return a + factor * np.outer(b, c)

    def growth(self, values: Values, factor: complex = 1.0) -> float:
        """The largest real part of a pole."""
        return float(np.linalg.eigvals(self.closed(values, factor)).real.max())

    def at(self, place: Mapping[str, float]) -> dict[str, float]:
        """The parameters at a place of the box, -1 to 1 along each side."""
        return self.values | {n: self.values[n] * (1.0 + self.tolerances[n] * part) for n, part in place.items()}


def random_loop(seed: int) -> AnalogLoop:
    draw = random.Random(seed)
    kinds = [draw.choice((integrator, leak, low_pass, mass)) for _ in range(draw.randint(1, 4))]
    elements = [kind(f"e{i}", draw) for i, kind in enumerate(kinds)]
    values = {"gain.gain": draw.uniform(0.2, 1.5)}
    for one in elements:
        values |= one.values
    varied = draw.sample(sorted(values), min(len(values), draw.randint(1, 5)))
    loop = AnalogLoop(elements, values, {name: draw.choice((0.02, 0.05, 0.1, 0.3)) for name in varied})
    while loop.growth(loop.values) > -1e-3 and loop.values["gain.gain"] > 1e-3 and draw.random() < 0.9:
        loop.values["gain.gain"] *= 0.5
    return loop


def control_loop(seed: int) -> AnalogLoop:
    """A plant of second or third order, which may be unstable, with a PI, a lead or a notch: some near their border."""
    draw = random.Random(seed)
    plants = [draw.choice((integrator, unstable, low_pass, mass)), draw.choice((integrator, leak, low_pass))]
    plants = plants[: draw.choice((1, 2, 2))]
    regulators = draw.sample((proportional_integral, lead, notch), draw.choice((1, 1, 2)))
    elements = [kind(f"e{i}", draw) for i, kind in enumerate([*regulators, *plants])]
    values = {"gain.gain": 1.0}
    for one in elements:
        values |= one.values
    some = [name for name in values if values[name] != 1.0 or name == "gain.gain"]
    tolerances = {
        name: draw.choice((0.02, 0.05, 0.1)) for name in draw.sample(some, min(len(some), draw.randint(1, 4)))
    }
    loop = AnalogLoop(elements, values, tolerances)
    gains = [10.0 ** (0.05 * step) for step in range(-40, 41)]
    growth = [loop.growth(values | {"gain.gain": gain}) for gain in gains]
    best = int(np.argmin(growth))
    values["gain.gain"] = gains[best]
    if growth[best] < 0.0 and draw.random() < 0.5:  # one of the corners lies beside the border, or on it
        _to_the_border(loop, draw.choice((1e-2, 1e-4, 1e-7, -1e-7, -1e-4, -1e-2)))
    return loop


def _to_the_border(loop: AnalogLoop, off: float) -> None:
    """Raise the gain until the fastest growth at the corners is as fast as `off`, in units of the gain."""
    places = [
        dict(zip(loop.tolerances, place, strict=True))
        for place in itertools.product((-1.0, 1.0), repeat=len(loop.tolerances))
    ]

    def worst(gain: float) -> float:
        loop.values["gain.gain"] = gain
        return max(loop.growth(loop.at(place)) for place in places)

    low, high = loop.values["gain.gain"], 100.0 * loop.values["gain.gain"]
    if worst(low) < 0.0 < worst(high):
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if worst(middle) < 0.0 else (low, middle)
        loop.values["gain.gain"] = low * (1.0 - off)
