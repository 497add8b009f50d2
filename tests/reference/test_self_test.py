"""The PN self-test graphs against straight-line programs and the analytic response."""

import mpmath
import numpy as np
import pytest

from benchmarks.self_test import GRAPH, judge
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate


def straight_line_program(periods: int) -> np.ndarray:  # type: ignore[type-arg]
    """Chips by the recurrence a[n] = a[n-7] xor a[n-10], the plant by its hold, sums by NumPy over whole periods."""
    chips = [1] * 10
    while len(chips) < 1023 * periods:
        chips.append(chips[-7] ^ chips[-10])
    (a11, a12, b1), (a21, a22, b2) = _hold(50.43e-9, 3.4e-3, 49.5627, 1.0 / 9600.0)
    x = v = 0.0
    codes = []
    for chip in chips:
        codes.append(min(max(round(1e6 * x * 32768.0), -32768), 32767))
        force = 1e-6 if chip else -1e-6
        x, v = a11 * x + a12 * v + b1 * force, a21 * x + a22 * v + b2 * force
    signs = 2 * np.array(chips) - 1
    sums = np.empty((periods, 16), dtype=np.int64)
    for lag in range(16):
        moved = np.concatenate([np.zeros(lag, dtype=np.int64), signs[: len(signs) - lag]])
        sums[:, lag] = (moved * np.array(codes)).reshape(periods, 1023).sum(axis=1)
    return sums


def _hold(m: float, c: float, k: float, period: float) -> list[list[float]]:
    with mpmath.workdps(40):
        joined = mpmath.matrix([[0, 1, 0], [-mpmath.mpf(k) / m, -mpmath.mpf(c) / m, mpmath.mpf(1) / m], [0, 0, 0]])
        held = mpmath.expm(joined * period)
        return [[float(held[i, j]) for j in range(3)] for i in range(2)]


@pytest.mark.exhaustive
def test_minimal_self_test_equals_the_straight_line_program() -> None:
    result = simulate(read_graph(library_file("pn_self_test_minimal.toml")), engine="compiled")
    sums = result["correlator.impulse_response"].values[1:]
    assert np.array_equal(sums, straight_line_program(1000))
    # Published checksums of the workload.
    assert abs(sums.mean() - 41639.556) < 1e-9
    assert abs(sums.std() - 132845.550464898) < 1e-6
    assert sums[-1].tolist() == [-661, 544427, 116395, 12459, 683, -469, *[-661] * 10]


def test_estimated_response_is_within_one_percent_of_the_analytic_one() -> None:
    """Sarraf et al. 2012, eq. 2 and 3, cells 1 to 10 without noise; measured 0.53 % at worst, in cell 3."""
    verdict = judge(simulate(read_graph(library_file(GRAPH)), samples=1023 * 20 + 1))
    assert np.abs(verdict.error[1:11]).max() < 0.01
    # The constant of the autocorrelation alone explains cell 0 and the tail.
    assert verdict.measured[0] == pytest.approx(verdict.constant, rel=1e-4)
    assert verdict.measured[10:] == pytest.approx(verdict.constant, rel=1e-4)


def test_what_is_left_is_rounding_to_codes() -> None:
    """With a converter of 32 bits the sums are the analytic ones to six digits, in every cell."""
    graph = read_graph(library_file(GRAPH)).with_parameters({"adc.bits": 32})
    verdict = judge(simulate(graph, samples=1023 * 4 + 1))
    assert np.abs(verdict.error[1:11]).max() < 1e-6
