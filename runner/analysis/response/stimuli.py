"""Periodic stimuli: sines one after the other, many at once, a chirp, a pseudorandom binary sequence.

One repetition has N common periods of the graph, so that all that comes out of a settled linear
system lies on the lines k / (N T), and no window is needed (Pintelon and Schoukens, System
Identification, 2012, chapter 2). Phases of the multitone are Schroeder's (IEEE Trans. Information
Theory 16, 1970, 85), which keep its peak low.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from proofmass.blocks.declaration.problem import Problem, did_you_mean
from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.host.arrays import Array

StimulusKind = Literal["sine", "multitone", "chirp", "prbs"]
KINDS: tuple[str, ...] = get_args(StimulusKind)
OF_TONES = ("sine", "multitone")  # with nothing between the lines that are looked at
_TONES = {"sine": 12, "multitone": 40, "chirp": 60, "prbs": 60}  # frequencies that are looked at
_BELOW, _ABOVE = 1.0 / 20.0, 10.0  # of the bandwidth, where a band begins and ends unless said
_HIGHEST = 0.9  # of the highest frequency that can be told
_LEAST = 0.05  # of the largest line: one that a chirp moves too little to be looked at
_LONGEST = 1 << 22  # values of one repetition


@dataclass(frozen=True)
class Stimulus:
    """Stimulus on top of an input: a kind, its peak value in the input's unit, and a band in Hz."""

    kind: StimulusKind
    amplitude: float
    band: tuple[float, float] | None = None
    written: str = ""  # the peak value as it was written, where it was a text


@dataclass(frozen=True)
class Repetition:
    """One repetition: a value for each value of the input, and the lines that are looked at."""

    values: Array
    lines: "np.ndarray[tuple[int], np.dtype[np.intp]]"
    periods: int  # common periods of the graph

    def frequencies(self, period: float) -> Array:
        """Frequencies of the lines in Hz."""
        return np.asarray(self.lines / (self.periods * period))

    def spectrum(self, entries: int) -> "np.ndarray[tuple[int, int], np.dtype[np.complex128]]":
        """Fourier coefficients over the periods, of each value of a period: a row a line."""
        lifted = np.fft.fft(self.values.reshape(self.periods, entries), axis=0) / self.periods
        return np.asarray(lifted[self.lines % self.periods])


def repetitions(of: Stimulus, wires: WireResponse, bandwidth: float | None) -> list[Repetition]:
    """Return the stimuli to run, one after the other; raises `ModelError` for an unfit band."""
    if of.kind not in KINDS:
        hint = did_you_mean(of.kind, KINDS, "the stimuli")
        raise Problem(message="there is no such stimulus", key="simulate", got=of.kind, hint=hint).error
    low, high = _band(of, wires, bandwidth)
    periods = max(4, math.ceil(1.0 / (low * wires.period) - 1e-9))
    if periods * wires.entries > _LONGEST:
        raise _too_low(low, wires).error
    if of.kind == "prbs":
        periods = (1 << max(3, (periods + 1).bit_length())) - 1
    span = periods * wires.period
    first, last = max(1, round(low * span)), max(1, math.floor(high * span + 1e-9))
    lines = np.unique(np.round(np.geomspace(first, last, _TONES[of.kind])).astype(np.intp))
    return [
        Repetition(np.asarray(shape * (of.amplitude / np.max(np.abs(shape)))), chosen, periods)
        for shape, chosen in _shapes(of.kind, lines, periods, wires.entries)
    ]


def _shapes(
    kind: StimulusKind, lines: "np.ndarray[tuple[int], np.dtype[np.intp]]", periods: int, entries: int
) -> "Iterator[tuple[Array, np.ndarray[tuple[int], np.dtype[np.intp]]]]":
    turn = 2.0 * np.pi * np.arange(periods * entries) / (periods * entries)
    if kind == "sine":
        for line in lines:
            yield np.sin(line * turn), np.array([line])
    elif kind == "multitone":
        order = np.arange(len(lines))
        phases = -np.pi * order * (order - 1) / len(lines)
        yield np.sum([np.cos(k * turn + phase) for k, phase in zip(lines, phases, strict=True)], axis=0), lines
    elif kind == "chirp":  # from the first line to the last: it ends in the phase it began with
        first, last = int(lines[0]), int(lines[-1])
        last += (first + last) % 2
        part = turn / (2.0 * np.pi)
        shape = np.sin(2.0 * np.pi * (first + 0.5 * (last - first) * part) * part)
        sizes = np.abs(np.fft.fft(shape)[lines])
        yield shape, lines[sizes >= _LEAST * np.max(sizes)]
    else:
        # start-up time: scipy.signal takes 0.3 s, and the other stimuli need none of it
        import scipy.signal

        bits = scipy.signal.max_len_seq(periods.bit_length())[0]
        yield np.repeat(2.0 * bits - 1.0, entries), lines


def _band(of: Stimulus, wires: WireResponse, bandwidth: float | None) -> tuple[float, float]:
    """The band in which a stimulus lies: of several tones those that no rate of the graph folds onto each other."""
    top = wires.top if of.kind == "sine" else 0.5 / wires.period
    if of.band is None:
        middle = min(bandwidth or top, top)
        return _BELOW * middle, min(_ABOVE * middle, _HIGHEST * top)
    low, high = of.band
    if not 0.0 < low < high < top * (1.0 + 1e-9):
        raise Problem(
            message=f"the band does not suit a {of.kind}",
            key="band",
            got=f"{low:g} Hz to {high:g} Hz",
            expected=f"above 0 Hz, up to {top:g} Hz",
            hint=f"a sine may go up to {wires.top:g} Hz" if wires.top > top else "",
        ).error
    return low, high


def _too_low(low: float, wires: WireResponse) -> Problem:
    values = wires.entries / (low * wires.period)
    return Problem(
        message="one repetition of the stimulus would be too long",
        key="band",
        got=f"{low:g} Hz, {values:,.0f} values of the input",
        expected=f"at most {_LONGEST:,} values",
        hint="let the band begin at a higher frequency",
    )
