"""Powers of two, split off numbers and multiplied to them, exactly: without a look at the bits,
which Python has not.

One choice after the other and no loop: so they vectorise.
"""

from proofmass.blocks.arithmetic.rounding import nearest_integer


def scaled(value: float, exponent: float) -> float:
    """value 2^exponent, rounded once: for 1/4 <= |value| <= 4 and a whole exponent from -1080 to 1030.

    >>> scaled(1.5, 3.0), scaled(1.0, -1074.0), scaled(1.0, 1024.0)
    (12.0, 5e-324, inf)
    """
    half = nearest_integer(0.5 * exponent)
    power, rest = power_of_two(half), exponent - 2.0 * half
    return value * power * (power * (2.0 if rest > 0.0 else 0.5 if rest < 0.0 else 1.0))


def power_of_two(exponent: float) -> float:
    """2^exponent, for a whole exponent from -540 to 540.

    >>> power_of_two(-3.0), power_of_two(10.0)
    (0.125, 1024.0)
    """
    power, left = 2.778448436856347e-163, exponent + 540.0  # 2^-540
    large = left >= 512.0
    power, left = power * 1.3407807929942597e154 if large else power, left - 512.0 if large else left
    large = left >= 512.0
    power, left = power * 1.3407807929942597e154 if large else power, left - 512.0 if large else left
    large = left >= 256.0
    power, left = power * 1.157920892373162e77 if large else power, left - 256.0 if large else left
    large = left >= 128.0
    power, left = power * 3.402823669209385e38 if large else power, left - 128.0 if large else left
    large = left >= 64.0
    power, left = power * 1.8446744073709552e19 if large else power, left - 64.0 if large else left
    large = left >= 32.0
    power, left = power * 4294967296.0 if large else power, left - 32.0 if large else left
    large = left >= 16.0
    power, left = power * 65536.0 if large else power, left - 16.0 if large else left
    large = left >= 8.0
    power, left = power * 256.0 if large else power, left - 8.0 if large else left
    large = left >= 4.0
    power, left = power * 16.0 if large else power, left - 4.0 if large else left
    large = left >= 2.0
    power, left = power * 4.0 if large else power, left - 2.0 if large else left
    return power * 2.0 if left >= 1.0 else power


def mantissa_and_exponent(value: float) -> tuple[float, float]:
    """m and n of value = m 2^n, m between the roots of 1/2 and 2, for a positive number.

    >>> mantissa_and_exponent(12.0), mantissa_and_exponent(5e-324)
    ((0.75, 4.0), (1.0, -1074.0))
    """
    small = value < 7.458340731200207e-155  # 2^-512
    m, exponent = value * 1.5095849699286165e169 if small else value, -562.0 if small else 0.0
    large = m >= 1.3407807929942597e154
    m, exponent = m * 7.458340731200207e-155 if large else m, exponent + 512.0 if large else exponent
    small = m < 1.0
    m, exponent = m * 1.3407807929942597e154 if small else m, exponent - 512.0 if small else exponent
    large = m >= 1.157920892373162e77
    m, exponent = m * 8.636168555094445e-78 if large else m, exponent + 256.0 if large else exponent
    large = m >= 3.402823669209385e38
    m, exponent = m * 2.938735877055719e-39 if large else m, exponent + 128.0 if large else exponent
    large = m >= 1.8446744073709552e19
    m, exponent = m * 5.421010862427522e-20 if large else m, exponent + 64.0 if large else exponent
    large = m >= 4294967296.0
    m, exponent = m * 2.3283064365386963e-10 if large else m, exponent + 32.0 if large else exponent
    large = m >= 65536.0
    m, exponent = m * 1.52587890625e-05 if large else m, exponent + 16.0 if large else exponent
    large = m >= 256.0
    m, exponent = m * 0.00390625 if large else m, exponent + 8.0 if large else exponent
    large = m >= 16.0
    m, exponent = m * 0.0625 if large else m, exponent + 4.0 if large else exponent
    large = m >= 4.0
    m, exponent = m * 0.25 if large else m, exponent + 2.0 if large else exponent
    large = m >= 2.0
    m, exponent = m * 0.5 if large else m, exponent + 1.0 if large else exponent
    large = m > 1.4142135623730951
    return m * 0.5 if large else m, exponent + 1.0 if large else exponent
