"""Claims about all sensors of a box, each as a family of matrices whose poles all lie in a disc.

- stable, gain margin, phase margin: the disc is that of radius 1, for all factors between two ends at the wire.
- decay rate s: it has the radius exp(-s T), for a period of T.
- disk margin a: the same as stable, for all complex factors (2 + a d) / (2 - a d), |d| <= 1 (`closed_loop`).
- under any change of the parameters from period to period: one norm serves the whole box.
- under slow change: each part of the box has its norm, and keeps it long enough (`passages`).
- noise x: a norm in which the disc holds bounds the rms too (`noise_norm`).
- peak x: the matrix has the input and the output, divided by x, besides, and the norm leaves both as they are.
- scale factor g: with the map at rest beside that of the poles, the disc is the same (`at_rest`).
- delay margin: a delay of at most M samples turns what has the frequency -w by p = w m, m <= M. So for no turn p from 0
  to 2 pi may a pole lie at exp(-j w) with w from p / M to pi. All poles may lie in any disc that leaves out this arc.
- in continuous time the circle is the imaginary axis: discs are half planes, and the arc goes from
-j p / M on.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from proofmass.blocks.declaration.shown_units import in_print
from proofmass.runner.design.proof.at_rest import scale_factors
from proofmass.runner.design.proof.closed_loop import Disc, Family, OpenCorners, closed_loops, through, with_disk
from proofmass.runner.design.proof.contraction import Norm
from proofmass.runner.design.proof.half_plane import HalfPlane, PoleRegion
from proofmass.runner.design.proof.noise_norm import norm_of_noise, rms_at_corners
from proofmass.runner.design.proof.rest_norm import Start, norm_at_rest
from proofmass.runner.design.proof.wire_factors import GAIN, PHASE, Factor
from proofmass.runner.host.arrays import Array

_Family = Callable[[OpenCorners, tuple[float, float]], Family]
_FindNorm = Callable[[OpenCorners, float, Start | None], Norm | None]
_OF_GAIN, _OF_PHASE = partial(closed_loops, GAIN), partial(closed_loops, PHASE)


@dataclass(frozen=True)
class ClaimKind:
    """A kind of claim: what lies in a disc, how a norm is found, which values refute it."""

    unit: str | None  # of its limit; None: that of the output that it is about
    factor: str = GAIN.name  # the name of the family, for certificates
    family: _Family = _OF_GAIN
    wire: Factor = GAIN  # the factors of a loop
    norm: _FindNorm | None = None  # else that of the family
    usual: float | None = None  # limit of what nobody gives one for
    looks: bool = True  # the middle of a box is asked whether it breaks the claim: its poles alone do not say so
    beside: bool = False  # poles may lie in the disc, and the claim be broken all the same
    at_corners: Callable[[OpenCorners], Array] | None = None  # the quantity at the corners of a box
    stays: bool = False  # only of parameters that stay: under changes there is no such claim
    enters: bool = False  # what comes in counts all the time: its sum has a bound in one norm
    room: float = 0.01  # least part of the value by which a bound that is looked for lies beyond it
    nowhere: str = "it has no bound"  # of a sensor without such a value

    @property
    def of_output(self) -> bool:
        """True if it is about a quantity of an output, not about a loop."""
        return self.unit is None


_AT_REST = ClaimKind(
    None, "rest", norm=norm_at_rest, at_corners=scale_factors, stays=True, room=1e-6, nowhere="it does not settle"
)
SCALE_FACTOR, BIAS, RMS, PEAK = "scale factor", "bias", "noise", "peak"
KINDS = {
    "stable": ClaimKind("", looks=False),
    "gain margin": ClaimKind("dB", usual=6.0, looks=False),
    "phase margin": ClaimKind("deg", PHASE.name, _OF_PHASE, PHASE, usual=45.0, looks=False),
    "disk margin": ClaimKind("1", "disk", with_disk, beside=True),
    "delay margin": ClaimKind("s", PHASE.name, _OF_PHASE, PHASE, stays=True),
    "decay rate": ClaimKind("1/s", looks=False),
    SCALE_FACTOR: _AT_REST,
    BIAS: _AT_REST,
    RMS: ClaimKind(None, "noise", norm=norm_of_noise, at_corners=rms_at_corners, enters=True),
    PEAK: ClaimKind(None, "peak", through, beside=True, enters=True),
}
_LESS = 1.0 - 1e-14  # more than the rounding of a radius
_MORE = 1.0 + 1e-15
_REACHES = (0.0, 0.1, 0.5, 1.0, 2.0, 8.0)  # of a disc's centre from the circle's


@dataclass(frozen=True)
class Claim:
    """A claim about all sensors: a loop has at least some margin or decay rate, or a quantity keeps a limit."""

    loop: str  # its name; of a quantity the input, if it has one
    open_at: str  # of a quantity the output
    kind: str  # a key of `KINDS`
    limit: float  # in the unit of the kind; 0 for "stable"
    period: float = 0.0  # s, of the loop
    most: bool = False  # the quantity is at most the limit, not at least
    unit_of_quantity: str = ""
    any_change: bool = False  # the parameters may have others of their values in each period
    changes: tuple[float, ...] = ()  # or each coordinate may move by so much from one to the next, or in a second
    at_rest: bool = False  # where the sensor rests, or on its orbit, not at the start of the run
    orbit: float = 0.0  # s, of the orbit, if it does not stand still there
    continuous: bool = False  # of a loop among continuous blocks, which has no period

    @property
    def row(self) -> ClaimKind:
        """Its row in the table of kinds."""
        return KINDS[self.kind]

    @property
    def moves(self) -> bool:
        """True if parameters need not stay as they are."""
        return self.any_change or bool(self.changes)

    @property
    def in_one_norm(self) -> bool:
        """True if one norm has to serve all of the tolerances."""
        return self.any_change or (bool(self.changes) and (self.row.enters or self.continuous))

    @property
    def in_parts(self) -> bool:
        """True if parts of the tolerances have norms that follow each other."""
        return bool(self.changes) and not self.in_one_norm

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest factor; of a phase, negative ones follow."""
        if self.kind == "phase margin":
            return 0.0, math.nextafter(math.radians(self.limit), math.inf)
        if self.kind == "delay margin":
            turns = 2.0 if self.continuous else min(2.0, self.limit / self.period)
            return 0.0, turns * math.pi * _MORE
        if self.kind == "disk margin" or self.row.of_output:
            return self.limit, self.limit
        if self.kind != "gain margin":
            return 1.0, 1.0
        factor = 10.0 ** (self.limit / 20.0) * _MORE
        return 1.0 / factor * (1.0 - 1e-15), factor

    def discs(self, factors: tuple[float, float]) -> Sequence[PoleRegion]:
        """Return discs in one of which all poles have to lie, with factors between two ends.

        In continuous time these are half planes.
        """
        if self.continuous and self.kind == "delay margin" and factors[0] > 0.0:
            return [HalfPlane(imaginary=-factors[0] / self.limit * _LESS, tilt=reach) for reach in _REACHES]
        if self.continuous:
            return [HalfPlane(real=-self.limit if self.kind == "decay rate" else 0.0)]
        if self.kind == "decay rate":
            return [Disc(0.0, 0.0, math.exp(-self.limit * self.period) * _LESS)]
        if self.kind == "delay margin" and factors[0] > 0.0:
            least = factors[0] / (self.limit / self.period)
            return [_beside(least, reach) for reach in _REACHES]
        return [Disc(0.0, 0.0, 1.0)]

    @property
    def unit(self) -> str:
        """The unit of the limit, "" for "stable", which has none."""
        return self.unit_of_quantity if self.row.unit is None else self.row.unit

    @property
    def about(self) -> str:
        """The loop, or the way of the quantity."""
        return " to ".join(filter(None, (self.loop, self.open_at))) if self.row.of_output else self.loop

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
        at_rest = self.at_rest and (self.kind != BIAS or self.orbit > 0.0)
        where = f" on an orbit of {in_print(self.orbit, 's', 6)}" if self.orbit else " at rest"
        return self._words + where * at_rest + f" under {'any' if self.any_change else 'slow'} change" * self.moves

    @property
    def _words(self) -> str:
        if self.row.of_output and not math.isfinite(self.limit):
            return f"{self.kind}, {'upper' if self.most else 'lower'} bound"
        if self.row.of_output:
            return f"{self.kind} of at {'most' if self.most else 'least'} {in_print(self.limit, self.unit, 12)}"
        if self.unit in ("dB", "deg"):
            return f"{self.kind} of at least {self.limit:g} {self.unit}"
        return f"{self.kind} of at least {in_print(self.limit, self.unit, 6)}" if self.unit else self.kind


def _beside(least: float, reach: float) -> Disc:
    """Return a disc that leaves out the circle from the angle -pi to -`least`."""
    turned = 0.5 * (math.pi - least)
    radius = math.sqrt(1.0 + reach * reach + 2.0 * reach * math.sin(0.5 * least))
    return Disc(reach * math.cos(turned), reach * math.sin(turned), radius * _LESS)
