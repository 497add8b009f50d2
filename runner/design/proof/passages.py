"""Parameters that change slowly: each part of a box keeps its norm, and what counts is how often
one follows another.

From one period to the next a coordinate q_i moves by at most d_i; one with d_i = 0, as the factor
at the wire, stays. The cores C_k of the parts cover the box. Each lies in a larger box B_k, all
matrices of which shorten every vector in a norm: |A x|_k <= r_k |x|_k. Take the norm of a core that
q is in, and keep it until q leaves its box. Then q is in another core C_m that lies beyond an end
of B_k. On the way to that end, h_i from C_k, there were at least

    N = floor(h_i / d_i) + 1

periods. If |x|_m <= g |x|_k, and g r_k^N < 1 for all such k and m, then a part that is left after
n >= N periods leaves g r_k^n <= s^n of what there was, with s < 1 the largest (g r_k^N)^(1/N) or
r_k. So all decays, |x[n]| <= c s^n |x[0]|.

It is the argument of a dwell time (Morse, IEEE Transactions on Automatic Control 41, 1996, 1413;
Liberzon, Switching in Systems and Control, 2003, section 3.2), which the overlap ensures. For slow
changes it is Desoer's (Electronics Letters 6, 1970, 339). Of a coordinate that stays, the parts
count that reach to one side of it: they cover all others as well.
"""

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from proofmass.runner.design.proof.contraction import growth_of
from proofmass.runner.design.proof.coordinates import ProvedRegion, Sides

_ROOM = 1e-9  # of the logarithm by which a norm has to shorten more than the next one lengthens
Passage = tuple[ProvedRegion, ProvedRegion]


def too_soon(regions: Sequence[ProvedRegion], changes: Sequence[float], radius: float) -> list[Passage]:
    """Return the regions that others may follow before they shorten by more than these lengthen.

    All poles have to lie within a `radius`.
    """
    return [
        (one, other)
        for one, other in itertools.permutations(regions, 2)
        if not np.array_equal(one.transform, other.transform)
        and (periods := _periods(one, other, changes))
        and not math.log(growth_of(one.transform, other.transform))
        + periods * math.log(one.disc.radius / radius * (1.0 + 2.0**-50))
        < -_ROOM
    ]


def _periods(one: ProvedRegion, other: ProvedRegion, changes: Sequence[float]) -> int:
    """Return how many periods a region keeps its norm before another follows, 0 if it cannot."""
    periods = list[int]()
    for own, core, there, change in zip(one.box, one.core, other.core, (*changes, 0.0), strict=True):
        apart = Fraction(max(own[0], there[0])) - Fraction(min(own[1], there[1]))
        if apart > Fraction(change) or (apart == 0 and not change and own != there):
            return 0
        rooms = [core[0] - own[0]] * (there[0] < own[0]) + [own[1] - core[1]] * (there[1] > own[1])
        periods += [math.floor(room / change * (1.0 - 2.0**-50)) + 1 for room in rooms if change]
    return min(periods, default=0)


def halved_places(passages: Sequence[Passage], whole: Sides) -> dict[Sides, int]:
    """Return the cores to halve for passages that come too soon, the larger one of both, and along which coordinate."""
    places: dict[Sides, int] = {}
    for passage in passages:
        cores = [region.core for region in passage]
        widths = np.array([[_part(side, all_) for side, all_ in zip(core, whole, strict=True)] for core in cores])
        middles = [[low + high for low, high in core] for core in cores]
        apart = [_part(sorted(ends), all_) for ends, all_ in zip(zip(*middles, strict=True), whole, strict=True)]
        place = int(np.argmax(apart))
        for core, width in zip(cores, widths[:, place], strict=True):
            if width >= widths[:, place].max():
                places.setdefault(core, place)
    return places


def _part(side: Sequence[float], whole: Sequence[float]) -> float:
    return (side[1] - side[0]) / (whole[1] - whole[0]) if whole[1] > whole[0] else 0.0
