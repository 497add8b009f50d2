"""What a block answers, as a small picture: its example graph, run for a few periods of the sources."""

import math
from html import escape

import numpy as np

from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.example import example_of
from proofmass.graphs.model.graph import Probe
from proofmass.runner.run.result import Trace
from proofmass.runner.run.simulate import simulate

_TICKS = 201  # of 0.1 ms: 20 ms
_WIDTH, _PANEL, _LEFT, _GAP = 440, 46, 128, 10
_MOST = 6  # panels


def response_picture(kind: type[Block]) -> str:
    """Return the SVG of the outputs of a block's example graph over 20 ms, the inputs above them.

    It is empty for a block that plays a file, since its example has none.
    """
    if any(buffer.recorded for buffer in kind.buffers.values()):
        return ""
    example = example_of(kind)
    inputs = {wire.target: wire.source for wire in example.wires if wire.target.startswith("block.")}
    signals = [*dict.fromkeys(inputs.values()), *(probe.signal for probe in example.probes)]
    result = simulate(
        example.changed(probes=tuple(map(Probe, signals))),
        samples=_TICKS,
        engine="compiled" if kind.continuous() else "python",
    )
    named = {source: target.partition(".")[2] for target, source in reversed(inputs.items())}
    drawn = [(named.get(s, s.partition(".")[2]), s in named, result[s]) for s in signals if len(result[s].values)]
    shown = drawn[:_MOST]
    height = len(shown) * (_PANEL + _GAP) + 22
    width = _LEFT + _WIDTH + 8
    lines = [
        f'<svg class="response" role="img" aria-label="{escape(kind.__name__)} over 20 ms" width="{width}" '
        f'height="{height}" viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg">'
    ]
    for row, (name, entrance, trace) in enumerate(shown):
        lines += _panel(name, entrance, trace, row * (_PANEL + _GAP) + 4)
    lines += [
        f'<text class="unit" x="{_LEFT}" y="{height - 6}">0</text>',
        f'<text class="unit" x="{_LEFT + _WIDTH}" y="{height - 6}" text-anchor="end">20 ms</text>',
    ]
    return "\n".join([*lines, "</svg>"])


def _panel(name: str, entrance: bool, trace: Trace, top: float) -> list[str]:
    """Name, range and curve of one signal; of a vector its first number."""
    values = np.asarray(trace.values, dtype=float).reshape(len(trace.values), -1)[:, 0]
    low, high = float(values.min()), float(values.max())
    middle, half = 0.5 * (low + high), 0.5 * (high - low) or 1.0
    x = _LEFT + np.asarray(trace.times) / (1e-4 * (_TICKS - 1)) * _WIDTH
    y = top + 0.5 * _PANEL - (values - middle) / half * (0.5 * _PANEL - 3)
    steps = "".join(f"V{height:.1f}H{after:.0f}" for after, height in zip([*x[1:], _LEFT + _WIDTH], y, strict=True))
    style, ends = "entrance" if entrance else "answer", _range(low, high, trace.unit)
    return [
        f'<rect class="frame" x="{_LEFT}" y="{top:.0f}" width="{_WIDTH}" height="{_PANEL}"/>',
        f'<text class="port" x="{_LEFT - 6}" y="{top + 15:.0f}" text-anchor="end">{escape(name)}</text>',
        f'<text class="unit" x="{_LEFT - 6}" y="{top + 29:.0f}" text-anchor="end">{ends}</text>',
        f'<path class="{style}" d="M{x[0]:.0f} {y[0]:.1f}{steps}"/>',
    ]


def _range(low: float, high: float, unit: str) -> str:
    ends = f"{low:.3g}" if math.isclose(low, high) else f"{low:.3g} to {high:.3g}"
    return escape(f"{ends} {unit}" if unit not in ("", "1") else ends)
