"""Operations on 64-bit integers and on numbers, with the same bits as in Python.

Each has a function for its value and, if it can fail, one that says whether it fails. Plain Python
then raises; compiled code notes the fault and goes on with a value that is never used. All are
plain functions of numbers, which any compiler of such functions can take.
"""

import math

from proofmass.blocks.arithmetic.scaling import mantissa_and_exponent, scaled

HIGHEST, LOWEST = 2**63 - 1, -(2**63)
_WORD = range(LOWEST, HIGHEST + 1)
MOST_TURNS = 1 << 24  # turns of one loop in one call
_EXACT = 2**53  # integers up to there are numbers
_LEADING = 2**55  # a quotient from there on has two bits more than a number


def add_fails(a: int, b: int) -> bool:
    """Return whether the sum exceeds 64 bits."""
    return a + b not in _WORD


def subtract_fails(a: int, b: int) -> bool:
    """Return whether the difference exceeds 64 bits."""
    return a - b not in _WORD


def multiply_fails(a: int, b: int) -> bool:
    """Return whether the product exceeds 64 bits."""
    return a * b not in _WORD


def negate_fails(a: int) -> bool:
    """Return whether the result exceeds 64 bits."""
    return a == LOWEST


def floor_divide(a: int, b: int) -> int:
    """Quotient, rounded down."""
    if b == 0:
        return 0
    return -a if b == -1 else a // b


def floor_divide_fails(a: int, b: int) -> bool:
    """Return whether there is no quotient of 64 bits."""
    return b == 0 or (b == -1 and a == LOWEST)


def modulo(a: int, b: int) -> int:
    """Remainder of a division that rounds down."""
    return 0 if b in (0, -1) else a % b


def modulo_fails(a: int, b: int) -> bool:
    """Return whether there is no remainder, for a divisor of zero."""
    return b == 0


def shift_left(a: int, b: int) -> int:
    """Product with a power of two."""
    return 0 if b < 0 or b > 63 else a << b


def shift_left_fails(a: int, b: int) -> bool:
    """Return whether the shift is negative, or the result exceeds 64 bits."""
    if b < 0 or a == 0:
        return b < 0
    return b > 63 or not LOWEST >> b <= a <= HIGHEST >> b


def shift_right(a: int, b: int) -> int:
    """Quotient by a power of two, rounded down."""
    return 0 if b < 0 else a >> min(b, 63)


def shift_right_fails(a: int, b: int) -> bool:
    """Return whether the shift is negative."""
    return b < 0


def power(a: int, k: int) -> int:
    """A power that is an integer."""
    if k > 63 and (a > 1 or a < -1):
        return 0
    result, base, left = 1, a, k
    while left > 0:
        if left & 1:
            result *= base
        left >>= 1
        if left > 0:
            base *= base
    return result


def power_fails(a: int, k: int) -> bool:
    """Return whether the exponent is negative, or the power exceeds 64 bits."""
    result, base, left = 1, a, k
    while left > 0:
        if left & 1:
            if multiply_fails(result, base):
                return True
            result *= base
        left >>= 1
        if left > 0:
            if multiply_fails(base, base):
                return True
            base *= base
    return k < 0


def true_divide(a: int, b: int) -> float:
    """Quotient of integers, rounded once; if both are exact as numbers, a division of numbers does that.

    Otherwise the bits of the quotient are computed one by one, two more than a number has, and a
    last bit that says whether there is a remainder.
    """
    if b == 0:
        return 0.0
    if a == 0 or (-_EXACT <= a <= _EXACT and -_EXACT <= b <= _EXACT):
        return float(a) / float(b)
    if b in (1, -1):
        return float(a) * float(b)
    negative_a, negative_b = (-a if a > 0 else a), (-b if b > 0 else b)
    quotient = negative_a // negative_b
    left = -(negative_a - quotient * negative_b)
    scale = 1.0
    while quotient < _LEADING:
        over = left + negative_b  # below zero
        if left > 0 and left >= -over:
            quotient, left = 2 * quotient + 1, left + over
        else:
            quotient, left = 2 * quotient, left + left
        scale *= 0.5
    size = float(quotient | (left != 0)) * scale
    return size if (a < 0) == (b < 0) else -size


def zero_fails(a: float, b: float) -> bool:
    """Return whether a divisor is zero."""
    return b == 0


def number_modulo(a: float, b: float) -> float:
    """Remainder of a division of numbers that rounds down; it has the sign of the divisor."""
    if b == 0.0:
        return 0.0
    left = c_remainder(a, b)
    if left != 0.0:
        return left + b if (b < 0.0) != (left < 0.0) else left
    return math.copysign(0.0, b)


def number_floor_divide(a: float, b: float) -> float:
    """Quotient of numbers, rounded down."""
    if b == 0.0:
        return 0.0
    left = c_remainder(a, b)
    quotient = (a - left) / b
    if left != 0.0 and (b < 0.0) != (left < 0.0):
        quotient -= 1.0
    if quotient == 0.0:
        return math.copysign(0.0, a / b)
    if not abs(quotient) < _EXACT:
        return quotient
    whole = float(math.floor(quotient))
    return whole + 1.0 if quotient - whole > 0.5 else whole


