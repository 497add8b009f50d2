"""An R-2R ladder by Kirchhoff's laws: what converters with a binary ladder must give."""

import numpy as np


def ladder(bits: int, code: int, high: float, low: float) -> float:
    """Output of a ladder whose legs switch between two voltages, its end at the lower one."""
    g, sources = np.zeros((bits, bits)), np.zeros(bits)
    for i in range(bits):  # node 0 is at the lowest bit, with the end of 2R; conductances in 1 / (2R)
        g[i, i] += 1.0
        sources[i] += high if code >> i & 1 else low
        if i + 1 < bits:
            g[i : i + 2, i : i + 2] += [[2.0, -2.0], [-2.0, 2.0]]
    g[0, 0] += 1.0
    sources[0] += low
    return float(np.linalg.solve(g, sources)[-1])
