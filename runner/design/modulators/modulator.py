"""The design of a sigma-delta modulator: from order, oversampling and gain to coefficients, ratios and a graph."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import did_you_mean, shown
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.call_numbers import positive, refuse_counts
from proofmass.graphs.model.rates import Rate
from proofmass.runner.design.modulators.graph import modulator_graph
from proofmass.runner.design.modulators.noise_transfer import MOST_ORDER, NoiseTransfer, band, refused, synthesised
from proofmass.runner.design.modulators.prediction import predicted
from proofmass.runner.design.modulators.simulation import (
    MOST_SAMPLES,
    SAMPLES,
    enough_samples,
    noise_lines,
    simulated,
    tone_frequency,
)
from proofmass.runner.design.modulators.structures import FORMS, Coefficients, Structure, realised, scaled
from proofmass.runner.host.notebook import Plotted, Told

DECIBELS = (-80.0, -60.0, -40.0, -20.0, -10.0, -8.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0)
FEEDS = ("first", "all")


@dataclass(frozen=True, eq=False, repr=False)
class Modulator(Told, Plotted):
    """A sigma-delta modulator: noise transfer function, loop filter, and signal to noise ratios over amplitude.

    >>> from proofmass import design_modulator
    >>> loop = design_modulator(3, 64, form="CIFF", pulse=(0.0, 1.0), samples=4096)
    >>> loop.graph("3.072 MHz").values["clock"].written
    '3.072 MHz'
    """

    order: int  # of the loop filter
    oversampling: float  # the rate over twice the band
    gain: float  # of the noise, far from the band; where zeros have moved that which they leave
    centre: float  # of the band, relative to the rate; 0 for a low pass
    levels: int  # of the quantiser, from -1 to 1
    structure: Structure  # the form of the loop filter, and the pulse of a continuous one
    transfer: NoiseTransfer  # the noise transfer function that the form has
    coefficients: Coefficients  # of the loop filter, scaled
    amplitudes: tuple[float, ...]  # at which there are ratios, in dB of full scale
    predicted: tuple[float | None, ...]  # signal to noise ratios in dB; None in overload
    simulated: tuple[float | None, ...]  # signal to noise ratios in dB; None where it was lost
    stable_limit: float  # the amplitude at which overload begins, predicted; 1 is full scale
    swings: tuple[float, ...]  # the largest value of each state, up to the amplitude of the peak; NaN without one

    @property
    def band(self) -> tuple[float, float]:
        """The ends of the band, relative to the rate."""
        return band(self.oversampling, self.centre)

    @property
    def peak(self) -> tuple[float, float]:
        """Amplitude of the largest simulated ratio, in dB of full scale, and that ratio in dB."""
        ratio, amplitude = max(_known(self.amplitudes, self.simulated), default=(math.nan, math.nan))
        return amplitude, ratio

    def graph(self, rate: Rate = "1 MHz") -> Graph:
        """Return a graph of the modulator at a `rate`, with a sine of half scale; its coefficients are named values."""
        return modulator_graph(self.structure, self.coefficients, self.levels, self.band, rate)

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "order": self.order,
            "oversampling": self.oversampling,
            "gain": self.gain,
            "centre": self.centre,
            "levels": self.levels,
            "form": self.structure.form,
            "pulse": self.structure.pulse,
            "band": self.band,
            "zeros": [[z.real, z.imag] for z in self.transfer.zeros],
            "poles": [[p.real, p.imag] for p in self.transfer.poles],
            "coefficients": asdict(self.coefficients),
            "amplitudes": self.amplitudes,
            "predicted": self.predicted,
            "simulated": self.simulated,
            "stable_limit": self.stable_limit,
            "swings": self.swings,
            "peak": {"amplitude": self.peak[0], "ratio": self.peak[1]},
        }


def design_modulator(
    order: int,
    oversampling: float,
    *,
    gain: float = 1.5,
    zeros: str = "optimised",
    form: str = "CRFB",
    centre: float = 0.0,
    levels: int = 2,
    feeds: str = "first",
    pulse: tuple[float, float] | None = None,
    swing: float | None = 1.0,
    samples: int | None = None,
) -> Modulator:
    """Return a sigma-delta modulator of an `order` for an `oversampling` ratio, the rate over twice the band.

    `gain` is that of the noise far from the band: 1.5 is stable with one bit, more of it with more
    levels. `zeros` are "optimised" for the least noise in the band, "centred" (so, with two of an
    even number at its centre), or "none". `form` is CIFB, CRFB, CIFF or CRFF. `centre` of a band
    pass is relative to the rate; its order is even. `levels` are those of the quantiser. `feeds`
    says which states take the input, the "first" or "all". With a `pulse`, begin and end of that of
    the converter in periods, the loop filter is one of continuous time, which sees the same at
    every decision (impulse invariance); (0, 1) is the full period. States are scaled to a `swing`
    at the amplitude of the peak, or not at all if it is None, or there is none. `samples` are those of
    each run, a multiple of which the tone fits: 16,384, or more where the band is narrow, unless said.

    Raises `ModelError` for what cannot be designed.

    >>> from proofmass import design_modulator
    >>> loop = design_modulator(5, 32, swing=None, samples=4096)
    >>> [round(a, 4) for a in loop.coefficients.a], loop.coefficients.g[1] > 0.0078
    ([0.0007, 0.0084, 0.055, 0.2443, 0.5579], True)
    """
    given = SAMPLES if samples is None else samples
    refuse_counts(order=(order, 1, MOST_ORDER), levels=(levels, 2, 65536), samples=(given, 1024, MOST_SAMPLES))
    _refuse(form, feeds, pulse, centre)
    if not (swing is None or positive(swing)):
        raise refused("must be finite and above 0", "swing", shown(swing), "the largest value of a state, or None")
    wanted = synthesised(order, oversampling, gain, zeros, centre)
    structure = Structure(form, order, pulse)
    transfer, k = structure.reachable(wanted), realised(wanted, structure, feeds, centre)
    if transfer != wanted:
        gain = float(abs(transfer.at(0.5)))  # of zeros outside the unit circle, which low passes alone have
    sizes = tuple(10.0 ** (decibel / 20.0) for decibel in DECIBELS)
    inside = band(oversampling, centre)
    count = enough_samples(SAMPLES, inside) if samples is None else samples
    _refuse_few(count, oversampling, inside)
    ratios, limit = predicted(transfer, inside, sizes, levels)
    runs = simulated(structure, k, inside, sizes, levels, count)
    known = _known(DECIBELS, runs.ratios)
    swings = runs.swings[: DECIBELS.index(max(known)[1]) + 1].max(axis=0) if known else np.full(order, math.nan)
    if swing is not None and known:
        k, swings = scaled(structure, k, (swings / swing).tolist()), 0.0 * swings + swing
    of = order, oversampling, gain, centre, levels, structure, transfer, k
    return Modulator(*of, DECIBELS, ratios, runs.ratios, limit, tuple(swings.tolist()))


def _known(amplitudes: Sequence[float], ratios: Sequence[float | None]) -> list[tuple[float, float]]:
    return [(ratio, amplitude) for amplitude, ratio in zip(amplitudes, ratios, strict=True) if ratio is not None]


def _refuse_few(samples: int, oversampling: float, inside: tuple[float, float]) -> None:
    """Raise `ModelError` where the band has no line of a run beside the tone: no ratio could be told."""
    if noise_lines(samples, tone_frequency(samples, inside), inside)[1].any():
        return
    enough = enough_samples(samples, inside)
    if enough > samples:
        message = "too few for a tone and noise in the band"
        raise refused(message, "samples", f"{samples:,}", f"at least {enough:,}")
    message, most = "leaves too narrow a band for runs", f"at most {MOST_SAMPLES >> 4:,}"
    raise refused(message, "oversampling", f"{oversampling:g}", most)


def _refuse(form: str, feeds: str, pulse: tuple[float, float] | None, centre: float) -> None:
    if form not in FORMS:
        raise refused("must be a form", "form", form, ", ".join(FORMS), did_you_mean(form, FORMS, "forms"))
    if feeds not in FEEDS or (feeds == "all" and pulse):
        expected = "first" if pulse else ", ".join(FEEDS)
        raise refused("must be a way to feed the input", "feeds", feeds, expected)
    if pulse and not 0.0 <= pulse[0] < pulse[1] <= 1.0:
        got = f"{pulse[0]:g} to {pulse[1]:g}"
        raise refused("must lie within one period", "pulse", got, "0 <= begin < end <= 1")
    if centre and form.startswith("CI") and not pulse:
        message = "cannot be a band pass: its zeros leave the unit circle"
        raise refused(message, "form", form, hint=f"take CR{form[2:]}")
