"""The exact hold against mpmath and closed forms."""

import math
import random

import mpmath
import pytest

from proofmass.runner.continuous.exact_hold import SCRATCH, hold, matrix_exponential, multiply, multiply_arrays


def reference(a: list[list[float]], b: list[list[float]], period: float) -> tuple[list[list[float]], list[list[float]]]:
    """exp([[A, B], [0, 0]] T) with 50 digits."""
    n, m = len(a), len(b[0])
    with mpmath.workdps(50):
        joined = mpmath.zeros(n + m, n + m)
        for i in range(n):
            for j, value in enumerate((*a[i], *b[i])):
                joined[i, j] = mpmath.mpf(value) * mpmath.mpf(period)
        result = mpmath.expm(joined)
        return (
            [[float(result[i, j]) for j in range(n)] for i in range(n)],
            [[float(result[i, n + j]) for j in range(m)] for i in range(n)],
        )


@pytest.mark.parametrize("quality", [0.35257, 0.46499, 0.5, 0.7, 44.5, 1e5], ids=lambda q: f"Q={q}")
def test_mass_spring_damper_in_all_damping_regimes(quality: float) -> None:
    dice = random.Random(quality)
    for _ in range(25):
        mass, frequency = 10.0 ** dice.uniform(-9, 0), 10.0 ** dice.uniform(0, 5)
        stiffness = mass * frequency**2
        damping = mass * frequency / quality
        period = 10.0 ** dice.uniform(-3, 0.3) / frequency
        a, b = [[0.0, 1.0], [-stiffness / mass, -damping / mass]], [[0.0], [1.0 / mass]]
        for found, expected in zip(hold(a, b, period), reference(a, b, period), strict=True):
            size = [max(abs(v) for v in row) for row in expected]
            for row, right, largest in zip(found, expected, size, strict=True):
                assert row == pytest.approx(right, rel=1e-12, abs=1e-14 * largest)


@pytest.mark.exhaustive
def test_random_systems_up_to_order_twelve() -> None:
    dice = random.Random(1)
    for order in range(1, 13):
        for _ in range(3):
            scale = [10.0 ** dice.uniform(-6, 6) for _ in range(order)]
            a = [[dice.gauss(0, 1) * scale[i] / scale[j] for j in range(order)] for i in range(order)]
            b = [[dice.gauss(0, 1) * scale[i] for _ in range(2)] for i in range(order)]
            transition, entry = hold(a, b, 0.3)
            right, right_entry = reference(a, b, 0.3)
            for i in range(order):
                for j in range(order):
                    assert abs(transition[i][j] - right[i][j]) < 1e-12 * scale[i] / scale[j]
                for j in range(2):
                    assert abs(entry[i][j] - right_entry[i][j]) < 1e-12 * scale[i]


def spread(order: int, dice: random.Random, kind: str) -> tuple[list[list[float]], list[float]]:
    """A system with rates over six decades, or without damping, and the units of its states, of different size."""
    a = [[0.0] * order for _ in range(order)]
    for i in range(order):
        if kind == "stiff":
            a[i][i] = -(10.0 ** dice.uniform(-3, 3))
            for j in range(i):
                a[i][j] = dice.gauss(0, 1) * math.sqrt(a[i][i] * a[j][j])
        elif i % 2:
            a[i - 1][i] = 10.0 ** dice.uniform(0, 1.5)
            a[i][i - 1] = -a[i - 1][i]
    scale = [2.0 ** dice.randint(-20, 20) for _ in range(order)]
    return [[a[i][j] * scale[i] / scale[j] for j in range(order)] for i in range(order)], scale


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", ["stiff", "undamped"])
def test_stiff_and_undamped_systems_up_to_order_twelve(kind: str) -> None:
    dice = random.Random(kind)
    for order in range(1, 13):
        a, scale = spread(order, dice, kind)
        b = [[dice.gauss(0, 1) * size] for size in scale]
        (transition, entry), (right, right_entry) = hold(a, b, 0.7), reference(a, b, 0.7)
        for i in range(order):
            assert abs(entry[i][0] - right_entry[i][0]) <= 1e-11 * max(abs(right_entry[i][0]), scale[i])
            for j in range(order):
                assert abs(transition[i][j] - right[i][j]) <= 1e-11 * max(abs(right[i][j]), scale[i] / scale[j])


