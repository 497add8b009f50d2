"""A sigma-delta modulator as text for people."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from proofmass.runner.design.modulators.modulator import Modulator
from proofmass.runner.output.text_table import text_table


def modulator_text(of: Modulator) -> str:
    """Return what was designed, its zeros and poles, coefficients, and ratios over amplitude."""
    low, high = of.band
    pulse = of.structure.pulse
    kind = f"continuous time, pulse from {pulse[0]:g} to {pulse[1]:g} of a period" if pulse else "discrete time"
    amplitude, ratio = of.peak
    peak = f"{ratio:.1f} dB at {amplitude:g} dB of full scale" if ratio == ratio else "none: overload at each amplitude"
    lines = [
        f"{of.structure.form} of order {of.order}, {of.levels} levels, {kind}",
        f"  band              {low:.6g} to {high:.6g} of the rate, oversampling {of.oversampling:g}",
        f"  gain of the noise {of.gain:g} far from the band",
        f"  peak              {peak}, by simulation",
        *([f"  stable            below {_decibels(of.stable_limit):.1f} dB, by prediction"] if of.levels == 2 else []),
        "noise transfer function",
        *_table([("zero", "poles"), *_roots(of)], left=(0, 1)),
        "coefficients",
        *_table(list(_coefficients(of))),
        "signal to noise",
        *_table(list(_ratios(of))),
    ]
    return "\n".join(lines)


def _table(rows: Sequence[Sequence[str]], left: Sequence[int] = (0,)) -> list[str]:
    return [f"  {line}" for line in text_table(rows, left=left, indent=2)]


def _roots(of: Modulator) -> Iterator[tuple[str, str]]:
    for zero, pole in zip(of.transfer.zeros, of.transfer.poles, strict=True):
        if zero.imag >= 0.0 or pole.imag >= 0.0:
            yield _root(zero), _root(pole)


def _root(root: complex) -> str:
    sign = "+" if root.imag > 0.0 else "-"
    return f"{root.real:z.6f} {sign} {abs(root.imag):.6f}j" if root.imag else f"{root.real:z.6f}"


def _coefficients(of: Modulator) -> Iterator[Sequence[str]]:
    k = of.coefficients
    longest = max(map(len, (k.a, k.b, k.c, k.g)))
    yield ("", *map(str, range(1, longest + 1)))
    for letter in "abcg":
        numbers = [f"{value:.6g}" for value in getattr(k, letter)]
        yield (letter, *numbers, *[""] * (longest - len(numbers)))
    yield (
        "swing",
        *("-" if math.isnan(value) else f"{value:.4g}" for value in of.swings),
        *[""] * (longest - of.order),
    )


def _ratios(of: Modulator) -> Iterator[Sequence[str]]:
    yield "amplitude [dB]", "predicted [dB]", "simulated [dB]"
    for amplitude, *ratios in zip(of.amplitudes, of.predicted, of.simulated, strict=True):
        yield f"{amplitude:g}", *("overload" if ratio is None else f"{ratio:.1f}" for ratio in ratios)


def _decibels(amplitude: float) -> float:
    return 20.0 * math.log10(amplitude) if amplitude > 0.0 else -np.inf
