"""Noise budgets: the sources, their densities and shares, and what follows from them."""

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit
from proofmass.runner.analysis.allan.levels import Levels, matched
from proofmass.runner.analysis.margins.sensitivity import Sensitivity
from proofmass.runner.analysis.noise.derivatives import OneMore
from proofmass.runner.analysis.noise.prediction import allan_deviation
from proofmass.runner.analysis.noise.validity import Dither
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.host.notebook import Plotted, html_table
from proofmass.runner.output.json_text import finite

if TYPE_CHECKING:
    import pandas

ROWS = 20  # of sources that are shown
SMALL_MISFIT = 1.0  # dB, to which N, B and K describe a density
_TAUS = 8  # a decade
_LOW = 0.1  # of the rate, up to which coefficients are those of a slow signal
QUANTISATION, DROPPED = "quantisation", "rounding"  # of a converter, and of all places in a fixed-point block


@dataclass(frozen=True, eq=False)
class NoiseSource:
    """One source of noise: the part of the output that it makes."""

    block: str
    kind: str  # of the block, or quantisation
    rms: float  # in the band
    share: float  # of the mean square
    density: Array  # one-sided at the output, at the frequencies of the budget, in unit^2/Hz
    dither: Dither | None = None  # of a quantiser

    @property
    def doubtful(self) -> bool:
        """Return whether a quantiser is moved too little for its error to be noise."""
        return self.dither is not None and not self.dither.enough


_NAMED = 3  # sources in a line


@dataclass(frozen=True, eq=False, repr=False)
class NoiseBudget(Plotted):
    """The noise of an output by its sources, the largest first; densities are one-sided, in unit^2/Hz.

    >>> from proofmass import noise, read_graph
    >>> budget = noise(read_graph("library:recorded_motion"), "mean.mean", input="motion.output")
    >>> f"{budget.rms:.5f} {budget.unit}", budget.density.shape == budget.frequencies.shape
    ('0.00205 m/s^2', True)
    """

    output: str  # "block.port"
    unit: str  # of the output
    rate: float  # values of the output a second
    band: tuple[float, float]  # Hz
    sources: tuple[NoiseSource, ...]  # the largest first
    rms: float  # in the band
    frequencies: Array  # Hz
    density: Array  # one-sided at the output, at these frequencies, in unit^2/Hz
    input: str  # "block.port", or ""
    input_unit: str  # of the input
    gain: Complex  # from the input; empty without one
    period: float  # of the schedule, in seconds
    notes: tuple[str, ...]  # what the budget leaves out or takes for granted
    derivatives: Sensitivity | None = None  # of the rms by parameters, where wanted
    steps: tuple[OneMore, ...] = ()  # of integer parameters of quantisers, where wanted

    def __repr__(self) -> str:
        """The output, its noise in the band, and the largest sources, in a line."""
        largest = ", ".join(f"{100.0 * source.share:.1f} % {source.block}" for source in self.sources[:_NAMED])
        low, high = self.band
        noise = f"{in_print(self.rms, self.unit)} rms, {low:g} Hz to {high:g} Hz"
        return f"<NoiseBudget of {self.output}: {noise}; {largest or 'no sources'}>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a row for each source: block, kind, rms in the unit of the output, and share of the mean square."""
        need("pandas")
        # start-up time: pandas takes 0.5 s
        import pandas

        rows = [(source.block, source.kind, source.rms, source.share) for source in self.sources]
        return pandas.DataFrame(rows, columns=["source", "kind", f"rms [{self.unit}]", "share"])

    def _repr_html_(self) -> str:
        low, high = self.band
        caption = f"noise of {self.output}, {low:g} Hz to {high:g} Hz: {in_print(self.rms, self.unit)} rms"
        rows = [(s.block, s.kind, in_print(s.rms, self.unit), f"{100.0 * s.share:.2f} %") for s in self.sources]
        return html_table(("source", "kind", "rms", "share"), rows, caption, [f"note: {note}" for note in self.notes])

    @property
    def referred_unit(self) -> str:
        """Unit of the figures: of the input they refer to, or of the output without one."""
        return self.input_unit if self.input else self.unit

    @property
    def referred_density(self) -> Array:
        """Density at the input that would make the same; that of the output without an input."""
        return self.density / np.abs(self.gain) ** 2 if self.input else self.density

    @property
    def levels(self) -> Levels:
        """N, B, K and Q that come closest to the density that is referred to the input, up to a tenth of the rate."""
        lines = (self.density > 0.0) & (self.frequencies <= max(_LOW * self.rate, 4.0 * self.frequencies[0]))
        return matched(self.frequencies[lines], self.referred_density[lines], 1.0 / self.rate)

    def allan(self) -> tuple[Array, Array]:
        """Averaging times, and the Allan deviation that the density referred to the input makes."""
        least = max(1.0, 0.5 * self.rate / self.frequencies[-1])  # a density up to f says nothing of shorter times
        most = max(2.0 * least, 0.1 / self.frequencies[0] * self.rate)
        factors = np.unique(np.round(np.geomspace(least, most, int(_TAUS * math.log10(most / least)) + 2)))
        taus = np.asarray(factors / self.rate, dtype=np.float64)
        positive = self.density > 0.0
        known = self.frequencies[positive], self.referred_density[positive]
        return taus, allan_deviation(*known, 1.0 / self.rate, taus)

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        taus, deviations = self.allan()
        levels, unit = self.levels, self.referred_unit
        return {
            "output": self.output,
            "unit": self.unit,
            "rate_hz": self.rate,
            "band_hz": list(self.band),
            "rms": self.rms,
            "sources": [
                {
                    "block": source.block,
                    "kind": source.kind,
                    "rms": source.rms,
                    "share": source.share,
                    "density": source.density.tolist(),
                    **(
                        {"moved_steps": finite(source.dither.change), "doubtful": source.doubtful}
                        if source.dither
                        else {}
                    ),
                }
                for source in self.sources
            ],
            "frequencies_hz": self.frequencies.tolist(),
            "density": self.density.tolist(),
            "input": self.input or None,
            "referred_unit": unit,
            "referred_density": self.referred_density.tolist(),
            "coefficients": {
                level.name: {
                    "value": level.value,
                    "field_value": in_field_unit(level.name, level.value, unit),
                    "field_unit": field_unit(level.name, unit),
                }
                for level in levels.levels
            },
            "misfit_db": levels.misfit,
            "allan": {"tau_s": taus.tolist(), "deviation": deviations.tolist()},
            "notes": list(self.notes),
            **({"derivatives": self.derivatives.as_data()} if self.derivatives else {}),
            **({"one_more": [asdict(step) for step in self.steps]} if self.steps else {}),
        }
