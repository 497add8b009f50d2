"""Claims about all sensors of a box, each as a family of matrices whose poles all lie in a disc.

- stable, gain margin, phase margin: the disc is that of radius 1, for all factors between two ends at the wire.
- decay rate s: it has the radius exp(-s T), for a period of T.
- disk margin a: the same as stable, for all complex factors (2 + a d) / (2 - a d), |d| <= 1 (`closed_loop`).
- under any change of the parameters from period to period: one norm serves the whole box.
- noise x: a norm in which the disc holds bounds the rms too (`noise_norm`).
- peak x: the matrix has the input and the output, divided by x, besides, and the norm leaves both as they are.
- scale factor g: with the map at rest beside that of the poles, the disc is the same (`at_rest`).
- delay margin: a delay of at most M samples turns what has the frequency -w by p = w m, m <= M. So for no turn p from 0
  to 2 pi may a pole lie at exp(-j w) with w from p / M to pi. All poles may lie in any disc that leaves out this arc.
"""

import math
from dataclasses import dataclass

from proofmass.blocks.declaration.shown_units import in_print
from proofmass.runner.design.proof.closed_loop import DISK, GAIN, NOISE, PHASE, REST, THROUGH, Disc, Factor

UNITS = {
    "stable": "",
    "gain margin": "dB",
    "phase margin": "deg",
    "disk margin": "1",
    "delay margin": "s",
    "decay rate": "1/s",
}
SCALE_FACTOR, RMS, PEAK = "scale factor", "noise", "peak"
AT_CORNERS = (SCALE_FACTOR, RMS)  # whose values at the corners of a box are looked at
QUANTITIES = (*AT_CORNERS, PEAK)  # of outputs, not of loops: their units are those of the outputs
_FACTORS = {"phase margin": PHASE, "delay margin": PHASE, "disk margin": DISK}
_FACTORS |= {SCALE_FACTOR: REST, RMS: NOISE, PEAK: THROUGH}  # of others GAIN
_LESS = 1.0 - 1e-14  # more than the rounding of a radius
_MORE = 1.0 + 1e-15
_REACHES = (0.0, 0.1, 0.5, 1.0, 2.0, 8.0)  # distances of the centre of a disc from that of the circle


@dataclass(frozen=True)
class Claim:
    """A claim about all sensors: a loop has at least some margin or decay rate, or a quantity keeps a limit."""

    loop: str  # its name; of a quantity the input, if it has one
    open_at: str  # of a quantity the output
    kind: str  # a key of `UNITS`, or one of `QUANTITIES`
    limit: float  # in the unit of the kind; 0 for "stable"
    period: float = 0.0  # s, of the loop
    most: bool = False  # the quantity is at most the limit, not at least
    unit_of_quantity: str = ""
    any_change: bool = False  # the parameters may have others of their values in each period

    @property
    def factor(self) -> Factor:
        """The factors at the wire."""
        return _FACTORS.get(self.kind, GAIN)

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest factor; of a phase, negative ones follow from the positive ones."""
        if self.kind == "phase margin":
            return 0.0, math.nextafter(math.radians(self.limit), math.inf)
        if self.kind == "delay margin":
            return 0.0, min(2.0, self.limit / self.period) * math.pi * _MORE
        if self.kind in ("disk margin", *QUANTITIES):
            return self.limit, self.limit
        if self.kind != "gain margin":
            return 1.0, 1.0
        factor = 10.0 ** (self.limit / 20.0) * _MORE
        return 1.0 / factor * (1.0 - 1e-15), factor

    def discs(self, factors: tuple[float, float]) -> list[Disc]:
        """Return discs in one of which all poles have to lie, with factors between two ends."""
        if self.kind == "decay rate":
            return [Disc(0.0, 0.0, math.exp(-self.limit * self.period) * _LESS)]
        if self.kind == "delay margin" and factors[0] > 0.0:
            least = factors[0] / (self.limit / self.period)
            return [_beside(least, reach) for reach in _REACHES]
        return [Disc(0.0, 0.0, 1.0)]

    @property
    def unit(self) -> str:
        """The unit of the limit, "" for "stable", which has none."""
        return UNITS.get(self.kind, self.unit_of_quantity)

    @property
    def about(self) -> str:
        """The loop, or the way of the quantity."""
        return " to ".join(filter(None, (self.loop, self.open_at))) if self.kind in QUANTITIES else self.loop

    @property
    def sign(self) -> float:
        """1 where the limit is a lower one, -1 where it is an upper one."""
        return -1.0 if self.most else 1.0

    def broken_by(self, value: float) -> bool:
        """Return whether a value lies beyond the limit."""
        return self.sign * (value - self.limit) < 0.0

    def shown(self, value: float) -> str:
        """Return a margin or rate with its unit."""
        return f"{value:.4g} {self.unit}" if self.unit in ("dB", "deg") else in_print(value, self.unit)

    def rounded(self, limit: float) -> float:
        """Return a limit rounded down: hundredths of dB and deg, else four digits."""
        digits = 2 if self.unit in ("dB", "deg") or not limit > 0.0 else 3 - math.floor(math.log10(limit))
        scale = 10.0**digits
        return math.floor(limit * scale) / scale

    def __str__(self) -> str:
        """The claim in words."""
        return self._words + (" under any change" if self.any_change else "")

    @property
    def _words(self) -> str:
        if self.kind in QUANTITIES and not math.isfinite(self.limit):
            return f"{self.kind}, {'upper' if self.most else 'lower'} bound"
        if self.kind in QUANTITIES:
            return f"{self.kind} of at {'most' if self.most else 'least'} {in_print(self.limit, self.unit, 12)}"
        if self.unit in ("dB", "deg"):
            return f"{self.kind} of at least {self.limit:g} {self.unit}"
        return f"{self.kind} of at least {in_print(self.limit, self.unit, 6)}" if self.unit else self.kind


def _beside(least: float, reach: float) -> Disc:
    """Return a disc that leaves out the circle from the angle -pi to -`least`."""
    turned = 0.5 * (math.pi - least)
    radius = math.sqrt(1.0 + reach * reach + 2.0 * reach * math.sin(0.5 * least))
    return Disc(reach * math.cos(turned), reach * math.sin(turned), radius * _LESS)
