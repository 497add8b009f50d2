"""A check that noise is small: where it moves the operating point, the map there must do the same to it.

A product of two noises, or the root of a sum of squares of what is noise alone, has a slope that noise itself sets. The
map is taken again at what a run with noise gets to, and its rms is compared.
"""

import math

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import Forward, memory_at
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, period_map
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map
from proofmass.runner.analysis.noise.one_bit import with_spectra
from proofmass.runner.derivatives.dual_noise import Noisy
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

_TICKS = 512  # base ticks of a run with noise, or one period
_APART = 0.25  # of the rms, about 2 dB


def strained(planned: Plan, target: Endpoint, noisy: Noisy, whole: PeriodMap, to_output: NoiseMap) -> str:
    """Return a note where the noise of an output is another at what a run with noise gets to, or ""."""
    if not to_output.settles or not whole.order:
        return ""
    ticks = round(whole.period / planned.period)
    run = Forward(planned, memory_at(planned.without_noise, whole.tick).copy())
    try:
        memory = run.to(whole.tick + max(1, _TICKS // ticks) * ticks)
        there = with_spectra(period_map(planned, [], [target], noise=noisy, memory=memory, span=ticks), noisy)
        moved = noise_map(there, target)
    except (ModelError, TickError):  # a refusal there is not one of the budget
        return ""
    if not moved.settles:
        return ""
    rms, after = (math.sqrt(float(sum(of.mean_squares()))) for of in (to_output, moved))
    if abs(after - rms) <= _APART * rms:
        return ""
    return (
        f"noise is not small here: where a run with noise gets to, its rms is {after:.3g}, and {rms:.3g} without; a"
        " study of many runs says what it is"
    )
