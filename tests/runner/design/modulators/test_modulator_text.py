"""What people read and see of a modulator, from ones that were written by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass.runner.design.modulators.modulator import Modulator
from proofmass.runner.design.modulators.noise_transfer import NoiseTransfer
from proofmass.runner.design.modulators.plot import plot_modulator
from proofmass.runner.design.modulators.structures import Coefficients, Structure
from proofmass.runner.design.modulators.text import modulator_text

SECOND = Modulator(
    order=2,
    oversampling=32.0,
    gain=4.0,
    centre=0.0,
    levels=2,
    structure=Structure("CIFB", 2),
    transfer=NoiseTransfer((1.0 + 0j, 1.0 + 0j), (0j, 0j)),
    coefficients=Coefficients((0.5, 1.5), (0.5, 0.0, 1.0), (1.0, 1.0), ()),
    amplitudes=(-20.0, -6.0, 0.0),
    predicted=(40.0, 54.25, None),
    simulated=(39.5, 53.75, None),
    stable_limit=0.5,
    swings=(1.25, 2.5),
)
BAND = replace(
    SECOND,
    centre=0.25,
    levels=3,
    structure=Structure("CRFF", 2, (0.25, 0.75)),
    transfer=NoiseTransfer((1j, -1j), (0.5 + 0.25j, 0.5 - 0.25j)),
)


def test_every_line_of_a_modulator() -> None:
    """A band of 1 / 64 of the rate; overload from 20 log10 0.5 = -6.0 dB on."""
    assert modulator_text(SECOND).splitlines() == [
        "CIFB of order 2, 2 levels, discrete time",
        "  band              0 to 0.015625 of the rate, oversampling 32",
        "  gain of the noise 4 far from the band",
        "  peak              53.8 dB at -6 dB of full scale, by simulation",
        "  stable            below -6.0 dB, by prediction",
        "noise transfer function",
        "  zero      poles",
        "  1.000000  0.000000",
        "  1.000000  0.000000",
        "coefficients",
        "            1    2  3",
        "  a       0.5  1.5",
        "  b       0.5    0  1",
        "  c         1    1",
        "  g",
        "  swing  1.25  2.5",
        "signal to noise",
        "  amplitude [dB]  predicted [dB]  simulated [dB]",
        "  -20                       40.0            39.5",
        "  -6                        54.2            53.8",
        "  0                     overload        overload",
    ]


def test_a_continuous_filter_of_a_band() -> None:
    """1 / 64 of the rate about a quarter of it; of a pair of roots the upper one stands for both."""
    lines = modulator_text(BAND).splitlines()
    assert lines[0] == "CRFF of order 2, 3 levels, continuous time, pulse from 0.25 to 0.75 of a period"
    assert lines[1] == "  band              0.242188 to 0.257812 of the rate, oversampling 32"
    assert not any("by prediction" in line for line in lines)
    at = lines.index("noise transfer function")
    assert lines[at + 1 : at + 3] == [
        "  zero                  poles",
        "  0.000000 + 1.000000j  0.500000 + 0.250000j",
    ]
    assert lines[at + 3] == "coefficients"
    silent = modulator_text(replace(SECOND, stable_limit=0.0))
    assert "below -inf dB" in silent


@pytest.mark.parametrize(
    ("zeros", "poles", "rows"),
    [
        (
            (1.0 + 0j, 1.0 + 0j),
            (0.5 + 0.25j, 0.5 - 0.25j),
            ["1.000000 0.500000 + 0.250000j", "1.000000 0.500000 - 0.250000j"],
        ),
        ((1j, -1j), (0.5 + 0j, 0.25 + 0j), ["0.000000 + 1.000000j 0.500000", "0.000000 - 1.000000j 0.250000"]),
        ((-1j, 1j), (0.5 - 0.25j, 0.5 + 0.25j), ["0.000000 + 1.000000j 0.500000 + 0.250000j"]),
    ],
)
def test_pairs_beside_roots_that_are_none(
    zeros: tuple[complex, ...], poles: tuple[complex, ...], rows: list[str]
) -> None:
    """No zero or pole is left out where only the other is one of a pair."""
    lines = modulator_text(replace(SECOND, transfer=NoiseTransfer(zeros, poles))).splitlines()
    at = lines.index("noise transfer function")
    assert [" ".join(line.split()) for line in lines[at + 2 : lines.index("coefficients")]] == rows


@pytest.mark.parametrize("of", [SECOND, BAND])
def test_curves_of_the_picture(of: Modulator) -> None:
    """|H| = (2 sin pi f)^2 of two zeros at 1, over two decades below the band up to half the rate."""
    left, right = plot_modulator(of).axes
    frequencies, gains = left.lines[0].get_xdata(), left.lines[0].get_ydata()
    z = np.exp(2j * math.pi * frequencies)
    h = (
        (2.0 * np.sin(math.pi * frequencies)) ** 2
        if of is SECOND
        else np.abs((z * z + 1.0) / ((z - 0.5) ** 2 + 1 / 16))
    )
    assert gains == pytest.approx(20.0 * np.log10(np.maximum(h, 1e-9)), abs=1e-6)
    assert (frequencies[0], frequencies[-1], len(frequencies)) == pytest.approx(
        (1 / 3200 if of is SECOND else 1e-4, 0.5, 2000)
    )
    steps = np.diff(np.log(frequencies) if of is SECOND else frequencies)
    assert steps == pytest.approx(np.full(1999, steps[0]))
    assert left.get_xscale() == ("log" if of is SECOND else "linear")
    shade = left.patches[0]
    assert (shade.get_x(), shade.get_x() + shade.get_width()) == pytest.approx(of.band)
    for line, ratios in zip(right.lines, ([40.0, 54.25, math.nan], [39.5, 53.75, math.nan]), strict=True):
        assert line.get_xdata() == pytest.approx([-20.0, -6.0, 0.0])
        assert line.get_ydata() == pytest.approx(ratios, nan_ok=True)
    assert [text.get_text() for text in right.get_legend().get_texts()] == ["predicted", "simulated"]
