"""A response as text for people."""

import math

import numpy as np

from proofmass.runner.analysis.linearisation.step import StepFigures
from proofmass.runner.analysis.margins.text import seconds_text
from proofmass.runner.analysis.response.response import Response
from proofmass.runner.analysis.response.simulated import Simulated

_FAR = 100.0  # times the final value: a peak from which it has come back
_ROWS = 8  # of the linear response without a simulation


def response_text(of: Response) -> str:
    """A response for people."""
    unit = f" {of.unit}" if of.unit != "1" else ""
    low, high = of.corners
    settles = math.isfinite(of.at_rest)
    at_rest = f"{of.at_rest:.6g}{unit}" if settles else "without limit"
    beyond = f"above {of.wires.top:.5g} Hz" if settles else "none"
    lines = [
        f"{of.output} by {of.input}, linear at {of.time:g} s",
        f"  gain at 0 Hz      {at_rest}",
        f"  largest gain      {of.peak[1]:.6g}{unit} at {of.peak[0]:.5g} Hz",
        *([f"  lower corner      {low:.5g} Hz, -3 dB"] if low else []),
        f"  bandwidth         {f'{high:.5g} Hz, -3 dB' if high else beyond}",
        f"  delay             {seconds_text(of.delay)} at {of.reference[0]:.5g} Hz",
        *_step_lines(of.step, unit),
    ]
    lines += _table(of) if of.simulated is None else _comparison(of.simulated, unit)
    return "\n".join([*lines, *(f"  note: {note}" for note in of.notes)])


def _step_lines(of: StepFigures | None, unit: str) -> list[str]:
    if of is None:
        return ["  step              does not settle"]
    if of.rise is None or abs(of.peak) > _FAR * abs(of.final):  # which times of rise and settling do not describe
        end = "zero" if of.rise is None else f"{of.final:.5g}{unit}"
        return [f"  step              peak {of.peak:.5g}{unit} after {seconds_text(of.peak_time)}, back to {end}"]
    settling = "does not settle to 2 %" if of.settling is None else f"settles to 2 % in {seconds_text(of.settling)}"
    under = f", undershoot {100.0 * of.undershoot:.3g} %" if of.undershoot else ""
    return [
        f"  step              rises from 10 % to 90 % in {seconds_text(of.rise)}, {settling},"
        f" overshoot {100.0 * (of.overshoot or 0.0):.3g} %{under}"
    ]


def _table(of: Response) -> list[str]:
    above = of.frequencies[of.frequencies > 0.0]  # rest lies in no decade
    wanted = [of.frequencies[0], *(np.geomspace(above[0], above[-1], _ROWS) if len(above) else ())]
    rows = sorted({int(np.argmin(np.abs(of.frequencies - frequency))) for frequency in wanted})
    lines = [f"  {'frequency [Hz]':>16} {'gain':>12} {'phase [deg]':>12}"]
    for row in rows:
        gain = complex(of.gain[row])
        lines.append(f"  {of.frequencies[row]:16.6g} {abs(gain):12.6g} {math.degrees(of.phase[row]):12.2f}")
    return lines


def _comparison(run: Simulated, unit: str) -> list[str]:
    peak = run.stimulus.written or f"{run.stimulus.amplitude:.6g} {run.input_unit}"
    lines = [
        f"simulated, {run.stimulus.kind} of {peak}, {run.ticks:,} ticks a run",
        f"  {'frequency [Hz]':>16} {'gain':>12} {'phase [deg]':>12} {'less linear [dB]':>18} {'[deg]':>10}",
    ]
    for i in np.argsort(run.frequencies):
        gain = complex(run.gain[i])
        lines.append(
            f"  {run.frequencies[i]:16.6g} {abs(gain):12.6g} {math.degrees(np.angle(gain)):12.2f}"
            f" {run.decibels[i]:18.4f} {run.degrees[i]:10.4f}"
        )
    rest = "" if run.rest is None else f"; at others it moves {100.0 * run.rest:.3g} % of what it moves there"
    return [*lines, f"  in all {100.0 * run.deviation:.3g} % from linear at these frequencies{rest}"]