def signed(size: float, sign: float) -> float:
    """Return |size| with the sign of the other number, and without one where that is NaN.

    IEEE 754 leaves the sign of a NaN open: machines, and compilers that compute constants, give it
    either.

    >>> signed(2.0, -0.0), signed(-2.0, math.nan), signed(-2.0, -math.nan)
    (-2.0, 2.0, 2.0)
    """
    return math.copysign(size, sign) if sign == sign else abs(size)


def c_power(a: float, b: float) -> float:
    """Power of numbers from the C library; NaN or infinity if there is none."""
    try:
        return math.pow(a, b)
    except ValueError:
        return math.nan if a != 0.0 else math.copysign(math.inf, a) if b % 2.0 == 1.0 else math.inf
    except OverflowError:
        return -math.inf if a < 0.0 and b % 2.0 == 1.0 else math.inf


def c_remainder(a: float, b: float) -> float:
    """Remainder of a division towards zero, from the C library; NaN if there is none."""
    return math.nan if math.isinf(a) or b == 0.0 else math.fmod(a, b)


def c_cube_root(a: float) -> float:
    """Cube root from the C library."""
    return math.cbrt(a)


OF_C = {"c_power": "pow", "c_remainder": "fmod", "c_cube_root": "cbrt"}  # name of the function that compiled code calls
OF_MACHINES = {  # operations of programs in place of functions that need more than 64 bits
    "add_fails": "add_overflows",
    "subtract_fails": "subtract_overflows",
    "multiply_fails": "multiply_overflows",
}


def undefined(value: float, a: float) -> bool:
    """Return whether a function of a number has no value there, or one too large for a number."""
    return (math.isnan(value) and not math.isnan(a)) or (math.isinf(value) and math.isfinite(a))


def undefined_of_two(value: float, a: float, b: float) -> bool:
    """Return whether a function of two numbers has no value there, or one too large."""
    if math.isnan(value):
        return not (math.isnan(a) or math.isnan(b))
    return math.isinf(value) and math.isfinite(a) and math.isfinite(b)


def times_power_of_two(a: float, n: int) -> float:
    """A number times 2^n, rounded once."""
    if a == 0.0 or not math.isfinite(a):
        return a
    m, exponent = mantissa_and_exponent(abs(a))
    return math.copysign(scaled(m, min(max(exponent + float(n), -1080.0), 1030.0)), a)


def times_power_of_two_fails(value: float, a: float, n: int) -> bool:
    """Return whether the product is too large for a number."""
    return math.isinf(value) and math.isfinite(a)


def is_close(a: float, b: float, relative: float, absolute: float) -> bool:
    """Return whether two numbers are close, by a relative or an absolute tolerance."""
    if a == b:
        return True
    if math.isinf(a) or math.isinf(b):
        return False
    apart = abs(b - a)
    return apart <= abs(relative * b) or apart <= abs(relative * a) or apart <= absolute


def is_close_fails(a: float, b: float, relative: float, absolute: float) -> bool:
    """Return whether a tolerance is negative."""
    return relative < 0.0 or absolute < 0.0


def truncate(a: float) -> int:
    """The integer towards zero."""
    return 0 if truncate_fails(a) else int(a)


def truncate_fails(a: float) -> bool:
    """Return whether a number exceeds 64 bits once it is rounded, in whichever way."""
    return not -9223372036854775808.0 <= a < 9223372036854775808.0


def floor(a: float) -> int:
    """The integer below."""
    return 0 if truncate_fails(a) else math.floor(a)


def ceil(a: float) -> int:
    """The integer above."""
    return 0 if truncate_fails(a) else math.ceil(a)


def nearest(a: float) -> int:
    """The nearest integer, the even one of two."""
    if truncate_fails(a):
        return 0
    if not abs(a) < 4503599627370496.0:
        return int(a)
    return int(math.copysign((abs(a) + 4503599627370496.0) - 4503599627370496.0, a))


def compare(a: int, b: float) -> int:
    """-1, 0 or 1 as the integer is less, equal or more, exactly; 2 where the number is NaN."""
    if math.isnan(b):
        return 2
    if truncate_fails(b):
        return -1 if b > 0.0 else 1
    whole = int(b)
    if a != whole:
        return -1 if a < whole else 1
    rest = b - float(whole)
    return -1 if rest > 0.0 else 1 if rest < 0.0 else 0


def place(index: int, length: int) -> int:
    """Place of an entry, counted from the end if the index is negative; some place if it fails."""
    at = index + length if index < 0 else index
    return min(max(at, 0), max(length - 1, 0))


def place_fails(index: int, length: int) -> bool:
    """Return whether there is no such entry."""
    return not -length <= index < length


def next_turn(turns: int) -> int:
    """Number of turns of a loop so far."""
    return turns + 1


def next_turn_fails(turns: int) -> bool:
    """Return whether a loop has turned more often than a tick allows."""
    return turns >= MOST_TURNS


def range_end(start: int, stop: int, step: int) -> int:
    """End of a range; its beginning if it is too long."""
    return start if range_end_fails(start, stop, step) else stop


def range_end_fails(start: int, stop: int, step: int) -> bool:
    """Return whether a range is longer than a tick allows."""
    return step != 0 and (float(stop) - float(start)) / float(step) > MOST_TURNS


def stride_fails(step: int) -> bool:
    """Return whether the step of a range is zero."""
    return step == 0


def stride(step: int) -> int:
    """The step of a range."""
    return 1 if step == 0 else step
