"""The command `spectrum`: density, tone, SNR, THD, SFDR, ENOB and band rms of a signal."""

from functools import partial
from typing import Any

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.spectrum.plot import plot_spectrum
from proofmass.runner.analysis.spectrum.series import Series
from proofmass.runner.analysis.spectrum.text import TONE_WINDOW, spectrum_text, tone_text
from proofmass.runner.analysis.spectrum.tones import Tones, tones
from proofmass.runner.analysis.spectrum.welch import Spectrum, spectrum
from proofmass.runner.commands.answers import Shown
from proofmass.runner.commands.declarations.analysis import SpectrumRequest
from proofmass.runner.commands.series_source import answers_about, band_of, quantity


def show_spectrum(request: SpectrumRequest) -> int:
    """Show the spectra of signals and return the exit code."""
    return answers_about(request, request.picture, partial(_answered, request))


def _answered(request: SpectrumRequest, series: Series) -> Shown:
    band = band_of(request.band)
    density = spectrum(series, window=request.window or "hann", segment=request.segment)
    whole = spectrum(series, window=request.window or TONE_WINDOW, segment=0)
    figures, none = _figures(whole, quantity("--tone", request.tone, "Hz") if request.tone else 0.0, band)
    if none and request.tone:
        raise none
    slope = density.slope(band) if band else None
    more: dict[str, Any] = {"rms": density.rms(band), "band_hz": band, "slope_db_per_decade": slope}
    more |= {"tone": figures.as_data() if figures else None}
    lines = [spectrum_text(density, band, slope), tone_text(figures, whole)]
    picture = partial(plot_spectrum, density, figures, band)
    return Shown(series.name, lines, lambda: density.as_data() | more, picture)


def _figures(whole: Spectrum, tone: float, band: tuple[float, float] | None) -> tuple[Tones | None, ModelError | None]:
    try:
        return tones(whole, tone=tone, band=band), None
    except ModelError as error:
        return None, error
