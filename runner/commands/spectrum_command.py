"""The command `spectrum`: density, tone, SNR, THD, SFDR, ENOB and band rms of a signal."""

from dataclasses import dataclass
from pathlib import Path

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.spectrum.plot import plot_spectrum
from proofmass.runner.analysis.spectrum.text import TONE_WINDOW, spectrum_text, tone_text
from proofmass.runner.analysis.spectrum.tones import Tones, tones
from proofmass.runner.analysis.spectrum.welch import Spectrum, spectrum
from proofmass.runner.commands.answers import print_file, print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.series_source import SignalRequest, band_of, quantity, signal_of
from proofmass.runner.output.pictures import save_figure


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
