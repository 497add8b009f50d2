"""The command `spectrum`: density, tone, SNR, THD, SFDR, ENOB and band rms of a signal."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.spectrum.plot import plot_spectrum
from proofmass.runner.analysis.spectrum.tones import Tones, tones
from proofmass.runner.analysis.spectrum.welch import Spectrum, spectrum
from proofmass.runner.commands.answers import print_file, print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.series_source import SignalRequest, band_of, quantity, signal_of
from proofmass.runner.output.pictures import save_figure

TONE_WINDOW = "blackman-harris-7"  # no tone of 24 bits leaks out of it


@dataclass(frozen=True)
class SpectrumRequest:
    """Request of `proofmass spectrum`."""

    signal: SignalRequest
    window: str
    segment: int | None
    band: tuple[str, str] | None
    tone: str
    picture: Path | None


def show_spectrum(request: SpectrumRequest) -> int:
    """Show the spectrum of a signal and return the exit code."""
    series, as_json = signal_of(request.signal), request.signal.as_json
    band = band_of(request.band)
    density = spectrum(series, window=request.window or "hann", segment=request.segment)
    whole = spectrum(series, window=request.window or TONE_WINDOW, segment=0)
    figures, none = _figures(whole, quantity("--tone", request.tone, "Hz") if request.tone else 0.0, band)
    if none and request.tone:
        raise none
    slope = density.slope(band) if band else None
    if as_json:
        data = density.as_data() | {"rms": density.rms(band), "band_hz": band, "slope_db_per_decade": slope}
        print_json(data | {"tone": figures.as_data() if figures else None})
    else:
        print_text(
            [spectrum_text(density, band, slope), tone_text(figures, whole) if figures else "no tone stands out"]
        )
    if request.picture is not None:
        print_file(save_figure(plot_spectrum(density, figures, band), request.picture), as_json)
    return DONE


def _figures(whole: Spectrum, tone: float, band: tuple[float, float] | None) -> tuple[Tones | None, ModelError | None]:
    try:
        return tones(whole, tone=tone, band=band), None
    except ModelError as error:
        return None, error


def spectrum_text(of: Spectrum, band: tuple[float, float] | None, slope: float | None) -> str:
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
        lines.append(f"  median density    {_median(of, inside):.6g} {of.density_unit} there")
    if slope is not None:
        lines.append(f"  slope             {slope:+.1f} dB a decade there")
    return "\n".join(lines)


def _median(of: Spectrum, lines: Any) -> float:
    return float(np.median(of.amplitude_density[lines]))


def tone_text(measured: Tones, of: Spectrum) -> str:
    """The figures of a tone for people."""
    unit = f" {of.unit}" if of.unit != "1" else ""
    lines = [
        f"tone at {measured.frequency:.9g} Hz ({of.window} window over all values)",
        f"  rms               {measured.rms:.6g}{unit}, noise {measured.noise:.6g}{unit}",
        f"  SNR, SNDR         {measured.snr:.2f} dB, {measured.sndr:.2f} dB",
        f"  THD               {measured.thd:.2f} dB",
        f"  SFDR              {measured.sfdr:.2f} dB, by {measured.spur:.9g} Hz",
        f"  ENOB              {measured.enob:.2f} bits, if the tone fills the range",
    ]
    if not measured.coherent:
        nearest = max(1, round(measured.cycles)) * of.step
        lines.append(
            f"  note: {measured.cycles:.2f} cycles of the tone are not a whole number:"
            + (" what leaks counts as noise; take another window, or" if of.window == "rectangular" else "")
            + f" a tone of {nearest:.9g} Hz would be coherent"
        )
    return "\n".join(lines)
