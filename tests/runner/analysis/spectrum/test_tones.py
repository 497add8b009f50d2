"""Figures of tones: ideal converters, known distortion, a sigma-delta modulator written out by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy

from proofmass import spectrum, tones
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.spectrum.text import tone_text
from proofmass.runner.analysis.spectrum.windows import WINDOWS

VALUES, RATE = 1 << 16, 1000.0


def sine(cycles: float, size: float = 1.0) -> np.ndarray:  # type: ignore[type-arg]
    return size * np.sin(2.0 * np.pi * cycles * np.arange(VALUES) / VALUES + 0.1)


@pytest.mark.exhaustive(but=5)
@pytest.mark.parametrize("bits", [4, 8, 12, 16, 20])
@pytest.mark.parametrize("cycles", [12345, 12345.3, 4567.9])
def test_an_ideal_converter_has_its_bits(bits: int, cycles: float) -> None:
    codes = np.round(sine(cycles) * (2.0 ** (bits - 1) - 0.5) - 0.5)
    found = tones(spectrum(codes, rate=RATE, window="blackman-harris-7", segment=0))
    assert found.enob == pytest.approx(bits, abs=0.02)
    assert found.coherent == (cycles == 12345)
    assert found.cycles == pytest.approx(cycles, abs=2e-3)


def test_a_coherent_tone_needs_no_window() -> None:
    codes = np.round(sine(12345) * (2.0**11 - 0.5) - 0.5)
    found = tones(spectrum(codes, rate=RATE, window="rectangular", segment=0))
    assert found.enob == pytest.approx(12.0, abs=0.02)
    assert found.coherent


def test_a_tone_between_lines_is_told_without_a_window() -> None:
    found = tones(spectrum(sine(12345.3), rate=RATE, window="rectangular", segment=0))
    assert not found.coherent
    assert found.cycles == pytest.approx(12345.3, abs=0.01)


@pytest.mark.exhaustive(but=12)
@pytest.mark.defect("S863", before="0.012 lines away through a Hann window, to nine digits", after="where it is")
@pytest.mark.parametrize("cycles", [12345.0, 12345.2, 12345.5, 12345.9, 1000.4])
@pytest.mark.parametrize("window", WINDOWS)
def test_a_tone_between_lines_is_where_it_is(window: str, cycles: float) -> None:
    """But for what leaks from the same frequency below zero: 1e-4 lines at most here."""
    found = tones(spectrum(sine(cycles), rate=RATE, window=window, segment=0))
    assert found.cycles == pytest.approx(cycles, abs=2e-4)


@pytest.mark.parametrize("window", WINDOWS)
def test_a_tone_in_the_middle_of_two_lines_that_are_alike(window: str) -> None:
    of = spectrum(sine(12345.5), rate=RATE, window=window, segment=0)
    density = of.density.copy()
    density[12345:12347] = np.max(density)
    found = tones(replace(of, density=density))
    assert found.cycles == 12345.5


@pytest.mark.defect("S862", before="through a Hann window SNR 33 dB for 137 dB, without a word", after="told to leak")
@pytest.mark.parametrize("window", ["rectangular", "hann", "hamming", "blackman-harris", "blackman-harris-7"])
def test_a_tone_that_leaks_out_of_its_window_is_told(window: str) -> None:
    """Beside the lines of its main lobe a tone between lines has, of `boxcar` and others, what SciPy finds there."""
    values = sine(12345.4) + 1e-7 * np.random.default_rng(2).normal(size=VALUES)
    of = spectrum(values, rate=RATE, window=window, segment=0)
    found, truth = tones(of), 10.0 * math.log10(0.5e14)
    if window == "blackman-harris-7":
        assert found.snr == pytest.approx(truth, abs=0.1)
        assert not found.leaks
        return
    known = {"rectangular": "boxcar", "blackman-harris": "blackmanharris"}.get(window, window)
    _, power = scipy.signal.periodogram(sine(12345.4), RATE, window=known, scaling="density")
    lobe = {"rectangular": 0, "blackman-harris": 4}.get(window, 2)
    beside = np.delete(power, range(12345 - lobe, 12345 + lobe + 1))
    assert found.leaked == pytest.approx(math.sqrt(np.sum(beside[1:]) * RATE / VALUES), rel=0.1)
    assert found.leaks
    assert found.snr < truth - 0.1
    assert f"of it leaks out of the {window} window and counts as noise or harmonics; blackman-harris-7" in tone_text(
        found, of
    )


def test_distortion_and_spurs() -> None:
    """A tone of 1, its second harmonic of 1e-3, its third of 2e-3, folded, and a spur of 5e-4."""
    values = sine(20001) + sine(40002, 1e-3) + sine(60003, 2e-3) + sine(777, 5e-4)
    noise = 1e-5 * np.random.default_rng(1).normal(size=VALUES)
    found = tones(spectrum(values + noise, rate=RATE, window="blackman-harris-7", segment=0))
    assert found.frequency == pytest.approx(20001 * RATE / VALUES, rel=1e-9)
    assert found.rms == pytest.approx(math.sqrt(0.5), rel=1e-6)
    assert found.thd == pytest.approx(10.0 * math.log10(5e-6), abs=1e-3)
    assert found.sfdr == pytest.approx(20.0 * math.log10(1.0 / 2e-3), abs=1e-3)
    assert found.spur == pytest.approx((VALUES - 60003) * RATE / VALUES)
    assert found.snr == pytest.approx(10.0 * math.log10(0.5 / (0.5 * 25e-8 + 1e-10)), abs=0.05)
    assert found.sndr == pytest.approx(10.0 * math.log10(0.5 / (0.5 * (25e-8 + 5e-6) + 1e-10)), abs=0.01)
    beside = tones(spectrum(values, rate=RATE, window="blackman-harris-7", segment=0), tone=777 * RATE / VALUES)
    assert beside.rms == pytest.approx(5e-4 * math.sqrt(0.5), rel=1e-3)


def modulated(values: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """Bits of a second-order sigma-delta modulator (Candy 1985)."""
    first = second = 0.0
    bits = np.empty(len(values))
    for i, value in enumerate(values):
        bit = 1.0 if second >= 0.0 else -1.0
        first += 0.5 * (value - bit)
        second += 0.5 * (first - bit)
        bits[i] = bit
    return bits


@pytest.mark.defect(
    "S880", before="the second harmonic of a third of the rate left out, THD -86 dB for -40", after="is told"
)
@pytest.mark.parametrize(
    ("cycles", "hidden"),
    [(21845, (2, 3, 4, 5, 6, 7, 8, 9, 10)), (16384, (3, 4, 5, 7, 8, 9)), (13107, (4, 5, 6, 9, 10))],
)
def test_harmonics_that_fold_onto_the_tone_are_told(cycles: int, hidden: tuple[int, ...]) -> None:
    """Of parts 1 / k of the rate those of order n k - 1, n k and n k + 1, where k is 3, 4 and 5."""
    values = sine(cycles) + 0.01 * sine(2 * cycles) + 1e-6 * np.random.default_rng(3).standard_normal(VALUES)
    density = spectrum(values, rate=RATE, window="blackman-harris-7", segment=0)
    found = tones(density)
    assert found.hidden == hidden
    assert f"order {', '.join(map(str, hidden))} fold onto the tone" in tone_text(found, density)


def test_a_tone_whose_harmonics_stand_alone_has_no_such_note() -> None:
    density = spectrum(sine(12345) + 0.01 * sine(24690), rate=RATE, window="blackman-harris-7", segment=0)
    found = tones(density)
    assert found.thd == pytest.approx(-40.0, abs=1e-6)
    assert found.hidden == ()
    assert "fold" not in tone_text(found, density)


def test_noise_shaping_of_the_second_order_rises_by_40_db_a_decade() -> None:
    bits = modulated(sine(31, 0.5) + 1e-4 * np.random.default_rng(2).normal(size=VALUES))
    found = spectrum(bits, rate=RATE, segment=8192, window="blackman-harris")
    assert found.slope((5.0, 50.0)) == pytest.approx(40.0, abs=2.0)
    whole = spectrum(bits, rate=RATE, window="blackman-harris-7", segment=0)
    in_band = tones(whole, band=(0.0, RATE / 2.0 / 64.0))
    ideal = 10.0 * math.log10(15.0 / 2.0 * 64.0**5 / math.pi**4 * 0.25)  # of a quantiser with gain one, at half size
    assert in_band.sndr == pytest.approx(ideal, abs=8.0)
    assert tones(whole).sndr < 10.0


def test_noise_has_no_tone() -> None:
    noise = np.random.default_rng(5).normal(size=VALUES)
    with pytest.raises(ModelError, match="no tone stands out"):
        tones(spectrum(noise, rate=RATE, window="blackman-harris-7", segment=0))
    with pytest.raises(ModelError, match="no tone stands out"):
        tones(spectrum(np.ones(VALUES), rate=RATE, segment=0))


def test_too_few_lines_are_refused() -> None:
    with pytest.raises(ModelError, match="too few lines"):
        tones(spectrum(sine(100)[:16], rate=RATE, window="blackman-harris-7", segment=0))


@pytest.mark.defect(
    "S916", before="the rms of a tone of two cycles 8 % off, without a word", after="told to be in doubt"
)
@pytest.mark.parametrize(
    ("window", "cycles", "apart", "told"),
    [
        ("blackman-harris-7", 2.0, 0.0788, True),  # what the worst of all phases makes of the rms
        ("blackman-harris-7", 254.0, 0.0788, True),
        ("flat-top", 3.0, 0.0078, True),
        ("blackman-harris-7", 5.0, 1e-5, False),
        ("hann", 2.0, 1e-9, False),
    ],
)
def test_a_tone_that_overlaps_its_image_is_told(window: str, cycles: float, apart: float, told: bool) -> None:
    """Sines of 512 values, of which a fit of sine and cosine has the rms to rounding."""
    phases = np.linspace(0.0, math.pi, 13)[:, None]
    rows = np.sin(2.0 * math.pi * cycles * np.arange(512) / 512.0 + phases) + 1e-9 * np.cos(np.arange(512) ** 2)
    densities = [spectrum(row, rate=512.0, window=window, segment=0) for row in rows]
    found = [tones(density, tone=cycles) for density in densities]
    assert max(abs(one.rms * math.sqrt(2.0) - 1.0) for one in found) == pytest.approx(apart, rel=0.02, abs=2e-5)
    assert {"overlaps its image" in tone_text(one, of) for one, of in zip(found, densities, strict=True)} == {told}
    assert 0.99 * apart - 2e-5 < max(one.mirrored for one in found) < 2.0 * apart + 2e-5


@pytest.mark.defect("H901", before="of a trace: it has no attribute `window`", after="of what tones are, and the call")
def test_tones_of_a_trace_tell_the_call() -> None:
    with pytest.raises(TypeError, match=r"not of a ndarray: tones\(spectrum\(of, segment=0\)\)"):
        tones(np.zeros(100))  # type: ignore[arg-type]
