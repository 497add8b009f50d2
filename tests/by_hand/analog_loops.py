"""Random loops among continuous blocks, with tolerances: as graphs, and as x' = A x + b u, y = c x written by hand.

A loop is a chain: minus, a gain, some elements, and back.

    integrator   x' = g u, y = x
    leak         x' = g (u - b x), y = x: an integrator with a gain about it
    low pass     x' = 2 pi f (g u - x), y = x
    mass         m v' + c v + k x = g u, x' = v, y = x
"""

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
Matrices = tuple[Array, Array, Array]


@dataclass
class Element:
    """An element of the chain: its blocks as TOML, its wires, and its matrices."""

    first: str  # the input of its first block
    last: str  # its output
    text: str
    values: dict[str, float]
    matrices: Callable[[Values], Matrices]  # A, b and c
    wires: tuple[str, ...] = ()


def _of(a: list[list[float]], b: list[float], c: list[float]) -> Matrices:
    return np.array(a), np.array(b), np.array(c)


def integrator(n: str, draw: random.Random) -> Element:
    text = f'[blocks.{n}]\nkind = "Integrator"\noutput_unit = "1"\n'
    values = {f"{n}.gain": draw.uniform(1.0, 40.0)}
    return Element(f"{n}.input", f"{n}.output", text, values, lambda v: _of([[0.0]], [v[f"{n}.gain"]], [1.0]))


def leak(n: str, draw: random.Random) -> Element:
    kinds = {f"{n}_in": "Difference", f"{n}_back": "Gain", n: "Integrator"}
    text = "".join(f'[blocks.{name}]\nkind = "{kind}"\n' for name, kind in kinds.items()) + 'output_unit = "1"\n'
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

    def open(self, values: Values) -> Matrices:
        """Return A, b and c from the wire to what comes back there, with its sign."""
        parts = [one.matrices(values) for one in self.elements]
        size = sum(len(a) for a, _, _ in parts)
        whole, into, out = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        begin, before = 0, None
        for a, b, c in parts:
            end = begin + len(a)
            whole[begin:end, begin:end] = a
            if before is None:
                into[begin:end] = b
            else:
                whole[begin:end, before[0] : begin] = np.outer(b, before[1])
            begin, before = end, (begin, c)
        assert before is not None
        out[before[0] :] = -values["gain.gain"] * before[1]
        return whole, into, out

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
