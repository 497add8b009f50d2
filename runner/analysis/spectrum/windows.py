"""Windows: sums of cosines, periodic, as the discrete Fourier transform wants them.

    w[n] = sum over k of (-1)^k a[k] cos(2 pi k n / N)

(Harris, Proc. IEEE 66, 1978, 51; the minimum of four terms by Nuttall, IEEE Trans. ASSP 29, 1981,
84; that of seven by Albrecht, Proc. ICASSP 2001, 3045.)
"""

import numpy as np

from proofmass.blocks.declaration.problem import Problem, did_you_mean
from proofmass.runner.host.arrays import Array

WINDOWS: dict[str, tuple[float, ...]] = {
    "rectangular": (1.0,),
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),
    "nuttall": (0.3635819, 0.4891775, 0.1365995, 0.0106411),
    "blackman-harris-7": (
        0.27105140069342, 0.43329793923448, 0.21812299954311, 0.06592544638803,
        0.01081174209837, 0.00077658482522, 0.00001388721735,
    ),
    "flat-top": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
}  # fmt: skip


def terms(name: str) -> tuple[float, ...]:
    """The coefficients of a window; raises `ModelError` for an unknown name."""
    if name not in WINDOWS:
        hint = did_you_mean(name, WINDOWS, "window")
        raise Problem(message="there is no such window", key="window", got=name, hint=hint).error
    return WINDOWS[name]


def window(name: str, length: int) -> Array:
    """The window of so many values."""
    turn = 2.0 * np.pi * np.arange(length) / length
    return np.asarray(sum(a * np.cos(k * turn) for k, a in enumerate(_signed(name))), dtype=float)


def _signed(name: str) -> list[float]:
    return [a if k % 2 == 0 else -a for k, a in enumerate(terms(name))]


def transform(name: str, bins: float) -> float:
    """Return the size of its transform so many bins from the middle, without the factor |sin(pi bins)| / pi.

    Of many values it is the sum over k of (-1)^k a[k] bins / (bins^2 - k^2), each cosine's at its two places.
    """
    return abs(sum(a * bins / (bins**2 - k**2) for k, a in enumerate(_signed(name))))


def half_lobe(name: str) -> int:
    """Bins from the middle of a tone to where the window has no more of it."""
    return len(terms(name)) if name != "rectangular" else 0
