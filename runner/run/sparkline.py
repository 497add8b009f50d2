"""A small line of a trace, for notebooks: lowest and highest of each stretch."""

from typing import Any

import numpy as np

_STRETCHES = 120
_HEIGHT = 24  # pixels
_ROOM = 2  # pixels above and below


def sparkline(values: "np.ndarray[Any, np.dtype[Any]]") -> str:
    """Return a line of the values as SVG, in the text's colour; empty without two finite ones."""
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.ndim != 1 or len(numbers) < 2 or not np.isfinite(numbers).all():
        return ""
    bounds = np.linspace(0, len(numbers), min(_STRETCHES, len(numbers)) + 1).astype(int)
    lows = np.minimum.reduceat(numbers, bounds[:-1])
    highs = np.maximum.reduceat(numbers, bounds[:-1])
    lowest, span = lows.min(), highs.max() - lows.min()
    scale = (_HEIGHT - 2 * _ROOM) / span if span else 0.0
    ends = np.stack([lows, highs], axis=1).reshape(-1)
    heights = _HEIGHT - _ROOM - (ends - lowest) * scale if span else np.full(len(ends), _HEIGHT / 2)
    points = " ".join(f"{x / 2:g},{y:.1f}" for x, y in enumerate(heights))
    width = len(lows)
    return (
        f'<svg width="{_STRETCHES}" height="{_HEIGHT}" viewBox="0 0 {width} {_HEIGHT}" preserveAspectRatio="none" '
        f'role="img" aria-label="trace"><polyline points="{points}" fill="none" stroke="currentColor" '
        'stroke-width="1" vector-effect="non-scaling-stroke"/></svg>'
    )
