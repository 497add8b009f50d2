"""The filter against Hogenauer's registers in integers that wrap, and against its transfer function."""

import numpy as np
import pytest

from proofmass.blocks import CascadedIntegratorComb, Ramp, ShiftRegister, Switch
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import distance, noise, response


def hogenauer(codes: list[int], order: int, ratio: int, bits: int) -> list[int]:
    """What a chip does: integrators at the fast rate, combs at the slow one, registers of so many bits."""
    mask = (1 << bits) - 1
    integrators, combs, outputs = [0] * order, [0] * order, [0]
    for n, code in enumerate(codes):
        value = code
        for i in range(order):
            value = integrators[i] = (integrators[i] + value) & mask
        if n % ratio == ratio - 1:
            for i in range(order):
                value, combs[i] = (value - combs[i]) & mask, value
            outputs.append(value - (1 << bits) if value >> (bits - 1) else value)
    return outputs


@pytest.mark.parametrize(("order", "ratio"), [(1, 8), (2, 5), (3, 16), (4, 1), (5, 32)])
def test_against_registers_that_wrap(order: int, ratio: int) -> None:
    codes = np.random.default_rng(1).integers(-512, 512, 20 * ratio).tolist()
    answer = response(CascadedIntegratorComb(order=order, ratio=ratio), [float(code) for code in codes])[::ratio]
    bits = 11 + order * max(ratio - 1, 1).bit_length()
    expected = np.array(hogenauer(codes, order, ratio, bits)[:20]) / ratio**order
    assert distance(answer, expected) < 1e-13


def test_zeros_at_multiples_of_the_slow_rate() -> None:
    carrier = [1.0 + np.cos(2.0 * np.pi * n / 8.0) for n in range(400)]
    assert response(CascadedIntegratorComb(order=2, ratio=8), carrier)[16::8] == pytest.approx([1.0] * 48, abs=1e-14)


def test_it_never_drifts() -> None:
    signal = [1e6 * u for u in noise(9600)] + [0.0] * 96
    assert response(CascadedIntegratorComb(order=3, ratio=16), signal)[-16] == 0.0


def test_its_port_ticks_once_in_a_window() -> None:
    blocks = {"bits": ShiftRegister(), "high": Ramp(slope=0.0, offset=1.0), "low": Ramp(slope=0.0, offset=-1.0)}
    graph = Graph(
        name="decimated",
        rate=1,
        blocks={**blocks, "levels": Switch(), "filter": CascadedIntegratorComb(order=2, ratio=4)},
        wires=[
            "high.output -> levels.first",
            "low.output -> levels.second",
            "bits.bit -> levels.choose_first",
            "levels.output -> filter.input",
        ],
        probes=["levels.output", "filter.output"],
    )
    result = simulate(graph, samples=400, engine="python")
    codes = [int(v) for v in result["levels.output"].values]
    expected = np.array(hogenauer(codes, 2, 4, 12)[:100]) / 16.0
    assert result["filter.output"].values.tolist() == expected.tolist()
