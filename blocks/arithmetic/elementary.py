"""Elementary functions in plain arithmetic: the same bits in every engine, on every machine; they vectorise.

A quarter wave is sin(pi v / 2) = v + v (1 - v^2) (1/2 + T(v^2)) for |v| <= 1, where T is the minimax polynomial of
degree 7 (Remez exchange on the relative error, 3e-19). The form is exact at v = 0 and v = +-1, and the rounding of T
counts little. The logarithm is 2 atanh(s), s = (m - 1)/(m + 1), about the powers of two. The exponential is
1 + r + r c / (2 - c) times a power of two, |r| <= ln(2) / 2, with c = r - r^2 P(r^2) and the P of fdlibm. The errors
stated are the largest of 10^7 arguments each against 64-bit mantissas: 1.22, 1.54, 0.84, 0.84 and 0.91 ulp.
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
    return _logarithm_near_one(m, exponent, 0.0)


def logarithm_of_one_plus(value: float) -> float:
    """Natural logarithm of 1 + value for 0 <= value <= 2^63, within 1 ulp, small values too.

    >>> logarithm_of_one_plus(1e-30), logarithm_of_one_plus(1.0)
    (1e-30, 0.6931471805599453)
    """
    whole = 1.0 + value
    lost = (1.0 - (whole - value) if value > 1.0 else value - (whole - 1.0)) / whole
    m, exponent = whole, 0.0
    large = m > 3037000499.97605
    m, exponent = m * 2.3283064365386963e-10 if large else m, exponent + 32.0 if large else exponent
    large = m > 46340.950011841574
    m, exponent = m * 1.52587890625e-05 if large else m, exponent + 16.0 if large else exponent
    large = m > 181.01933598375618
    m, exponent = m * 0.00390625 if large else m, exponent + 8.0 if large else exponent
    large = m > 11.313708498984761
    m, exponent = m * 0.0625 if large else m, exponent + 4.0 if large else exponent
    large = m > 2.8284271247461903
    m, exponent = m * 0.25 if large else m, exponent + 2.0 if large else exponent
    large = m > 1.4142135623730951
    m, exponent = m * 0.5 if large else m, exponent + 1.0 if large else exponent
    return _logarithm_near_one(m, exponent, lost)


def _logarithm_near_one(m: float, exponent: float, rest: float) -> float:
    """ln(m 2^exponent) + rest, m between the roots of 1/2 and 2."""
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    series = 0.22222198563735626 + z * (0.18183564858891618 + z * (0.15314035909787893 + z * 0.14796105847937446))
    series = z * (0.6666666666666734 + z * (0.39999999999414343 + z * (0.2857142874247136 + z * series)))
    half_square = 0.5 * f * f
    rest = s * (half_square + series) + (exponent * 1.9082149292705877e-10 + rest)
    return exponent * 0.6931471803691238 - ((half_square - rest) - f)


def exponential(value: float) -> float:
    """e to the power of the value, within 1 ulp; beyond -354 and 354 that of the nearer of the two.

    >>> exponential(0.0), exponential(-1.0), exponential(1e9) == exponential(354.0)
    (1.0, 0.36787944117144233, True)
    """
    low = -354.0 if value < -354.0 else value
    held = 354.0 if low > 354.0 else low
    twos = nearest_integer(held * 1.4426950408889634)
    high, low = held - twos * 0.6931471803691238, twos * 1.9082149292705877e-10
    r = high - low
    z = r * r
    series = 6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08)
    c = r - z * (1.66666666666666019037e-01 + z * (-2.77777777770155933842e-03 + z * series))
    m = (1.0 - ((low - r * c / (2.0 - c)) - high)) * 7.458340731200207e-155  # 2^-512
    left = twos + 512.0
    large = left >= 512.0
    m, left = m * 1.3407807929942597e154 if large else m, left - 512.0 if large else left
    large = left >= 256.0
    m, left = m * 1.157920892373162e77 if large else m, left - 256.0 if large else left
    large = left >= 128.0
    m, left = m * 3.402823669209385e38 if large else m, left - 128.0 if large else left
    large = left >= 64.0
    m, left = m * 1.8446744073709552e19 if large else m, left - 64.0 if large else left
    large = left >= 32.0
    m, left = m * 4294967296.0 if large else m, left - 32.0 if large else left
    large = left >= 16.0
    m, left = m * 65536.0 if large else m, left - 16.0 if large else left
    large = left >= 8.0
    m, left = m * 256.0 if large else m, left - 8.0 if large else left
    large = left >= 4.0
    m, left = m * 16.0 if large else m, left - 4.0 if large else left
    large = left >= 2.0
    m, left = m * 4.0 if large else m, left - 2.0 if large else left
    return m * 2.0 if left >= 1.0 else m
