"""Noise transfer functions and loop filters against figures that were printed elsewhere.

Roots, coefficients and bits are those that the documents of the Delta-Sigma Toolbox (R. Schreier), of its port
python-deltasigma, and of MathWorks' `synthesizeNTF` and `realizeNTF` print, at an oversampling of 32 and a gain of 1.5.
"""

import numpy as np
import pytest

from proofmass import design_modulator
from proofmass.runner.design.modulators.noise_transfer import synthesised
from proofmass.runner.design.modulators.simulation import output_of

LOW_PASS = {  # form, order: a, of zeros at the centre for an even order
    ("CIFB", 2): (0.2164, 0.7749),
    ("CIFB", 3): (0.0444, 0.2843, 0.8025),
    ("CIFB", 4): (0.0062, 0.0655, 0.3042, 0.8089),
    ("CIFB", 5): (0.0007, 0.0095, 0.0731, 0.3100, 0.8130),
    ("CRFB", 2): (0.2164, 0.5585),
    ("CRFB", 3): (0.0444, 0.2399, 0.5569),
    ("CRFB", 4): (0.0062, 0.0530, 0.2449, 0.5571),
    ("CRFB", 5): (0.0007, 0.0084, 0.0550, 0.2443, 0.5579),
    ("CIFF", 2): (0.7749, 0.2164),
    ("CIFF", 3): (0.8025, 0.2843, 0.0398),
    ("CIFF", 4): (0.8089, 0.3042, 0.0599, 0.0041),
    ("CIFF", 5): (0.8130, 0.3100, 0.0667, 0.0080, 0.0001),
    ("CRFF", 2): (0.5585, 0.2164),
    ("CRFF", 3): (0.5569, 0.2399, 0.0412),
    ("CRFF", 4): (0.5571, 0.2449, 0.0492, 0.0046),
    ("CRFF", 5): (0.5579, 0.2443, 0.0505, 0.0071, 0.0003),
}
RESONANCE = {2: (0.0,), 3: (0.0058,), 4: (0.0, 0.0069), 5: (0.0028, 0.0079)}
QUARTER = {  # band passes at a quarter of the rate
    ("CRFB", 2): (-0.6667, 0.6667),
    ("CRFB", 4): (-0.2164, 0.0, -0.5585, 0.5585),
    ("CRFF", 2): (0.6667, -0.6667),
    ("CRFF", 4): (0.5585, -0.5585, 0.0, -0.2164),
}


def test_roots_of_a_low_pass_of_fifth_order() -> None:
    transfer = synthesised(5, 32)
    zeros = [1.0, 0.99860302 + 0.05283948j, 0.99604531 + 0.08884669j]
    poles = [0.77776708, 0.80655696 + 0.11982271j, 0.89807098 + 0.21981939j]
    assert np.abs(np.array([z for z in transfer.zeros if z.imag >= 0.0]) - zeros).max() < 1e-8
    assert np.abs(np.array([p for p in transfer.poles if p.imag >= 0.0]) - poles).max() < 1e-8


def test_roots_of_a_band_pass_of_eighth_order() -> None:
    transfer = synthesised(8, 32, zeros="centred", centre=0.125)
    zeros = [0.735825 + 0.677171j, *[0.707107 + 0.707107j] * 2, 0.677171 + 0.735825j]
    poles = [0.751098 + 0.551585j, 0.637688 + 0.578575j, 0.576806 + 0.657630j, 0.574412 + 0.755247j]
    assert np.abs(np.array([z for z in transfer.zeros if z.imag > 0.0]) - zeros).max() < 1e-6
    assert np.abs(np.array([p for p in transfer.poles if p.imag > 0.0]) - poles).max() < 1e-6


@pytest.mark.exhaustive(but=6)
@pytest.mark.parametrize(("form", "order"), LOW_PASS)
def test_coefficients_of_low_passes(form: str, order: int) -> None:
    k = design_modulator(order, 32, form=form, zeros="centred", feeds="all", swing=None, samples=1024).coefficients
    assert k.a == pytest.approx(LOW_PASS[form, order], abs=5.1e-5)
    assert k.g == pytest.approx(RESONANCE[order], abs=5.1e-5)
    assert k.b == ((*k.a, 1.0) if form.endswith("FB") else (1.0, *[0.0] * (order - 1), 1.0))


@pytest.mark.parametrize(("form", "order"), QUARTER)
def test_coefficients_of_band_passes(form: str, order: int) -> None:
    of = design_modulator(order, 32, form=form, zeros="centred", centre=0.25, swing=None, samples=1024)
    assert of.coefficients.a == pytest.approx(QUARTER[form, order], abs=5.1e-5)
    assert of.coefficients.g == pytest.approx((2.0,) * (order // 2), abs=5.1e-5)


def test_matrix_and_bits_of_a_chain_of_resonators() -> None:
    of = design_modulator(5, 32, feeds="all", swing=None, samples=1024)
    rows, last = of.structure.stepped(of.coefficients)
    printed = [
        [1, 0, 0, 0, 0, 0.0007, -0.0007],
        [1, 1, -0.0028, 0, 0, 0.0084, -0.0084],
        [1, 1, 0.9972, 0, 0, 0.0633, -0.0633],
        [0, 0, 1, 1, -0.0079, 0.2443, -0.2443],
        [0, 0, 1, 1, 0.9921, 0.8023, -0.8023],
    ]
    assert np.abs(rows - printed).max() < 5.1e-5
    assert last.tolist() == [0, 0, 0, 0, 1, 1, 0]
    sine = 0.5 * np.sin(2.0 * np.pi * 85.0 / 8192.0 * np.arange(50))
    bits = "+--++-+-++-+++-++-+-+++++-+-+++++-++-+-+-+++--++-+"
    assert output_of(of.structure, of.coefficients, sine[:, None], 2)[0][:, 0].tolist() == [
        1.0 if bit == "+" else -1.0 for bit in bits
    ]
