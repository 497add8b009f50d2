"""Solutions of equations of motion by SciPy: DOP853 or Radau to 1e-12, from event to event."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

REFERENCE, PIECES = 1e-13, 2.5e-14  # tolerances
Rates = Callable[[float, Any], list[float]]


def by_scipy(rates: Rates, start: Sequence[float], sizes: Sequence[float], row: int, stiff: bool = False) -> Any:
    """Return the row of the states at given times, which are integrated in parts of their sizes."""
    size = np.asarray(sizes, dtype=float)

    def scaled(t: float, y: Any) -> Any:
        return np.asarray(rates(t, y * size)) / size

    def values(times: Any) -> Any:
        method = "Radau" if stiff else "DOP853"
        span, tolerance = (0.0, float(times[-1])), 1e-12 if stiff else REFERENCE
        found = solve_ivp(scaled, span, np.asarray(start) / size, method, times, rtol=tolerance, atol=tolerance)
        return found.y[row] * size[row]

    return values


def by_pieces(
    rates: Callable[[int], Rates],
    start: Sequence[float],
    sizes: Sequence[float],
    ends: Callable[[int], Any],
    then: Callable[[int, Any], tuple[int, Any]],
    first: int,
) -> Any:
    """Return the states at given times, where a mode changes at events: its rates, end and successor are given."""
    size = np.asarray(sizes, dtype=float)

    def values(times: Any) -> Any:
        mode, t, y = first, 0.0, np.asarray(start, dtype=float) / size
        found = np.zeros((len(times), len(size)))
        while t < times[-1]:
            event = ends(mode)
            if event(t, y * size) < -1e-6:
                mode, after = then(mode, y * size)
                y = np.asarray(after) / size
                continue

            def scaled(at: float, v: Any, mode: int = mode) -> Any:
                return np.asarray(rates(mode)(at, v * size)) / size

            def end(at: float, v: Any, event: Any = event) -> float:
                return float(event(at, v * size))

            end.terminal, end.direction = True, -1.0  # type: ignore[attr-defined]
            span, longest = (t, float(times[-1])), float(times[-1]) / 2000.0
            piece = solve_ivp(
                scaled,
                span,
                y,
                "DOP853",
                rtol=PIECES,
                atol=PIECES,
                max_step=longest,
                events=end,
                dense_output=True,
            )
            inside = (times >= t) & (times <= piece.t[-1])
            if inside.any():
                found[inside] = piece.sol(times[inside]).T * size
            t, y = float(piece.t[-1]), piece.y[:, -1]
            if piece.status == 1:
                mode, after = then(mode, y * size)
                y = np.asarray(after) / size
        return found

    return values
