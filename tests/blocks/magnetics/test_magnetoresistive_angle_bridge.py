"""The angle bridge: least energy of its layers, Slonczewski's conductances and Kirchhoff's laws; its harmonics."""

import math

import numpy as np
import pytest
from scipy import optimize

from proofmass.blocks import MagnetoresistiveAngleBridge
from tests.by_hand.responses import responses

TURN = np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)


def harmonics(block: MagnetoresistiveAngleBridge, field: float) -> np.ndarray:
    """Amplitudes of the cosines of a turn, at a supply of 1 V."""
    voltages = responses(block, "voltage", angle=TURN.tolist(), field=[field] * 64, supply=[1.0] * 64)
    return np.fft.rfft(voltages).real / 32.0


def test_without_a_pull_it_is_a_cosine() -> None:
    found = harmonics(MagnetoresistiveAngleBridge(ratio=0.3, direction=0.0, imbalance=2e-3), 0.0)
    assert found[:4] == pytest.approx([4e-3, 0.3, 0.0, 0.0], abs=1e-14)


def test_a_reference_that_may_turn_either_way_counts_as_at_right_angles() -> None:
    """At B = Br against it nothing turns the first; the second stays where it is: (1 - (1 + r)) / (2 + r)."""
    bridge = MagnetoresistiveAngleBridge(ratio=0.4, reference_field=0.5)
    [found] = responses(bridge, "voltage", angle=[math.pi], field=[0.5], supply=[3.0])
    assert found == pytest.approx(-3.0 * 0.4 / 2.4, abs=1e-15)


def test_the_third_harmonic_grows_with_the_pull() -> None:
    """ratio e / 4 of the fundamental to first order: halving the field leaves half of it, and a quarter of the rest."""
    parts = []
    for pull in (0.02, 0.01):
        found = harmonics(MagnetoresistiveAngleBridge(ratio=0.4, reference_field=1.0), pull)
        parts.append(found[3] / found[1] - 0.4 * pull / 4.0)
    assert parts[0] == pytest.approx(4.0 * parts[1], rel=0.02)
    assert abs(parts[1]) < 0.06 * 0.4 * 0.01 / 4.0 * 2.0


@pytest.mark.derivation(
    MagnetoresistiveAngleBridge,
    equation="voltage = supply ((g1 - g2) / (g1 + g2) + imbalance), g = 1 + ratio cos of free and reference layer",
    source="least Zeeman energy of each reference layer in two fields, Slonczewski's conductances, Kirchhoff's laws",
    convention="ratio is TMR / (2 + TMR), a half here; the references of arms 1 lie along `direction`",
    wrong="nothing",
)
@pytest.mark.parametrize("angle", [0.4, 2.0, -1.3])
def test_layers_of_least_energy_in_four_junctions(angle: float) -> None:
    tmr, low, field, held, direction, supply = 2.0, 1000.0, 0.08, 0.5, 0.2, 3.3
    parallel, against = 1.0 / low, 1.0 / (low * (1.0 + tmr))

    def conductance(of: float) -> float:
        """Of a junction whose reference is held at an angle: it turns to where its energy is least."""

        def energy(way: float) -> float:
            return -held * math.cos(way - of) - field * math.cos(way - angle)

        found = optimize.minimize_scalar(
            energy, bounds=(of - 1.5, of + 1.5), method="bounded", options={"xatol": 1e-11}
        )
        return 0.5 * (parallel + against) + 0.5 * (parallel - against) * math.cos(angle - found.x)

    first, second = conductance(direction), conductance(direction + math.pi)
    nodes = np.diag([first + second, first + second])
    left, right = np.linalg.solve(nodes, [supply * first, supply * second])
    block = MagnetoresistiveAngleBridge(ratio=tmr / (2.0 + tmr), direction=direction, reference_field=held)
    found = responses(block, "voltage", angle=[angle], field=[field], supply=[supply])
    assert found == pytest.approx([left - right], rel=1e-7)
