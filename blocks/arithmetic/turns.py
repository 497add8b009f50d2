"""Sine and cosine of turns.

A quarter wave is sin(pi v / 2) = v + v (1 - v^2) (1/2 + T(v^2)) for |v| <= 1, where T is the
minimax polynomial of degree 7 (Remez exchange on the relative error, 3e-19). The form is exact at
v = 0 and v = +-1, and the rounding of T counts little.
"""

from proofmass.blocks.arithmetic.rounding import nearest_integer


def sine_of_turns(turns: float) -> float:
    """sin(2 pi turns) for |turns| < 2^51: odd, exact at every quarter turn, within 1.3 ulp.

    >>> sine_of_turns(0.25), sine_of_turns(1000000.5), sine_of_turns(-0.25)
    (1.0, 0.0, -1.0)
    """
    part = turns - nearest_integer(turns)
    folded = 0.5 - part if part > 0.25 else part
    return _quarter_wave(-0.5 - part if part < -0.25 else folded)


def cosine_of_turns(turns: float) -> float:
    """cos(2 pi turns) for |turns| < 2^51: even, exact at every quarter turn, within 1.6 ulp.

    >>> cosine_of_turns(0.0), cosine_of_turns(0.25), cosine_of_turns(-0.5)
    (1.0, 0.0, -1.0)
    """
    part = turns - nearest_integer(turns)
    return _quarter_wave(0.25 - (part if part > 0.0 else -part))


def _quarter_wave(turns: float) -> float:
    """sin(2 pi turns), |turns| <= 1/4."""
    v = 4.0 * turns
    z = v * v
    series = 6.625480755620428e-10 + z * -5.865913567797292e-12
    series = 3.542584211853992e-06 + z * (-5.6258772136143375e-08 + z * series)
    series = 0.004524855534815574 + z * (-0.00015689860048452697 + z * series)
    series = 0.07079632679489661 + z * (-0.07516777071134956 + z * series)
    bent = v * (1.0 - z)
    return v + (0.5 * bent + bent * series)
