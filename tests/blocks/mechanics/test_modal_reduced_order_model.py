"""A chain of masses against scipy's matrix exponential, its modes against scipy's eigenvalues, and truncation."""

from typing import Any

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import ModalReducedOrderModel
from proofmass.blocks.arithmetic.modes import lowest_modes, rows
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive
from tests.by_hand.responses import distance

SIZE, PERIOD = 6, 3e-5


def structure(seed: int = 1) -> tuple[np.ndarray, ...]:
    """M and K full, symmetric and positive definite, a damping that couples the modes, and two ports each way."""
    dice = np.random.default_rng(seed)
    spread = dice.normal(size=(SIZE, SIZE))
    mass = 1e-8 * (spread @ spread.T / SIZE + np.eye(SIZE))
    chain = 2.0 * np.eye(SIZE) - np.eye(SIZE, k=1) - np.eye(SIZE, k=-1)
    damping = 2e-7 * (chain + np.diag(dice.uniform(0.0, 2.0, SIZE)))
    return mass, damping, 3.0 * chain, dice.normal(size=(SIZE, 2)), dice.normal(size=(2, SIZE))


def block(**changes: Any) -> ModalReducedOrderModel:
    names = ("mass", "damping", "stiffness", "entry", "readout")
    values = {name: matrix.ravel().tolist() for name, matrix in zip(names, structure(), strict=True)}
    return ModalReducedOrderModel(**{**values, "input_size": 2, "output_size": 2, **changes})


def test_all_modes_against_the_matrix_exponential() -> None:
    m, c, k, b, r = structure()
    inverse, zero, one = np.linalg.inv(m), np.zeros((SIZE, SIZE)), np.eye(SIZE)
    a = np.block([[zero, one], [-inverse @ k, -inverse @ c]])
    big = np.zeros((2 * SIZE + 2, 2 * SIZE + 2))
    big[: 2 * SIZE, : 2 * SIZE], big[SIZE : 2 * SIZE, 2 * SIZE :] = a, inverse @ b
    step = linalg.expm(big * PERIOD)
    forces = np.random.default_rng(2).normal(size=(150, 2)) * 1e-6
    x, expected, speeds = np.zeros(2 * SIZE), [], []
    for f in forces:
        expected.append(r @ x[:SIZE])
        speeds.append(r @ x[SIZE:])
        x = step[: 2 * SIZE, : 2 * SIZE] @ x + step[: 2 * SIZE, 2 * SIZE :] @ f
    found = drive(block(modes=SIZE), [{"force": f.tolist()} for f in forces], PERIOD)
    assert distance([row["displacement"] for row in found], expected) < 1e-10
    assert distance([row["velocity"] for row in found], speeds) < 1e-10


def test_a_single_mode_is_a_damped_oscillation() -> None:
    """A force of 1 from tick 0 on a mass of 2, a damping of 0.4 and a spring of 8: x = (1 - e^(-0.1 t) (...)) / 8."""
    model = ModalReducedOrderModel(mass=(2.0,), damping=(0.4,), stiffness=(8.0,), entry=(1.0,), readout=(1.0,), modes=1)
    found = [row["displacement"][0] for row in drive(model, [{"force": [1.0]}] * 40, 0.1)]
    t, decay, rate = np.arange(40) * 0.1, 0.1, np.sqrt(4.0 - 0.01)
    expected = (1.0 - np.exp(-decay * t) * (np.cos(rate * t) + decay / rate * np.sin(rate * t))) / 8.0
    assert found == pytest.approx(expected, abs=1e-13)


def test_modes_against_scipy() -> None:
    m, c, k, _, _ = structure()
    squares, vectors = linalg.eigh(k, m)
    modes = lowest_modes(
        rows(m.ravel().tolist(), SIZE), rows(c.ravel().tolist(), SIZE), rows(k.ravel().tolist(), SIZE), 3
    )
    assert modes.rates == pytest.approx(np.sqrt(squares[:3]), rel=1e-11)
    shapes = np.array(modes.shapes)
    assert np.abs(shapes.T @ m @ vectors[:, :3]) == pytest.approx(np.eye(3), abs=1e-9)
    assert shapes.T @ c @ shapes == pytest.approx(np.array(modes.damping), rel=1e-12, abs=1e-9)


def test_two_modes_rest_where_two_modes_do() -> None:
    """A constant force: the sum over the modes that count of shape shape^T / w^2."""
    m, _, k, b, r = structure()
    squares, vectors = linalg.eigh(k, m)
    low = vectors[:, :2]
    expected = r @ low @ np.diag(1.0 / squares[:2]) @ low.T @ b @ [1e-6, 0.0]
    found = drive(block(modes=2), [{"force": [1e-6, 0.0]}] * 4000, 1e-3)[-1]["displacement"]
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"mass": (1.0,) * 5}, "n by n numbers"),
        ({"damping": (1.0,)}, "36 numbers, as mass is 6 by 6"),
        ({"modes": 7}, "at most 6, as mass is 6 by 6"),
        ({"stiffness": tuple(np.diag([1.0] * 5 + [0.0]).ravel())}, "held everywhere"),
    ],
)
def test_what_is_no_structure_is_refused(changes: dict[str, Any], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        block(**changes)


@pytest.mark.derivation(
    ModalReducedOrderModel,
    equation="M x'' + C x' + K x = B F, y = R x, by the lowest modes",
    source="closed form of a chain of equal masses between walls: w_k = 2 sqrt(k / m) sin(k pi / (2 n + 2))",
    convention="shapes of modal mass 1; a step of F moves a point by twice its rest without damping",
)
def test_a_chain_of_equal_masses_between_walls() -> None:
    """Mass 2 is pushed and mass 4 is read: sum over k of 2 / (n + 1) sin sin (1 - cos w_k t) / (m w_k^2)."""
    size, mass, spring, period = 5, 4e-9, 1.5, 7e-6
    chain = spring * (2.0 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    rod = ModalReducedOrderModel(
        mass=(mass * np.eye(size)).ravel().tolist(),
        damping=[0.0] * size**2,
        stiffness=chain.ravel().tolist(),
        entry=[0.0, 1.0, 0.0, 0.0, 0.0],
        readout=[0.0, 0.0, 0.0, 1.0, 0.0],
        modes=size,
    )
    k, t = np.arange(1, size + 1), np.arange(60)[:, None] * period
    w = 2.0 * np.sqrt(spring / mass) * np.sin(k * np.pi / (2 * size + 2))
    shapes = 2.0 / (size + 1) * np.sin(2 * k * np.pi / (size + 1)) * np.sin(4 * k * np.pi / (size + 1))
    expected = 1e-6 * (shapes * (1.0 - np.cos(w * t)) / (mass * w**2)).sum(axis=1)
    found = drive(rod, [{"force": [1e-6]}] * 60, period)
    assert distance([row["displacement"][0] for row in found], expected) < 1e-10
