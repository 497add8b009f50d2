"""Elementary functions in plain arithmetic: the same bits in every engine, on every machine; they vectorise.

A quarter wave is sin(pi v / 2) = v + v (1 - v^2) (1/2 + T(v^2)) for |v| <= 1, where T is the minimax polynomial of
degree 7 (Remez exchange on the relative error, 3e-19). The form is exact at v = 0 and v = +-1, and the rounding of T
counts little. The logarithm is 2 atanh(s), s = (m - 1)/(m + 1), about the powers of two. The errors stated are the
largest of 10^7 arguments each against 64-bit mantissas: 1.22, 1.54 and 0.84 ulp.
"""

from proofmass.blocks.rounding import round_half_even


def sine_of_turns(turns: float) -> float:
    """sin(2 pi turns) for |turns| < 2^51: odd, exact at every quarter turn, within 1.3 ulp.

    >>> sine_of_turns(0.25), sine_of_turns(1000000.5), sine_of_turns(-0.25)
    (1.0, 0.0, -1.0)
    """
    part = turns - round_half_even(turns)
    folded = 0.5 - part if part > 0.25 else part
    return _quarter_wave(-0.5 - part if part < -0.25 else folded)


def cosine_of_turns(turns: float) -> float:
    """cos(2 pi turns) for |turns| < 2^51: even, exact at every quarter turn, within 1.6 ulp.

    >>> cosine_of_turns(0.0), cosine_of_turns(0.25), cosine_of_turns(-0.5)
    (1.0, 0.0, -1.0)
    """
    part = turns - round_half_even(turns)
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


def logarithm_of_fraction(value: float) -> float:
    """Natural logarithm for 2^-64 <= value <= 1, within 0.9 ulp.

    >>> logarithm_of_fraction(0.5), logarithm_of_fraction(1.0)
    (-0.6931471805599453, 0.0)
    """
    m, exponent = value, 0.0
    small = m < 2.3283064365386963e-10
    m, exponent = m * 4294967296.0 if small else m, exponent - 32.0 if small else exponent
    small = m < 1.52587890625e-05
    m, exponent = m * 65536.0 if small else m, exponent - 16.0 if small else exponent
    small = m < 0.00390625
    m, exponent = m * 256.0 if small else m, exponent - 8.0 if small else exponent
    small = m < 0.0625
    m, exponent = m * 16.0 if small else m, exponent - 4.0 if small else exponent
    small = m < 0.25
    m, exponent = m * 4.0 if small else m, exponent - 2.0 if small else exponent
    small = m < 0.5
    m, exponent = m * 2.0 if small else m, exponent - 1.0 if small else exponent
    small = m < 0.7071067811865476
    m, exponent = m * 2.0 if small else m, exponent - 1.0 if small else exponent
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    series = 0.22222198563735626 + z * (0.18183564858891618 + z * (0.15314035909787893 + z * 0.14796105847937446))
    series = z * (0.6666666666666734 + z * (0.39999999999414343 + z * (0.2857142874247136 + z * series)))
    half_square = 0.5 * f * f
    rest = s * (half_square + series) + exponent * 1.9082149292705877e-10
    return exponent * 0.6931471803691238 - ((half_square - rest) - f)
