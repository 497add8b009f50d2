"""Figures of outputs with their derivatives by parameters: of the linear response from another one,
and rms noise.

Those of a response are central differences along the exact derivatives of the period map. Those of
noise are exact, those of the budget; referred to an input, differences along the exact derivatives
of the matrices.
"""

import math
from collections.abc import Mapping

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.quantities import Noise, ResponseFigure
from proofmass.runner.analysis.decisions.one_bit import noise_at, with_spectra
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import judged
from proofmass.runner.analysis.linearisation.rounded import NEAR
from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.analysis.noise.band import bends, rule, rule_of, within
from proofmass.runner.analysis.noise.derivatives import slopes_and_sizes
from proofmass.runner.analysis.noise.grid_errors import errors_about
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map
from proofmass.runner.analysis.response.response import Response, response_of_map, unreached
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.design.quantities.loop_figures import NoValue, Reading, differences
from proofmass.runner.host.arrays import Array

_STEP = 1e-5  # of a parameter
_OF_ALL = ("peak", "bandwidth", "delay")  # figures of a response at all frequencies


def read_response(
    points: OperatingPoints, wanted: ResponseFigure, parameters: Mapping[str, float], slopes: bool
) -> Reading | NoValue:
    """Return a figure of a response; infinite where it has no limit, as the settling time of what never settles.

    What grows without end has none, and what does not settle has no figure of all frequencies.
    Raises `ModelError` where no way leads from the input to the output.
    """
    planned = points.plan
    source, target = node_of(planned, wanted.input), node_of(planned, wanted.output)
    first = Ends((source,), (target,)).common_period(planned)
    whole = points.answered(lambda about: about.map([source], [target], by_parameters=slopes), first)
    shown = [] if wanted.frequency is None else [wanted.frequency]

    def figure(of: PeriodMap) -> float:
        return value_of_response(response_of_map(planned, source, target, of, shown), wanted.figure)

    near = WireResponse.of(whole).radius > 1.0 - NEAR
    verdict = judged(whole.moved_between(), True)[0] if near else "stable"
    if verdict == "unstable":
        return NoValue(f"what {wanted.input} does to {wanted.output} grows without end", unstable=True)
    if verdict == "marginal" and (wanted.figure in _OF_ALL or wanted.frequency == 0.0):
        return NoValue(f"what {wanted.input} does to {wanted.output} does not settle")
    response = response_of_map(planned, source, target, whole, shown)
    value = value_of_response(response, wanted.figure)
    if not slopes or not math.isfinite(value):
        return Reading(value, {})
    known = {name: parameters[name] for name in parameters if name in whole.slopes}
    return Reading(value, differences(lambda name, step: figure(whole.along(name, step)), known))


def value_of_response(response: Response, figure: str) -> float:
    """Return a figure of a response in its unit; gain and phase are at its first frequency."""
    if figure in ("gain", "phase"):
        return float(abs(response.gain[0]) if figure == "gain" else np.degrees(response.phase[0]))
    if figure == "peak":
        return response.peak[1]
    if figure in ("bandwidth", "delay"):
        value = response.bandwidth if figure == "bandwidth" else response.delay
        return math.inf if value is None else value
    step = response.step
    values = {} if step is None else {"rise_time": step.rise, "settling_time": step.settling}
    if figure == "overshoot":
        return math.inf if step is None or step.overshoot is None else 100.0 * step.overshoot
    return math.inf if values.get(figure) is None else float(values[figure])  # type: ignore[arg-type]


def read_noise(
    points: OperatingPoints, wanted: Noise, parameters: Mapping[str, float], slopes: bool
) -> Reading | NoValue:
    """Return the rms noise, that of `noise`; or that the output grows without end.

    Raises `ModelError` for a band that the output does not have, and for noise without bound at an input.
    """
    planned = points.plan
    target = node_of(planned, wanted.output)
    source = node_of(planned, wanted.input) if wanted.input else None
    inputs = [source] if source else []
    first = Ends(tuple(inputs), (target,), noise=noise_blocks(planned)).common_period(planned)

    def ask(about: Linearisation) -> PeriodMap:
        noisy = noise_at(about, [target])
        whole = with_spectra(about.map(inputs, [target], noise=noisy, by_parameters=slopes), noisy)
        return errors_about(about, Ends(tuple(inputs), (target,), noise=noisy))[0].of(whole)

    whole = points.answered(ask, first)
    to_output = noise_map(whole, target)
    if to_output.grows or not (to_output.settles or wanted.band):
        return NoValue(f"the noise of {wanted.output} grows without end")
    band = within(to_output, wanted.band) if wanted.band else None
    names = [name for name in parameters if name in whole.slopes]
    if source is not None:
        return _referred(whole, target, source, band, {name: parameters[name] for name in names})
    squares = rule_of(to_output, band)[2] if band else to_output.mean_squares
    rms = math.sqrt(float(np.sum(squares)))
    by = slopes_and_sizes(to_output, band, rms)[0] if names and rms > 0.0 else {}
    return Reading(rms, {name: by[name] for name in names if name in by})


def _referred(
    whole: PeriodMap,
    target: Endpoint,
    source: Endpoint,
    band: tuple[float, float] | None,
    parameters: Mapping[str, float],
) -> Reading:
    """Return the rms at an input that makes an output's noise, and what parameters do to it."""
    to_output = noise_map(whole, target)
    ends = bends(to_output, *(band or (0.0, 0.5 * to_output.rate)))

    def mean_square(of: NoiseMap) -> float:
        def density(frequencies: Array) -> Array:
            squares = of.densities(frequencies).sum(axis=1)
            gain = np.abs(of.gain(frequencies, source, 0.0))  # clock offsets turn its phase alone
            if not gain.any():
                raise unreached(source, target).error
            with np.errstate(divide="ignore"):  # at a zero of the gain there is no end to it
                return np.asarray((squares / gain**2)[:, None])

        return float(rule(density, ends)[2][0])

    rms, moved = math.sqrt(mean_square(to_output)), dict[str, float]()
    for name, value in parameters.items() if rms > 0.0 else ():
        step = _STEP * (abs(value) or 1.0)
        up, down = (mean_square(noise_map(whole.along(name, side * step), target)) for side in (1.0, -1.0))
        moved[name] = (up - down) / (4.0 * step * rms)
    return Reading(rms, moved)
