"""Sums and products without error, and pairs that mean their unrounded sum: about 106 bits.

Sums: Knuth, The Art of Computer Programming 2, 4.2.2; products and quotients: Dekker, Numerische
Mathematik 18 (1971). They hold because no engine contracts a product and a sum, or reorders either.
Products must neither overflow nor underflow: factors below 2^996, products above 2^-960.
"""

HALVING = 134217729.0  # 2^27 + 1: halves of 26 bits, with sign


def exact_sum(a: float, b: float) -> tuple[float, float]:
    """The rounded sum, and what rounding took off it.

    >>> exact_sum(1.0, 1e-20)
    (1.0, 1e-20)
    """
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


def ordered_sum(large: float, small: float) -> tuple[float, float]:
    """Return the same as `exact_sum`, of a number and one that is not larger in size."""
    total = large + small
    return total, small - (total - large)


def exact_product(a: float, b: float) -> tuple[float, float]:
    """The rounded product, and what rounding took off it.

    >>> exact_product(1.0 + 2.0**-52, 1.0 - 2.0**-52)
    (1.0, -4.930380657631324e-32)
    """
    product = a * b
    spread_a, spread_b = HALVING * a, HALVING * b
    high_a, high_b = spread_a - (spread_a - a), spread_b - (spread_b - b)
    low_a, low_b = a - high_a, b - high_b
    return product, low_a * low_b - (((product - high_a * high_b) - low_a * high_b) - high_a * low_b)


def pair_product(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    """The product of two pairs."""
    product, rest = exact_product(a, b)
    return product, rest + (a * b_low + a_low * b)


def pair_quotient(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    """The quotient of two pairs; the second is not zero.

    >>> pair_quotient(1.0, 0.0, 3.0, 0.0)
    (0.3333333333333333, 1.850371707708594e-17)
    """
    quotient = a / b
    product, rest = exact_product(quotient, b)
    return quotient, (((a - product) - rest) + (a_low - quotient * b_low)) / b


def pair_root(square: float, square_low: float, root: float) -> float:
    """Return the square root of a pair less its first number's root; zero where that is zero."""
    product, rest = exact_product(root, root)
    return (((square - product) - rest) + square_low) / (2.0 * root) if root > 0.0 else 0.0
