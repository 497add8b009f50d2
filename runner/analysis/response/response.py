"""The response of a graph from one output to another, by its exact linearisation."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.problem import Problem, problem_of_output
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.call_numbers import frequencies_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import At, Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.phase import counted_phase
from proofmass.runner.analysis.linearisation.rounded import NEAR, known_note, moved_maps, nearest_mode
from proofmass.runner.analysis.linearisation.step import StepFigures, StepResponse, step_response
from proofmass.runner.analysis.linearisation.wire_response import WireResponse, grid, resonances
from proofmass.runner.analysis.margins.frequencies import Samples, highest
from proofmass.runner.analysis.response.simulated import Simulated, read_amplitude, simulated
from proofmass.runner.analysis.response.stimuli import Stimulus, StimulusKind
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.host.notebook import Plotted, Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

_BELOW = 0.1  # of the lowest corner, where a picture begins
_EVEN = 200  # frequencies
_DECADES = 6.0  # that it covers at most
_AT_REST = 1e-9  # of the largest gain: a gain at rest that is rounding
_HALF = math.sqrt(0.5)
_BISECTIONS = 60
_STEP = 1e-4  # of the distance to the nearest pole, over which the phase is differentiated


@dataclass(frozen=True, eq=False, repr=False)
class Response(Told, Plotted):
    """Gain from an input to an output over frequency, its figures, and what a simulation gave where
    there was one.

    >>> from proofmass import read_graph, response
    >>> answer = response(read_graph("library:recorded_motion"), "motion.output", "mean.mean", frequencies=[1.0, 10.0])
    >>> answer.gain.shape, answer.unit, bool(abs(answer.gain[0]) > abs(answer.gain[1]))
    ((2,), '(m/s^2)/(m/s^2)', True)
    """

    input: str  # "block.port"
    output: str  # "block.port"
    unit: str  # of the gain
    output_unit: str  # of the output
    wires: WireResponse  # the response of every wire in a period
    frequencies: Array  # Hz
    gain: Complex  # complex, in `unit`, at these frequencies
    time: float  # of the operating point, in seconds
    notes: tuple[str, ...]  # on the operating point
    simulated: Simulated | None = None  # the gains of a simulation

    @cached_property
    def phase(self) -> Array:
        """Phase in radians at the frequencies, with all turns from rest, or from the lowest frequency that is shown."""
        shown = self._samples
        return counted_phase(self.wires.gain, shown.w, shown.values)[np.searchsorted(shown.w, self.frequencies)]

    @cached_property
    def at_rest(self) -> float:
        """Gain at 0 Hz; infinite where the output does not settle."""
        if self.wires.radius >= 1.0:
            return math.inf
        gain = float(np.real(self.wires.gain(np.zeros(1))[0]))
        return gain if abs(gain) > _AT_REST * self.peak[1] else 0.0

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Frequency and size of the largest gain, rest included where the output settles."""
        return highest(self._samples, np.abs)

    @cached_property
    def reference(self) -> tuple[float, float]:
        """Frequency and size of the gain that the corners are 3 dB below: at rest, or the peak where that is zero."""
        return (0.0, abs(self.at_rest)) if self.at_rest and math.isfinite(self.at_rest) else self.peak

    @cached_property
    def corners(self) -> tuple[float | None, float | None]:
        """The band about the reference in which the gain falls by less than 3 dB; None where it does not fall.

        What does not settle has none: its gain is without limit.
        """
        if not math.isfinite(self.at_rest):
            return None, None
        middle, size = self.reference
        frequencies = self._samples.w
        fallen = np.abs(self._samples.values) < _HALF * size
        below = np.flatnonzero(fallen & (frequencies < middle))
        above = np.flatnonzero(fallen & (frequencies > middle))
        shown: list[float] = frequencies.tolist()
        low = self._between(shown[below[-1]], min(shown[below[-1] + 1], middle)) if len(below) else None
        high = self._between(shown[above[0]], max(shown[above[0] - 1], middle)) if len(above) else None
        return low, high

    @property
    def bandwidth(self) -> float | None:
        """Hz to which the gain is within 3 dB of that at rest; None where it never falls so far, or does not settle."""
        return self.corners[1]

    @cached_property
    def delay(self) -> float:
        """Group delay at the frequency of the reference, in seconds."""
        middle = self.reference[0]
        logs = np.log(self.wires.poles[np.abs(self.wires.poles) > 0.0]) / (2j * np.pi * self.wires.period)
        near = float(np.min(np.abs(middle - logs), initial=self.wires.top))
        around = self.wires.gain(middle + np.array([-1.0, 1.0]) * _STEP * near)
        return float(-np.angle(around[1] / around[0]) / (4.0 * np.pi * _STEP * near))

    @cached_property
    def step_response(self) -> StepResponse | None:
        """The response to a step of one; None where it does not settle."""
        return step_response(self.wires)

    @property
    def step(self) -> StepFigures | None:
        """Rise, settling and overshoot; None where the output does not settle."""
        return self.step_response.figures if self.step_response else None

    @cached_property
    def _samples(self) -> Samples:
        """The response on a grid of its own, so that no figure depends on the frequencies that are asked for."""
        rest = [0.0] * (self.wires.radius < 1.0)
        return Samples.on(np.unique([*rest, *_shown(self.wires), *self.frequencies]), self.wires.gain)

    def _between(self, fallen: float, passing: float) -> float:
        """Frequency between two at which the gain is 3 dB below the reference."""
        low, high = float(fallen), float(passing)
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            below = abs(self.wires.gain(np.array([middle]))[0]) < _HALF * self.reference[1]
            low, high = (middle, high) if below else (low, middle)
        return high

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        low, high = self.corners
        return {
            "input": self.input, "output": self.output, "unit": self.unit, "time_s": self.time,
            "gain_at_rest": self.at_rest if math.isfinite(self.at_rest) else None,
            "peak": {"frequency_hz": self.peak[0], "gain": self.peak[1]},
            "low_corner_hz": low, "bandwidth_hz": high, "delay_s": self.delay,
            "step": self.step.as_data() if self.step else None,
            "frequencies_hz": self.frequencies.tolist(),
            "gain": np.abs(self.gain).tolist(), "phase_deg": np.degrees(self.phase).tolist(),
            "simulated": self.simulated.as_data() if self.simulated else None,
            "notes": list(self.notes),
        }  # fmt: skip


