"""The standard deviation of one value over runs that differ in their random numbers: of an
estimate, a result, a test.

A budget is that of an output that goes on for ever. A value at one time of a run, such as what a
calibration has found at its end, has a variance alone. It follows from all that happened since tick
0, by the exact derivatives along the run without noise:

    P[n+1] = S P[n] S' + R V R'

P is the covariance of what lasts from tick to tick, S and R are its slopes by that and by new
random numbers of the variances V. Nothing need repeat or settle (Gelb, Applied Optimal Estimation,
1974, section 4.1).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints, linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.analysis.noise.covariances import Covariances, CovarianceTicks, Stretch
from proofmass.runner.analysis.noise.grid_errors import errors_along
from proofmass.runner.derivatives.dual_noise import Followed, given, one_model_each, reached
from proofmass.runner.derivatives.stepped_ticks import UndefinedSlopesError
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.notebook import Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.plan.memory import Memory, Rows, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.faults import failed

_SHOWN = 64, 1024  # ticks for one look at progress, in plain Python and in machine code


@dataclass(frozen=True, eq=False, repr=False)
class ValueDeviation(Told):
    """Standard deviation over runs of one value of an output, and of the parts of it that each block makes.

    >>> from proofmass import deviation_over_runs, read_graph
    >>> last = deviation_over_runs(read_graph("library:recorded_motion"), "mean.mean", until="40 ms")
    >>> last.output, f"{last.deviation:.4f} {last.unit}"
    ('mean.mean', '0.0020 m/s^2')
    """

    output: str  # "block.port"
    unit: str  # of the output
    time: float  # seconds
    value: float  # there, without noise
    deviation: float  # over runs
    sources: Mapping[str, float]  # deviation by block, the largest first
    notes: tuple[str, ...] = ()  # on roundings whose errors are neither white nor uniform

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "output": self.output,
            "unit": self.unit,
            "time_s": self.time,
            "value": self.value,
            "deviation": self.deviation,
            "sources": dict(self.sources),
            "notes": list(self.notes),
        }


def deviation_over_runs(
    graph: GraphSource,
    output: str,
    *,
    until: str | float | Fraction | None = None,
    progress: Progress | None = None,
) -> ValueDeviation:
    """Return the standard deviation of an output at a time over runs of different seeds, exactly
    for small noise.

    `graph` runs from tick 0, and random numbers count from there; `output` is "block.port". The
    value is that of its last tick up to and with the time `until`, in seconds, which is the end of
    the graph's run unless said. Roundings count as in `noise` where random numbers reach them;
    elsewhere they are alike in all runs. Machine code follows a tick in some 0.2 ms, plain Python
    in 2 ms; `progress` is called with the ticks that are done and all of them.

    Raises `ModelError` for a graph that cannot be linearised.

    >>> from proofmass import deviation_over_runs, read_graph
    >>> last = deviation_over_runs(read_graph("library:recorded_motion"), "mean.mean", until="40 ms")
    >>> list(last.sources)
    ['amplifier', 'gas', 'adc']
    """
    planned = plan(graph)
    ticks = planned.ticks() if until is None else OperatingPoints(planned, until).answered(lambda about: about.tick) + 1
    return deviations(planned, [output], ticks, progress)[0]


def deviations(
    planned: Plan, outputs: Sequence[str], ticks: int, progress: Progress | None = None
) -> list[ValueDeviation]:
    """Return those of the last values before a tick of several outputs."""
    nodes = [node_of(planned, output) for output in outputs]
    found = followed(planned, nodes, ticks, {}, progress)
    early = next((output for output, node in zip(outputs, nodes, strict=True) if node not in found.last), None)
    if early is not None:
        raise ModelError([planned.graph.placed(_early(early, (ticks - 1) * planned.period))])
    return [_deviation(planned, *each, found) for each in zip(outputs, nodes, strict=True)]


def densities(
    planned: Plan, outputs: Sequence[str], ticks: int, window: Array
) -> list[tuple[ValueDeviation, Array, Array]]:
    """Return the deviations, frequencies and mean one-sided densities of the last values before a tick.

    There are as many of them as weights in the window. A line is the mean over runs of |sum of w y
    exp(-2 pi i f t)|^2.
    """
    nodes = [node_of(planned, output) for output in outputs]
    strides = {node: planned.stride(node) for node in nodes}
    # a value is recorded in each tick of its block from tick 0 on
    firsts = {node: -(-ticks // stride) - len(window) for node, stride in strides.items()}
    turns = np.arange(len(window) // 2 + 1) / len(window)
    stretches = {node: Stretch(window, firsts[node], turns) for node in nodes}
    found = followed(planned, nodes, ticks, stretches)
    answers = []
    for output, node in zip(outputs, nodes, strict=True):
        rate = float(planned.schedule.base_rate) / strides[node]
        lines = np.arange(len(window) // 2 + 1) * rate / len(window)
        density = np.sum([*stretches[node].powers.values()], axis=0) * (2.0 / (rate * float(np.sum(window**2))))
        answers.append((_deviation(planned, output, node, found), lines, density))
    return answers


def _early(output: str, time: float) -> Problem:
    message, expected = f"{output} has no value before that time", "a time after its first tick"
    return Problem(message=message, key="until", got=f"{time:g} s", expected=expected, hint="name a later time")


def followed(
    planned: Plan,
    nodes: Sequence[Endpoint],
    ticks: int,
    stretches: Mapping[Endpoint, Stretch],
    progress: Progress | None = None,
    begin: Memory | None = None,
    course: Course | None = None,
) -> Covariances:
    """Return what a run up to a tick ends in, from a memory without noise or from tick 0; raises `ModelError`."""
    about = linearised(planned)
    noisy = noise_at(about, list(nodes))
    if begin is None:  # all runs round alike what random numbers do not reach
        drawn = reached(planned, given(planned, (Deviate,)))
        noisy = {name: models for name, models in noisy.items() if name in drawn}
    begin = begin or start(planned.without_noise)
    upstream, first = upstream_of(planned, (name for name, _ in nodes)), begin.tick
    course = course or about.course
    code = course.slopes(ticks - first, True, upstream) if one_model_each(noisy) else None
    errors = errors_along(planned, course.at, Ends((), tuple(nodes), noise=noisy), ticks, code)
    while True:
        found = Covariances(stretches, errors)
        advance: Callable[[int, Rows], bool]
        if code is not None and code.wires.keys() >= {*nodes}:
            # start-up time: few ticks need no compiler
            from proofmass.runner.analysis.noise.covariances_in_code import CovarianceInCode

            own = Followed(upstream, upstream, (), nodes, noisy)
            advance = CovarianceInCode(code, code.of(planned), begin, own, found).advance
        else:
            whole = planned, begin.copy(), upstream, (), nodes, False, False, True
            advance = CovarianceTicks(*whole, noise=noisy, found=found).advance
        try:
            shown = _SHOWN[code is not None]
            for done in range(first, ticks, shown):
                if progress:
                    progress(done - first, ticks - first)
                if not advance(min(done + shown, ticks), ()):
                    raise UndefinedSlopesError([])
        except UndefinedSlopesError:  # plain Python says why
            code = None
            continue
        except TickError as error:
            raise ModelError([failed(planned, error)]) from error
        return found


def _deviation(planned: Plan, output: str, node: Endpoint, found: Covariances) -> ValueDeviation:
    last = found.last[node]
    parts = sorted(((math.sqrt(v), name) for name, v in last.variances.items() if v > 0.0), reverse=True)
    return ValueDeviation(
        output=output,
        unit=short_unit(planned.unit(node)),
        time=planned.beat(node).at(last.number) * planned.period,
        value=last.value,
        deviation=math.sqrt(sum(last.variances.values())),
        sources={name: deviation for deviation, name in parts},
        notes=found.notes(node),
    )
