"""The spectrum of a signal, and the figures of its tone, as text for people."""

import math

import numpy as np

from proofmass.runner.analysis.spectrum.tones import Tones
from proofmass.runner.analysis.spectrum.welch import Spectrum

_MIRRORED = 1e-3  # of the rms: 0.01 dB
TONE_WINDOW = "blackman-harris-7"  # no tone of 24 bits leaks out of it


def spectrum_text(of: Spectrum, band: tuple[float, float] | None = None, slope: float | None = None) -> str:
    """The density for people."""
    unit = f" {of.unit}" if of.unit != "1" else ""
    where = f"from {band[0]:g} Hz to {band[1]:g} Hz" if band else f"above 0 Hz, to {of.rate / 2:g} Hz"
    lines = [
        f"{of.name or 'signal'}: {of.values:,} values at {of.rate:.9g} Hz, mean {of.mean:.6g}{unit}",
        f"  density           one-sided, {of.window} window, {of.segments} segments of {of.segment:,} values that"
        f" overlap by half; a line every {of.step:.4g} Hz, {of.noise_bandwidth:.4g} Hz wide",
        f"  rms               {of.rms(band):.6g}{unit} {where}",
    ]
    inside = of.within(band)
    if inside.any():
        lines.append(f"  median density    {np.median(of.amplitude_density[inside]):.6g} {of.density_unit} there")
    if slope is not None:
        lines.append(f"  slope             {slope:+.1f} dB a decade there")
    return "\n".join(lines)


def tone_text(measured: Tones | None, of: Spectrum) -> str:
    """The figures of a tone for people, if there is one."""
    if measured is None:
        return "no tone stands out"
    unit = f" {of.unit}" if of.unit != "1" else ""
    harmonics = f"{measured.thd:.2f} dB" if math.isfinite(measured.thd) else "no harmonic above the noise"
    lines = [
        f"tone at {measured.frequency:.9g} Hz ({of.window} window over all values)",
        f"  rms               {measured.rms:.6g}{unit}, noise {measured.noise:.6g}{unit}",
        f"  SNR, SNDR         {measured.snr:.2f} dB, {measured.sndr:.2f} dB",
        f"  THD               {harmonics}",
        f"  SFDR              {measured.sfdr:.2f} dB, by {measured.spur:.9g} Hz",
        f"  ENOB              {measured.enob:.2f} bits, if the tone fills the range",
    ]
    if measured.hidden:
        orders = ", ".join(map(str, measured.hidden))
        lines.append(
            f"  note: harmonics of order {orders} fold onto the tone or onto zero: THD, SNDR and ENOB leave them out;"
            " move the tone"
        )
    if measured.mirrored > _MIRRORED:
        lines.append(
            f"  note: {measured.cycles:.4g} cycles are so near zero or half the rate that the tone overlaps its image:"
            f" rms may be off by {100.0 * measured.mirrored:.2g} %; run longer, or take a window of fewer terms"
        )
    if not measured.coherent:
        nearest = max(1, round(measured.cycles)) * of.step
        leaked = (
            f" {measured.leaked:.3g}{unit} of it leaks out of the {of.window} window and counts as noise or harmonics;"
        )
        other = f" {TONE_WINDOW} leaks less, and" if of.window != TONE_WINDOW else ""
        lines.append(
            f"  note: {measured.cycles:.2f} cycles of the tone are not a whole number:"
            + (leaked + other if measured.leaks else "")
            + f" a tone of {nearest:.9g} Hz would be coherent"
        )
    return "\n".join(lines)
