"""Figures of the linear response from one output to another, with their derivatives by parameters.

Derivatives are central differences along the exact derivatives of the period map.
"""

import math
from collections.abc import Mapping

import numpy as np

from proofmass.graphs.model.quantities import ResponseFigure
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.map_blocks import common_period
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.response.response import Response, response_of_map
from proofmass.runner.design.quantities.loop_figures import Reading, differences


def read_response(
    points: OperatingPoints, wanted: ResponseFigure, parameters: Mapping[str, float], slopes: bool
) -> Reading:
    """Return a figure of a response; infinite where it has no value, as the settling time of what never settles.

    Raises `ModelError` where no way leads from the input to the output.
    """
    planned = points.plan
    source, target = node_of(planned, wanted.input), node_of(planned, wanted.output)
    first = common_period(planned, [source], [target])
    whole = points.answered(lambda about: about.map([source], [target], by_parameters=slopes), first)
    shown = [] if wanted.frequency is None else [wanted.frequency]

    def figure(of: PeriodMap) -> float:
        return value_of_response(response_of_map(planned, source, target, of, shown), wanted.figure)

    value = figure(whole)
    if not slopes or not math.isfinite(value):
        return Reading(value, {})
    known = {name: parameters[name] for name in parameters if name in whole.slopes}
    return Reading(value, differences(lambda name, step: figure(whole.along(name, step)), known))


def value_of_response(response: Response, figure: str) -> float:
    """Return a figure of a response in its unit; gain and phase are those at its first frequency."""
    if figure in ("gain", "phase"):
        gain = complex(response.gain[0])
        return abs(gain) if figure == "gain" else float(np.degrees(np.angle(gain)))
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