@named_arguments
def response(
    graph: GraphSource,
    input: str,
    output: str,
    *,
    at: At = AUTO,
    frequencies: Sequence[float] = (),
    simulate: StimulusKind | None = None,
    amplitude: str | float | None = None,
    band: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Response:
    """Return the response from one output to another, such as "acceleration.output" to "adc.number".

    The gain is that for small signals at the operating point, which is found, unless `at` names it,
    as in `linearise`. It is exact at the frequencies of the input's values; between continuous
    blocks signals count as held from tick to tick. It is given at some `frequencies` in Hz,
    ascending, or on a logarithmic grid.

    With `simulate` the graph itself is run with a stimulus on top of the input, quantisers, limits
    and noise included, and what comes out at its frequencies stands beside the linear response: a
    "sine" at one frequency after the other, a "multitone", a "chirp" or a "prbs", a pseudorandom
    binary sequence. Its peak value is `amplitude`, such as "1 mV" or a number in the input's unit,
    and it lies in a `band` in Hz.

    Raises `ModelError` for a graph that cannot be linearised, and where no way leads from the input
    to the output.

    `graph` is linearised; `input` and `output` are "block.port". `progress` is called with the runs
    that are done and all runs.

    >>> from proofmass import read_graph, response
    >>> answer = response(read_graph("library:recorded_motion"), "motion.output", "mean.mean")
    >>> round(answer.bandwidth, 1), round(answer.step.settling, 4)
    (44.3, 0.0103)
    """
    points = OperatingPoints(plan(graph), at)
    return response_at(
        points,
        input,
        output,
        frequencies_of(frequencies),
        simulate=simulate,
        amplitude=amplitude,
        band=band,
        progress=progress,
    )


def response_at(
    points: OperatingPoints,
    input: str,
    output: str,
    frequencies: Sequence[float] = (),
    *,
    simulate: StimulusKind | None = None,
    amplitude: str | float | None = None,
    band: tuple[float, float] | None = None,
    progress: Progress | None = None,
) -> Response:
    """Return the response as `response` does, at the first operating point that has one: several share the points."""
    planned = points.plan
    source, target = node_of(planned, input), node_of(planned, output)
    refuse_beyond(planned, source, target, frequencies)
    first = Ends((source,), (target,)).common_period(planned)
    at_tick = points.answered(lambda about: response_of(about, source, target, frequencies), first)
    if simulate is None:
        return at_tick
    peak, text = read_amplitude(planned, source, amplitude), amplitude if isinstance(amplitude, str) else ""
    stimulus = Stimulus(simulate, peak, band, text)
    run = simulated(
        planned,
        source,
        target,
        at_tick.wires,
        stimulus,
        round(at_tick.time / planned.period),
        at_tick.bandwidth,
        progress,
    )
    return replace(at_tick, simulated=run)


def refuse_beyond(planned: Plan, source: Endpoint, target: Endpoint, frequencies: Sequence[float]) -> None:
    """Raise `ModelError` for frequencies that neither values of the source nor of the target tell from lower ones."""
    most = 0.5 / (min(planned.stride(source), planned.stride(target)) * planned.period)
    wrong = [f for f in frequencies if not 0.0 <= f <= most * (1.0 + 1e-9)]
    if wrong:
        raise planned.graph.placed(
            problem_of_output(
                target,
                message="values at ticks have no response at this frequency of the signal",
                got=f"{wrong[0]:g} Hz",
                expected=f"0 Hz to {most:g} Hz, half the higher rate",
                hint=f"let {source[0]} or {target[0]} tick faster",
            )
        ).error


def response_of(
    about: Linearisation, source: Endpoint, target: Endpoint, frequencies: Sequence[float] = ()
) -> Response:
    """Return the linear response between two outputs about an operating point."""
    whole = about.map([source], [target])
    notes = (*whole.notes, *about.corner_notes(Ends((source,), (target,))))
    found = response_of_map(about.plan, source, target, replace(whole, notes=notes), frequencies)
    apart = nearest_mode(found.wires.poles)
    if not apart < NEAR:
        return found
    others = (response_of_map(about.plan, source, target, other, frequencies) for other in moved_maps(whole))
    note = known_note(_sizes(found), map(_sizes, others), apart)
    return replace(found, notes=(*found.notes, note)) if note else found


def response_of_map(
    planned: Plan, source: Endpoint, target: Endpoint, whole: PeriodMap, frequencies: Sequence[float] = ()
) -> Response:
    """Return the linear response of a map from one output to another."""
    wires = WireResponse.of(whole)
    if not any(part.any() for part in (wires.matrices[1], wires.matrices[3])):
        raise planned.graph.placed(unreached(source, target)).error
    shown = np.asarray(frequencies, dtype=np.float64) if len(frequencies) else _shown(wires)
    units = [planned.unit(node) for node in (target, source)]
    return Response(
        ".".join(source),
        ".".join(target),
        short_unit(f"({units[0]})/({units[1]})"),
        short_unit(units[0]),
        wires,
        shown,
        wires.gain(shown),
        whole.time,
        _notes(whole, wires),
    )


def _shown(wires: WireResponse) -> Array:
    corners = [max(f, w) for f, w in resonances(wires)]
    lowest = _BELOW * min([*corners, wires.top])
    even = np.linspace(0.0, wires.top, _EVEN).tolist()  # a delay turns the phase evenly
    return grid(wires, max(lowest, wires.top * 10.0**-_DECADES), wires.top, even)


def _sizes(of: Response) -> list[float | None]:
    return [of.peak[1], of.at_rest, *of.corners]


def _notes(whole: PeriodMap, wires: WireResponse) -> tuple[str, ...]:
    if wires.radius < 1.0:
        return whole.notes
    growth = f"a mode of size {wires.radius:.6g} a period of {wires.period:.3g} s"
    return (*whole.notes, f"the output does not settle after a step: {growth}")


def unreached(source: Endpoint, target: Endpoint) -> Problem:
    """Return that one output does not move another one."""
    return problem_of_output(
        source,
        message=f"{'.'.join(source)} does not move {'.'.join(target)}",
        expected="wires that lead from the one to the other, through blocks that pass small changes on",
        hint="a limit may be reached, or a switch be open at this time: try another one with --at",
    )