@pytest.mark.parametrize("size", [1e-200, 1e-100, 1.0, 1e100, 1e200])
def test_an_oscillation_whose_states_have_units_far_apart(size: float) -> None:
    """x' = v / size, v' = size (u - x): x turns into 1 - cos t, v into size sin t. Before them a state stands still."""
    transition, entry = hold([[0.0] * 3, [0.0, 0.0, 1.0 / size], [0.0, -size, 0.0]], [[0.0], [0.0], [size]], 0.7)
    cosine, sine = math.cos(0.7), math.sin(0.7)
    assert transition[0] == [1.0, 0.0, 0.0]
    assert transition[1] == pytest.approx([0.0, cosine, sine / size], rel=1e-15, abs=0.0)
    assert transition[2] == pytest.approx([0.0, -sine * size, cosine], rel=1e-15, abs=0.0)
    assert [row[0] for row in entry] == pytest.approx([0.0, 1.0 - cosine, sine * size], rel=1e-15, abs=0.0)


def test_two_steps_are_one_of_twice_the_length() -> None:
    a, b = [[0.0, 1.0], [-9.828e8, -6.742e4]], [[0.0], [1.983e7]]
    once, _ = hold(a, b, 1e-5)
    twice, _ = hold(a, b, 2e-5)
    product = [[sum(once[i][k] * once[k][j] for k in range(2)) for j in range(2)] for i in range(2)]
    for row, expected in zip(product, twice, strict=True):
        assert row == pytest.approx(expected, rel=1e-12)


def exponential(rows: list[list[float]]) -> list[list[float]]:
    size = len(rows)
    flat = [value for row in rows for value in row]
    grown, square, scale = ([0.0] * (size * size) for _ in range(SCRATCH))
    matrix_exponential(flat, size, grown, square, scale, multiply)
    return [flat[i * size : (i + 1) * size] for i in range(size)]


def test_exponential_of_nothing_and_of_zero() -> None:
    assert exponential([]) == []
    assert exponential([[0.0, 0.0], [0.0, 0.0]]) == [[1.0, 0.0], [0.0, 1.0]]
    assert exponential([[0.0, 1.0], [0.0, 0.0]]) == [[1.0, 1.0], [0.0, 1.0]]


@pytest.mark.parametrize("broken", [0.0, math.inf, math.nan])
def test_products_by_numpy_have_the_same_bits(broken: float) -> None:
    """Dense, sparse and triangular matrices, of numbers of any size, one of them not finite."""
    dice = random.Random(5)
    for size in (1, 2, 7, 30):
        for share in (0.1, 1.0):
            left, right = (
                [
                    dice.gauss(0, 1) * 10.0 ** dice.uniform(-9, 9) if dice.random() < share else 0.0
                    for _ in range(size**2)
                ]
                for _ in range(2)
            )
            left[dice.randrange(size**2)] = broken
            right[dice.randrange(size**2)] = broken
            products = [0.0] * size**2, [0.0] * size**2
            multiply(left, right, size, products[0])
            multiply_arrays(left, right, size, products[1])
            assert list(map(repr, products[0])) == list(map(repr, products[1]))
            sums = [
                math.fsum(left[i * size + k] * right[k * size + j] for k in range(size))
                for i in range(size)
                for j in range(size)
            ]
            if not broken:
                largest = max(map(abs, sums), default=0.0)
                assert products[0] == pytest.approx(sums, rel=0.0, abs=1e-14 * size * max(largest, 1e-300))
