"""Discrete Fourier transform of a power of two of numbers, in place and in plain arithmetic (Cooley
and Tukey 1965).

    X[k] = sum of x[n] exp(-2 pi j k n / N)

with tables of the cosines and sines of n / N turns, so that all engines have the same bits.
"""

from proofmass.blocks.arithmetic.elementary import cosine_of_turns, sine_of_turns


def fill_tables(cosines: list[float], sines: list[float]) -> None:
    """Fill the tables of N turns."""
    n = len(cosines)
    for i in range(n):
        cosines[i] = cosine_of_turns(i / n)
        sines[i] = sine_of_turns(i / n)


def turned_bits(i: int, bits: int) -> int:
    """The number whose bits are those of another from the lowest to the highest.

    >>> turned_bits(1, 3), turned_bits(6, 3)
    (4, 3)
    """
    turned, left = 0, i
    for _ in range(bits):
        turned = 2 * turned + left % 2
        left = left // 2
    return turned


def load_ring(
    ring: list[float], oldest: int, real: list[float], imaginary: list[float], cosines: list[float], bits: int
) -> None:
    """Place the numbers of a ring for `transform`, oldest first, less their mean, with Hann's."""
    n, total = len(ring), 0.0
    for i in range(n):
        total += ring[i]
    for i in range(n):
        place = turned_bits(i, bits)
        real[place] = (ring[(oldest + i) % n] - total / float(n)) * (0.5 - 0.5 * cosines[i])
        imaginary[place] = 0.0


def transform(real: list[float], imaginary: list[float], cosines: list[float], sines: list[float], bits: int) -> None:
    """Transform numbers that stand where their `turned_bits` say."""
    n, half = len(real), 1
    for _ in range(bits):
        stride = n // (2 * half)
        for k in range(n // 2):
            j = k % half
            a = 2 * k - j
            b = a + half
            c, s = cosines[j * stride], sines[j * stride]
            re = real[b] * c + imaginary[b] * s
            im = imaginary[b] * c - real[b] * s
            real[b], imaginary[b] = real[a] - re, imaginary[a] - im
            real[a], imaginary[a] = real[a] + re, imaginary[a] + im
        half = 2 * half
