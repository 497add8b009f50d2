"""Proofs beside robust stability that others have published: Kharitonov's polynomials, de Gaston's and Safonov's servo.

And beside the structured singular value of slycot, which never goes beyond the true margin either.
"""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from proofmass.blocks import Difference, Gain, Integrator, Negation
from proofmass.graphs.model.build import Graph
from proofmass.runner.design.proof.prove import prove

Matrix = np.ndarray[tuple[int, int], np.dtype[np.float64]]


def status(graph: Graph, **parameters: tuple[float, float]) -> str:
    """What comes of the claim that a loop is stable with gains of blocks between two numbers each."""
    within: dict[str, Any] = {f"{name}.gain": [str(low), str(high)] for name, (low, high) in parameters.items()}
    return prove(graph, tolerances=within, workers=1).proofs[0].status


def interval_loop() -> Graph:
    """s^3 + a s^2 + b s + c: x'' = -a x' - b x - c y and y' = x, opened at the last."""
    blocks = {
        "y": Integrator(output_unit="1"),
        "x": Integrator(output_unit="1"),
        "v": Integrator(output_unit="1"),
        "a": Gain(gain=2.0),
        "b": Gain(gain=3.0),
        "c": Gain(gain=2.0),
        "damped": Difference(),
        "sprung": Difference(),
        "back": Negation(),
    }
    wires = ["v.output -> x.input", "x.output -> y.input", "v.output -> a.input", "x.output -> b.input"]
    wires += ["y.output -> c.input", "c.output -> back.input", "back.output -> damped.first"]
    wires += ["a.output -> damped.second", "damped.output -> sprung.first", "b.output -> sprung.second"]
    wires += ["sprung.output -> v.input"]
    loops = {"main": {"open_at": "c.output"}}
    return Graph(name="intervals", rate="1 kHz", samples=10, blocks=blocks, wires=wires, loops=loops)


@pytest.mark.exhaustive("0.9")
@pytest.mark.parametrize(("part", "expected"), [(0.9, "proved"), (0.99, "proved"), (1.01, "refuted")])
def test_an_interval_polynomial_of_third_order(part: float, expected: str) -> None:
    """Kharitonov, Differential Equations 14, 1979, 1483: one of its four polynomials is the worst, a b = c with the
    least a and b and the largest c. Of 2, 3 and 2, within a part r each, 6 (1 - r)^2 = 2 (1 + r) at r = 1 / 3.
    """
    r = part / 3.0
    within = {name: (middle * (1.0 - r), middle * (1.0 + r)) for name, middle in (("a", 2.0), ("b", 3.0), ("c", 2.0))}
    assert status(interval_loop(), **within) == expected


def servo() -> Graph:
    """K (s + 2) / ((s + 10) s (s + p) (s + q)) with feedback of one: z' = -10 z + e, and the controller is e - 8 z."""
    blocks = {
        "error": Negation(),
        "lag": Integrator(output_unit="1"),
        "ten": Gain(gain=10.0),
        "lagging": Difference(),
        "eight": Gain(gain=8.0),
        "controller": Difference(),
        "k": Gain(gain=800.0),
        "p": Gain(gain=4.0),
        "q": Gain(gain=6.0),
        "fast": Integrator(output_unit="1"),
        "into_fast": Difference(),
        "slow": Integrator(output_unit="1"),
        "into_slow": Difference(),
        "angle": Integrator(output_unit="1"),
    }
    wires = ["angle.output -> error.input", "error.output -> lagging.first", "lag.output -> ten.input"]
    wires += ["ten.output -> lagging.second", "lagging.output -> lag.input", "lag.output -> eight.input"]
    wires += ["error.output -> controller.first", "eight.output -> controller.second", "controller.output -> k.input"]
    wires += ["k.output -> into_fast.first", "fast.output -> q.input", "q.output -> into_fast.second"]
    wires += ["into_fast.output -> fast.input", "fast.output -> into_slow.first", "slow.output -> p.input"]
    wires += ["p.output -> into_slow.second", "into_slow.output -> slow.input", "slow.output -> angle.input"]
    loops = {"main": {"open_at": "k.output"}}
    return Graph(name="servo", rate="10 kHz", samples=10, blocks=blocks, wires=wires, loops=loops)


def servo_within(size: float) -> str:
    """What comes of K = 800 + 80 d, p = 4 + 0.2 d and q = 6 + 0.3 d, each d within a size."""
    widths = {"k": (800.0, 80.0), "p": (4.0, 0.2), "q": (6.0, 0.3)}
    return status(servo(), **{name: (at - size * by, at + size * by) for name, (at, by) in widths.items()})


def unstable_by(size: float) -> float:
    """Return the growth of the fastest mode at the corner of the largest gain and the slowest poles."""
    k, p, q = 800.0 + 80.0 * size, 4.0 - 0.2 * size, 6.0 - 0.3 * size
    polynomial = np.polymul(np.polymul([1.0, 10.0], [1.0, 0.0]), np.polymul([1.0, p], [1.0, q]))
    return float(np.max(np.roots(np.polyadd(polynomial, [k, 2.0 * k])).real))


MARGIN = 3.4174  # de Gaston and Safonov, IEEE Transactions on Automatic Control 33, 1988, 156


def test_the_margin_that_is_published_is_that_of_its_corner() -> None:
    assert brentq(unstable_by, 1.0, 10.0) == pytest.approx(MARGIN, abs=1e-4)


@pytest.mark.exhaustive("0.99")
@pytest.mark.parametrize(("part", "expected"), [(0.9, "proved"), (0.99, "proved"), (1.01, "refuted")])
def test_a_servo_of_three_uncertain_parameters(part: float, expected: str) -> None:
    assert servo_within(part * MARGIN) == expected


@pytest.mark.exhaustive
def test_what_the_structured_singular_value_proves_is_proved() -> None:
    """det(1 - D M) of D = diag(d), M = C (s - A)^-1 B. Its bound for real d is 1 over the margin at the crossing."""
    slycot = pytest.importorskip("slycot")
    a: Matrix = np.array([[-10.0, 0, 0, -1], [-6400, -6, 0, -800], [0, 1, -4, 0], [0, 0, 1, 0]])
    b: Matrix = np.array([[0.0, 0, 0], [80, 0, -0.3], [0, -0.2, 0], [0, 0, 0]])
    c: Matrix = np.array([[-8.0, 0, 0, -1], [0, 0, 1, 0], [0, 1, 0, 0]])

    def bound(w: float) -> float:
        m = c @ np.linalg.solve(1j * w * np.eye(4) - a, b.astype(complex))
        return float(slycot.ab13md(m, [1] * 3, [1] * 3)[0])

    largest = max(bound(float(w)) for w in (*np.geomspace(0.1, 100.0, 200), *np.linspace(8.2, 8.3, 201)))
    assert 0.99 * MARGIN < 1.0 / largest < 1.002 * MARGIN  # between frequencies it may be a little larger
    assert servo_within(0.99 / largest) == "proved"
