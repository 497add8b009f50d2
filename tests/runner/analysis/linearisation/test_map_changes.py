"""Norms of changed responses by as few numbers as there are states, and how modes turn."""

import math

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.map_changes import ChangedResponse, change_between, variation
from proofmass.runner.analysis.linearisation.period_map import PeriodMap


@pytest.mark.parametrize("changed", ["states", "outputs", "inputs", "direct"])
@pytest.mark.parametrize(("states", "inputs", "outputs"), [(3, 2, 4), (5, 50, 30), (4, 1, 1)])
def test_norms_of_a_changed_response(states: int, inputs: int, outputs: int, changed: str) -> None:
    random = np.random.default_rng(1)
    sizes = (states, states), (states, inputs), (outputs, states), (outputs, inputs)
    before = tuple(random.normal(size=size) * 0.3 for size in sizes)
    after = tuple(part.copy() for part in before)
    z = np.exp(1j * np.array([0.1, 1.0, 3.0]))
    response = ChangedResponse(before, z)
    if changed in ("inputs", "direct"):
        columns, rows = [*range(0, inputs, 2)], [0, 2] if changed == "inputs" else [states + outputs - 1]
        change = random.normal(size=(len(rows), len(columns)))
        both = np.concatenate([after[1], after[3]])
        both[np.ix_(rows, columns)] += change
        after = after[0], both[:states], after[2], both[states:]
        columns = [states + column for column in columns]
    else:
        columns, rows = [*range(states)], [0, 2] if changed == "states" else [states + outputs - 1]
        change = random.normal(size=(len(rows), states))
        both = np.concatenate([after[0], after[2]])
        both[rows] += change
        after = both[:states], after[1], both[states:], after[3]
    size, moved = response.changed(np.array(rows), np.array(columns), change)
    one, two = (
        np.array([c @ np.linalg.solve(at * np.eye(states) - a, b) + d for at in z]) for a, b, c, d in (before, after)
    )
    larger = np.maximum(np.linalg.norm(one, axis=(1, 2)), np.linalg.norm(two, axis=(1, 2)))
    assert size == pytest.approx(larger, rel=1e-12)
    assert moved == pytest.approx(np.linalg.norm(two - one, axis=(1, 2)), rel=1e-11)


def turned(by: float) -> np.ndarray:  # type: ignore[type-arg]
    return np.array([[math.cos(by), -math.sin(by)], [math.sin(by), math.cos(by)]])


def test_modes_that_turn_with_their_orbit_move_by_what_they_turn() -> None:
    """R diag(0.999, 0.5) R' has the same poles, and vectors of a length that stand at the angle of R."""
    angle, closed = 0.02, np.diag([0.999, 0.5])
    seen = variation(closed, [turned(angle) @ closed @ turned(angle).T])
    assert np.sort(seen.poles.real) == pytest.approx([0.5, 0.999])
    assert seen.turns == pytest.approx([1.0 - math.cos(angle)] * 2, rel=1e-6)


def test_changes_that_move_no_pole_near_the_boundary_do_not_count() -> None:
    """An ellipse made flatter: c - s and c + s beside the diagonal leave a rotation its poles, to first order."""
    closed, flatter = 0.9995 * turned(0.3), 1e-3 * np.diag([1.0, -1.0])
    assert float(np.max(variation(closed, [closed + flatter]).change)) < 1e-12
    assert float(np.max(variation(closed, [closed + 1e-3 * np.eye(2)]).change)) == pytest.approx(1e-3)


@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-9])
def test_what_a_block_does_to_another_changes_alike_in_all_units(unit: float) -> None:
    """One of three entries grows by 1 %; where the state of the first block is small or large does not count."""
    wire, states = (("b", "output", 0),), (("a", "state", -1), ("b", "state", -1))

    def loop(grown: float) -> PeriodMap:
        rows = [[0.5, 0.2 * grown * unit, unit, 0.0], [0.3 / unit, 0.6, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]
        return PeriodMap(states, wire, wire, np.array(rows), {}, 1e-3)

    assert change_between(loop(1.0), loop(1.0)) == 0.0
    assert change_between(loop(1.0), loop(1.01)) == pytest.approx(0.01 / 1.01, rel=1e-9)
    assert change_between(loop(1.01), loop(1.0)) == pytest.approx(0.01 / 1.01, rel=1e-9)
    assert change_between(loop(1.0), loop(1.0).kept([0])) == math.inf
