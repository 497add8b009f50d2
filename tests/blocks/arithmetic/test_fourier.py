"""The transform against NumPy's."""

import numpy as np
import pytest

from proofmass.blocks.arithmetic.fourier import fill_tables, transform, turned_bits


@pytest.mark.parametrize("bits", [1, 4, 9])
def test_against_numpy(bits: int) -> None:
    n = 1 << bits
    values = np.random.default_rng(bits).normal(size=n) + 1j * np.random.default_rng(7).normal(size=n)
    order = [turned_bits(i, bits) for i in range(n)]
    cosines, sines = [0.0] * n, [0.0] * n
    fill_tables(cosines, sines)
    real, imaginary = values.real[order].tolist(), values.imag[order].tolist()
    transform(real, imaginary, cosines, sines, bits)
    assert np.array(real) + 1j * np.array(imaginary) == pytest.approx(np.fft.fft(values), rel=1e-12, abs=1e-12)
