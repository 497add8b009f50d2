"""Sums of turning phasors in closed form."""

from proofmass.blocks.arithmetic.elementary import cosine_of_turns, sine_of_turns


def summed(turns: float, n: int) -> tuple[float, float]:
    """Real and imaginary part of the sum of exp(-2 pi j turns i) over i = 0 to n - 1."""
    divisor = sine_of_turns(0.5 * turns)
    if divisor != 0.0:
        size = sine_of_turns(0.5 * turns * n) / divisor
    else:
        size = n * cosine_of_turns(0.5 * turns * n) / cosine_of_turns(0.5 * turns)  # its limit at whole turns
    return size * cosine_of_turns(0.5 * turns * (n - 1)), -size * sine_of_turns(0.5 * turns * (n - 1))
