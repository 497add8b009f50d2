"""Functions of one operation each, of two integers, of two numbers, or of one of both."""

import math


def added(a: int, b: int):
    return a + b


def subtracted(a: int, b: int):
    return a - b


def multiplied(a: int, b: int):
    return a * b


def floor_divided(a: int, b: int):
    return a // b


def left_over(a: int, b: int):
    return a % b


def both_parts(a: int, b: int):
    quotient, rest = divmod(a, b)
    return quotient if a < b else rest


def true_divided(a: int, b: int):
    return a / b


def shifted_left(a: int, b: int):
    return a << b


def shifted_right(a: int, b: int):
    return a >> b


def to_the_power(a: int, b: int):
    return a**b


def cubed(a: int, b: int):
    return a**3


def to_the_tenth(a: int, b: int):
    return a**10


def inverse_squared(a: int, b: int):
    return a**-2


def by_three(a: int, b: int):
    return a // 3


def modulo_three(a: int, b: int):
    return a % -3


def bits_in_both(a: int, b: int):
    return a & b


def bits_in_one(a: int, b: int):
    return a ^ b


def bits_in_any(a: int, b: int):
    return a | ~b


def negated(a: int, b: int):
    return -a


def size(a: int, b: int):
    return abs(a)


def smaller(a: int, b: int):
    return min(a, b, 7)


def common(a: int, b: int):
    return math.gcd(a, b)


def root(a: int, b: int):
    return math.isqrt(a)


def as_number(a: int, b: int):
    return float(a)


def ordered(a: int, b: int):
    return a < b <= a + 1 if -1000 < b < 1000 else a == b


def entry(a: int, b: int):
    return (3, 1, 4, 1, 5)[a]


def nothing_between(a: int, b: int):
    return (b > 0 and a // b > 2) or a == 5


def sum_of_some(a: int, b: int):
    total = 0
    for i in range(b % 7):
        total += a * i
    return total


def steps(a: int, b: int):
    count = 0
    for _ in range(0, a % 100, b % 5):
        count += 1
    return count


def halved_until_odd(a: int, b: int):
    while a % 2 == 0 and a != 0:
        a = a // 2
    return a


def every_comparison(a: int, b: int):
    return (a < b) + 2 * (a <= b) + 4 * (a > b) + 8 * (a >= b) + 16 * (a == b) + 32 * (a != b)


def inverted(a: int, b: int):
    return ~a


def one_of_some(a: int, b: int):
    return a in (b, 7, 9223372036854775807) and b not in (1, 2)


def least_of_three(a: int, b: int):
    return min((a, b, -5)) - max((a, b))


def sum_of_two(a: int, b: int):
    return sum((a, b))


def product_of_two(a: int, b: int):
    return math.prod((a, b))


def least_multiple(a: int, b: int):
    return math.lcm(a, b)


def factorial_of(a: int, b: int):
    return math.factorial(a)


def first_divisor(a: int, b: int):
    for divisor in range(2, 9):
        if a % divisor == 0:
            break
    else:
        return -1
    return divisor


def halved_while_it_goes(a: int, b: int):
    while a % 2 == 0 and a != 0:
        a = a // 2
        if a == b:
            break
    else:
        a = a - 1
    return a


def numbered_from(a: int, b: int):
    total = 0
    for number, entry in enumerate((a, b, 2), b):
        total += number * (entry % 5)
    return total


def added_numbers(a: float, b: float):
    return a + b


def multiplied_numbers(a: float, b: float):
    return a * b - b


def divided_numbers(a: float, b: float):
    return a / b


def floor_divided_numbers(a: float, b: float):
    return a // b


def left_over_numbers(a: float, b: float):
    return a % b


def number_to_the_power(a: float, b: float):
    return a**b


def number_cubed(a: float, b: float):
    return a**3


def number_to_the_tenth(a: float, b: float):
    return a**10


def number_inverse_squared(a: float, b: float):
    return a**-2


def number_to_the_half(a: float, b: float):
    return a**0.5


def number_squared(a: float, b: float):
    return pow(a, 2)


def truncated(a: float, b: float):
    return int(a)


def rounded(a: float, b: float):
    return round(a)


def rounded_down(a: float, b: float):
    return math.floor(a)


def rounded_up(a: float, b: float):
    return math.ceil(a)


def least(a: float, b: float):
    return min(a, b)


def greatest(a: float, b: float):
    return max(a, b, 0)


def chosen(a: float, b: float):
    return math.sqrt(a) if a > b else math.log(b)


def both_roots(a: float, b: float):
    return math.sqrt(a) > 1.0 and math.sqrt(b) > 1.0


def truth(a: float, b: float):
    return bool(a) or not b


def square_root(a: float, b: float):
    return math.sqrt(a)


def exponential(a: float, b: float):
    return math.exp(a)


def logarithm(a: float, b: float):
    return math.log(a)


def logarithm_to_a_base(a: float, b: float):
    return math.log(a, b)


def sine(a: float, b: float):
    return math.sin(a) + math.cos(b)


def angle(a: float, b: float):
    return math.atan2(a, b)


def inverse_sine(a: float, b: float):
    return math.asin(a)


def inverse_hyperbolic(a: float, b: float):
    return math.atanh(a)


def cube_root(a: float, b: float):
    return math.cbrt(a)


def power_of_math(a: float, b: float):
    return math.pow(a, b)


def remainder_of_math(a: float, b: float):
    return math.fmod(a, b)


def error_function(a: float, b: float):
    return math.erf(a) + math.tanh(b)


def in_degrees(a: float, b: float):
    return math.degrees(a)


def is_finite(a: float, b: float):
    return math.isfinite(a) and not math.isnan(b)


def every_comparison_of_numbers(a: float, b: float):
    return (a < b) + 2 * (a <= b) + 4 * (a > b) + 8 * (a >= b) + 16 * (a == b) + 32 * (a != b)


def rounded_towards_zero(a: float, b: float):
    return math.trunc(a)


def close(a: float, b: float):
    return math.isclose(a, b)


def close_as_told(a: float, b: float):
    return math.isclose(a, b, abs_tol=abs(b) + 1e-300, rel_tol=0.5 * a)


def product_of_numbers(a: float, b: float):
    return math.prod((a, b, 0.1))


def largest_of_numbers(a: float, b: float):
    return max((a, b, 0.0)) - min((a, b, 1.0))


def one_of_some_numbers(a: float, b: float):
    return a + 0.0 in (b, 1, 0.5)


def below_infinity(a: float, b: float):
    return float("-inf") < a < float("inf") or float("nan") == b


def times_a_power_of_two(a: int, b: float):
    return math.ldexp(b, a)


def less_than_a_number(a: int, b: float):
    return a < b


def equal_to_a_number(a: int, b: float):
    return a == b


def not_less_than_a_number(a: int, b: float):
    return a >= b


def a_number_is_less(a: int, b: float):
    return b < a


def between_numbers(a: int, b: float):
    return b <= a < b + 1.0


def times_a_number(a: int, b: float):
    return a * b


def over_a_number(a: int, b: float):
    return a / b


def modulo_a_number(a: int, b: float):
    return a % b


def to_the_power_of_a_number(a: int, b: float):
    return a**b


def truth_below_truth(a: int, b: int):
    return (a > 1) < (b > 1)


def truth_not_above_truth(a: float, b: float):
    return (a > 0.5) <= (b > 0.5)
