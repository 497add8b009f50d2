"""Nonlinear least squares for the unknowns of a graph: Levenberg and Marquardt's steps within bounds, from SciPy.

Residuals are differences between recording and run, divided by the noise of each output, which is
estimated again from what is left. Derivatives are central differences between runs. Their steps
move an output by a small part of its size, and by many codes of a converter, whose steps
derivatives at a point would not see.
"""

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize

from proofmass.runner.design.identification.identifiable import UNCERTAIN
from proofmass.runner.design.identification.model import RecordingModel
from proofmass.runner.design.identification.unknowns import DELAY, OFFSET, Unknown
from proofmass.runner.design.quantities.stopping import go_on
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.progress import Progress

LOSSES = {"linear": "linear", "robust": "soft_l1", "outliers": "cauchy"}
_FIRST_STEP = 1e-4  # relative step of an unknown before its standard error is known
_SMALLEST, _LARGEST = 1e-7, 1e-2  # bounds of the relative step of an unknown
_WIDEST, _WIDENINGS, _ALIKE = 1.0, 8, 0.7  # of one that moves codes alone; how often it may be; logarithm of a change
_MOVED, _CODES = 3e-3, 10.0  # a step moves an output by this part of its size, or so many codes
_OF_CODED = 0.3  # part of its size by which it moves at least what comes in codes
_FEW_CODES = 0.5  # an output with fewer values than this part of its rows comes from a converter
_WHOLE = 1e-6  # or one that has values twice, which lie whole numbers of steps apart to this part
_PASSES, _SETTLED = 4, 0.01  # passes of the estimate of noise, and its last relative change
_WEAK, _LOOSER = 3.0, 10.0  # what recordings do not determine may stray by so many sizes, or more if that is too few
_HELD, _SIGNIFICANT, _NOTHING = 24, 3.0, 1e-8  # passes; what is no noise, in units of it; part that is rounding
_LOOKS, _FURTHER, _NEAR_SIZE = 40, 1e4, 10.0  # of the size of what begins at zero: runs, factors, and how near it is
_OF_DELAYS = 0.125  # of a recording: about the size of a delay
_POLISHES, _NEAR, _ROUGH = 4, 3.0, 1.0  # last steps; length in units of noise; increase of squares
_STILL = 0.1  # a step this small, in units of the noise, is the last
_TINY, _TIMES = 1e-3, 3.0  # part of a step to which only rounding responds, and how far it may exceed that response
_FAILED = 1e6  # residual of a run that fails
_minimise: Any = scipy.optimize.least_squares


@dataclass(frozen=True)
class Solution:
    """End of a fit: the unknowns, residuals by the noise, their derivatives, the noise."""

    values: AnyArray
    residuals: AnyArray  # of recordings alone
    jacobian: AnyArray  # by the unknowns, priors below
    noise: Mapping[str, float]  # of each output
    free: Mapping[str, float]  # degrees of freedom that are left of each output
    cost: float
    converged: bool


class UnknownsSolver:
    """Solves for the unknowns over all recordings."""

    def __init__(
        self,
        models: Sequence[RecordingModel],
        unknowns: Sequence[Unknown],
        loss: str,
        skip: float,
        progress: Progress | None,
        stop: threading.Event | None,
    ) -> None:
        self.models, self.unknowns, self.loss = models, unknowns, loss
        self._progress = progress
        self._stop: threading.Event | None = None
        self.best: tuple[float, AnyArray] | None = None
        long = _OF_DELAYS * min(model.recording.duration for model in models)
        self.scales = np.array([long if u.name.startswith(DELAY) else u.scale for u in unknowns])
        self.masks = [
            [np.isfinite(m.recording.outputs[s]) & (m.recording.times >= skip) for s in m.signals] for m in models
        ]
        self.signals = sorted({signal for model in models for signal in model.signals})
        places = [self.signals.index(signal) for model in models for signal in model.signals]
        self.output_of = np.repeat(places, [np.sum(mask) for masks in self.masks for mask in masks])  # each residual
        self.noise = {signal: self.spread(signal) for signal in self.signals}
        begin = np.array([unknown.start for unknown in unknowns])
        self._expected, self._code, self._rounding = 1, dict.fromkeys(self.signals, 0.0), dict[str, float]()
        at_start = self.raw(begin)
        for number, unknown in enumerate(unknowns):
            if unknown.sizeless:
                self.scales[number] = self._size(number, begin, at_start)
        self._steps = _FIRST_STEP * self.scales
        self.raw(begin)
        self._code = {signal: self._step_of_codes(signal) for signal in self.signals}
        self._rounding = {signal: self._rounding_of(signal) for signal in self.signals}
        self._suit_steps(begin)
        self._stop = stop  # from here on Ctrl-C leaves a usable result

    @property
    def runs(self) -> int:
        """Number of runs of the graph."""
        return sum(model.runs for model in self.models)

    def compared(self, signal: str) -> AnyArray:
        """Return the recorded values of an output that are compared, of all recordings."""
        parts = [
            model.recording.outputs[signal][mask]
            for model, masks in zip(self.models, self.masks, strict=True)
            for name, mask in zip(model.signals, masks, strict=True)
            if name == signal
        ]
        return np.concatenate(parts)

    def spread(self, signal: str) -> float:
        """Return how much an output moves in all recordings."""
        values = self.compared(signal)
        if not len(values):
            return 1.0
        return float(np.std(values)) or float(np.max(np.abs(values))) or 1.0

    def recorded(self) -> float:
        """Return the norm of all recorded values in units of the noise."""
        return math.hypot(*(float(np.linalg.norm(self.compared(s))) / self.noise[s] for s in self.signals))

    def solved(self, begin: AnyArray) -> Solution:
        """Return the solution from a start: again with the noise left, until that settles and nothing holds it back."""
        values, best, free, weak = begin, self._least_squares(begin, _WEAK), False, _WEAK
        rest = dict[str, float]()
        for number in range(_HELD):
            best = self._least_squares(values, weak) if number else best
            free = not self._held_back(best, values, weak)
            weak *= 1.0 if free else _LOOSER
            values = best.x * self.scales
            rest = self._free(best.jac[: -len(values) or None])
            left = self._noise_left(self.raw(values), rest)
            change = max(abs(math.log(left[s] / self.noise[s])) for s in self.signals)
            self.noise = left
            self._suit_steps(values)
            if free and ((change < _SETTLED and number) or number + 1 >= _PASSES):
                break
        if self.loss == "linear":
            values = self._polished(values)
        residuals, jacobian = self.residuals(values), self.jacobian(values)
        return Solution(
            values, residuals, jacobian, dict(self.noise), rest, float(best.cost), bool(best.success) and free
        )

    def _size(self, number: int, begin: AnyArray, at_start: list[tuple[str, AnyArray]]) -> float:
        """Return how far an unknown that begins at zero goes to move some output by about as much as is recorded."""
        sizes = {signal: float(np.sqrt(np.mean(self.compared(signal) ** 2))) or 1.0 for signal in self.signals}
        side = 1.0 if self.unknowns[number].at_most > 0.0 else -1.0
        size, moved = self.scales[number], begin.copy()
        for _ in range(_LOOKS):
            moved[number] = side * size
            pairs = zip(at_start, self.raw(moved), strict=True)
            effects = [float(np.sqrt(np.mean((b - a) ** 2))) / sizes[s] for (s, a), (_, b) in pairs if len(a)]
            effect = max(effects, default=0.0)
            if 1.0 / _NEAR_SIZE <= effect <= _NEAR_SIZE:
                return float(size)
            size *= min(max(1.0 / effect if effect else _FURTHER, 1.0 / _FURTHER), _FURTHER)
        return float(self.scales[number])

    def _polished(self, values: AnyArray) -> AnyArray:
        """Return the values after whole Gauss-Newton steps, which converters in a loop do not stop.

        Their codes round anew at every value, so that the sum of squares is rough. The search
        before may stop where a step gains less than that: further steps go by the derivatives,
        which look past codes.
        """
        rough = 0.0
        for number in range(_POLISHES):
            before = self._weighted(values)
            table = self.jacobian(values) * self.scales
            step = np.linalg.lstsq(table, -before, rcond=1e-8)[0] * self.scales
            rough = rough if number else self._roughness(values, before, table)
            tried, length = values + step, float(np.linalg.norm(table @ (step / self.scales)))
            inside = all(u.at_least <= v <= u.at_most for u, v in zip(self.unknowns, tried, strict=True))
            if not inside or length > _NEAR + math.sqrt(rough):
                break
            after = self._weighted(tried)
            if float(after @ after) > float(before @ before) + _ROUGH + rough:
                break
            values = tried
            if length < _STILL:
                break
        return values

    def _weighted(self, values: AnyArray) -> AnyArray:
        return np.concatenate([self.residuals(values), self._prior(values)])

    def _roughness(self, values: AnyArray, before: AnyArray, table: AnyArray) -> float:
        """Return by how much rounding alone moves the sum of squares: in steps of nothing else."""
        lengths = np.linalg.norm(table, axis=0)
        tiny = _TINY * self.scales / np.where(lengths > 0.0, lengths, math.inf)
        sides = [values + side * tiny for side in (1.0, -1.0, 2.0, -2.0)]
        sums = [float(np.sum(self._weighted(near) ** 2)) for near in sides]
        return _TIMES * max(abs(total - float(before @ before)) for total in sums)

    def _least_squares(self, values: AnyArray, weak: float) -> Any:
        low, high = (
            np.array([getattr(u, key) for u in self.unknowns]) / self.scales for key in ("at_least", "at_most")
        )
        inside = np.clip(values / self.scales, low + 1e-12, high - 1e-12)
        hold = np.eye(len(self.unknowns)) / weak
        return _minimise(
            lambda x: np.concatenate([self._all(x * self.scales), (x - inside) / weak]),
            inside,
            jac=lambda x: np.vstack([self.jacobian(x * self.scales) * self.scales, hold]),
            bounds=(low, high),
            method="trf",
            loss=LOSSES[self.loss],
            x_scale="jac",
            xtol=1e-10,
            ftol=1e-10,
            gtol=1e-10,
            max_nfev=60,
        )

    def _held_back(self, best: Any, values: AnyArray, weak: float) -> bool:
        """Return whether a pass ended elsewhere, in units of the noise, because it was held to its start.

        There the pull of the hold is that of the residuals, which is given along the combinations
        of the unknowns that the recordings determine one by one.
        """
        inner = np.flatnonzero(best.active_mask == 0)
        sizes = np.maximum(np.abs(best.x), 1.0)[inner]
        pull = (best.x - values / self.scales)[inner] / weak**2 * sizes
        _, singular, turned = np.linalg.svd(best.jac[: -len(values), inner] * sizes, full_matrices=False)
        known = singular > _NOTHING * np.max(singular, initial=0.0)
        lengths = np.abs(turned[known] @ pull) / singular[known]
        return bool(np.any(lengths > np.where(singular[known] * UNCERTAIN > 1.0, _STILL, _SIGNIFICANT)))

    def _all(self, values: AnyArray) -> AnyArray:
        residuals = self._weighted(values)
        cost = float(residuals @ residuals)
        if self.best is None or cost < self.best[0]:
            self.best = cost, values.copy()
        return residuals

    def residuals(self, values: AnyArray) -> AnyArray:
        """Return the residuals of all recordings in units of the noise."""
        raw = self.raw(values)
        return np.concatenate([part / self.noise[signal] for signal, part in raw])

    def interrupt(self) -> None:
        """Let what is left to do run without a look at Ctrl-C."""
        self._stop = None

    def as_it_is(self, values: AnyArray) -> Solution:
        """Return the state of affairs at some values."""
        rest = self._free(self.jacobian(values) * self.scales)
        self.noise = self._noise_left(self.raw(values), rest)
        residuals, jacobian = self.residuals(values), self.jacobian(values)
        return Solution(values, residuals, jacobian, dict(self.noise), rest, math.inf, False)

    def modelled(self, values: AnyArray) -> list[dict[str, AnyArray]]:
        """Return the outputs of each recording, offsets and delays included; NaN where nothing is compared."""
        parts = iter(self.raw(values))
        outputs = []
        for model, masks in zip(self.models, self.masks, strict=True):
            by_signal = {}
            for signal, mask in zip(model.signals, masks, strict=True):
                by_signal[signal] = np.full(len(mask), np.nan)
                by_signal[signal][mask] = next(parts)[1] + model.recording.outputs[signal][mask]
            outputs.append(by_signal)
        return outputs

    def raw(self, values: AnyArray) -> list[tuple[str, AnyArray]]:
        """Return differences of run and recording of each output, by recording."""
        go_on(self._stop)
        if self._progress:
            self._expected = max(self._expected, self.runs + 2 * len(self.unknowns) + 1)
            self._progress(self.runs, self._expected)
        by_name = dict(zip((unknown.name for unknown in self.unknowns), values.tolist(), strict=True))
        parameters = {u.name: by_name[u.name] for u in self.unknowns if u.of_block}
        delays = {name.removeprefix(f"{DELAY} "): value for name, value in by_name.items() if name.startswith(DELAY)}
        parts = []
        for model, masks in zip(self.models, self.masks, strict=True):
            outputs = model.outputs(parameters, {s: d for s, d in delays.items() if s in model.signals})
            for number, (signal, mask) in enumerate(zip(model.signals, masks, strict=True)):
                measured = model.recording.outputs[signal][mask]
                if outputs is None:
                    parts.append((signal, np.full(len(measured), _FAILED * self.noise[signal])))
                else:
                    offset = by_name.get(f"{OFFSET} {signal}", 0.0)
                    parts.append((signal, np.asarray(outputs[number][mask] + offset - measured)))
        return parts

    def _prior(self, values: AnyArray) -> AnyArray:
        known = [(i, u) for i, u in enumerate(self.unknowns) if math.isfinite(u.uncertainty)]
        return np.array([(values[i] - u.expected) / u.uncertainty for i, u in known])

    def jacobian(self, values: AnyArray) -> AnyArray:
        """Return the derivatives of residuals and priors by the unknowns."""
        columns = list[AnyArray]()
        for number, unknown in enumerate(self.unknowns):
            step = self._steps[number]
            ends = []
            for side in (1.0, -1.0):
                moved = values.copy()
                moved[number] = min(max(values[number] + side * step, unknown.at_least), unknown.at_most)
                ends.append((moved[number], self._weighted(moved)))
            (above, higher), (below, lower) = ends
            columns.append((higher - lower) / (above - below))
        return np.stack(columns, axis=1) if columns else np.zeros((len(self._weighted(values)), 0))

    def _free(self, table: AnyArray) -> dict[str, float]:
        """Return the rows of each output less its part of the unknowns: the sum of their leverages."""
        sides, singular, _ = np.linalg.svd(table, full_matrices=False)
        known = singular > _NOTHING * np.max(singular, initial=0.0)
        used = np.sum(sides[: len(self.output_of), known] ** 2, axis=1)
        rest = np.bincount(self.output_of, weights=1.0 - used, minlength=len(self.signals))
        return {signal: max(float(free), 1.0) for signal, free in zip(self.signals, rest, strict=True)}

    def _noise_left(self, raw: list[tuple[str, AnyArray]], free: Mapping[str, float]) -> dict[str, float]:
        """Return the noise of each output: what is left, less the unknowns' share; of outliers their middle."""
        left = {}
        for signal in self.signals:
            values = np.concatenate([part for name, part in raw if name == signal])
            size = float(np.sqrt(np.mean(values**2)))
            if self.loss != "linear":
                size = 1.4826 * float(np.median(np.abs(values)))
            least = max(1e-9 * self.spread(signal), self._rounding[signal])  # of data without noise
            left[signal] = max(size * math.sqrt(len(values) / free[signal]), least)
        return left

    def _suit_steps(self, values: AnyArray) -> None:
        """Take steps that move some output by a part of its size, and by many steps of a converter.

        Where that takes a large part of an unknown, as of coarse codes, they move codes alone by
        what is least. What a step moves follows from any other where outputs are smooth; codes have
        to be moved.
        """
        coded = any(self._code.values())
        for _ in range(_WIDENINGS if coded else 1):
            columns, place = np.abs(self.jacobian(values) * self._steps), 0
            wanted, least = np.zeros(len(values)), np.zeros(len(values))  # parts of these that the steps move
            smooth = np.zeros(len(values), dtype=bool)
            for signal, part in self.raw(values):
                rows, code, spread = columns[place : place + len(part)], self._code[signal], self.spread(signal)
                place += len(part)
                moved = np.sqrt(np.mean(rows**2, axis=0)) * self.noise[signal] if len(rows) else 0.0 * wanted
                wanted = np.maximum(wanted, moved / max(_MOVED * spread, _CODES * code))
                least = np.maximum(least, moved / max(code, _OF_CODED * spread))
                smooth |= (moved > 0.0) & (code == 0.0)
            steps, before = self._steps / self.scales, self._steps
            with np.errstate(divide="ignore"):
                largest = np.where(smooth, _LARGEST, np.clip(steps / least, _LARGEST, _WIDEST))
                suited = np.where(wanted > 0.0, steps / wanted, _LARGEST)
            self._steps = np.asarray(np.clip(suited, _SMALLEST, largest) * self.scales)
            if np.all(np.abs(np.log(self._steps / before)) < _ALIKE):
                return

    def _step_of_codes(self, signal: str) -> float:
        """Return the step between the values of an output that a converter makes; 0 where it moves smoothly."""
        model = next(model for model in self.models if signal in model.signals)
        rows = model.rows[model.signals.index(signal)]
        if rows.dtype.kind == "i":
            return 1.0
        known = np.unique(rows)
        gaps = np.diff(known)
        if not 1 < len(known) < len(rows):
            return 0.0
        codes = gaps / np.min(gaps)
        few = len(known) < _FEW_CODES * len(rows)
        return float(np.median(gaps)) if few or np.all(np.abs(codes - np.round(codes)) < _WHOLE * codes) else 0.0

    def _rounding_of(self, signal: str) -> float:
        """Return the rms error of a recording in codes, which may agree with a run to the last one; 0 of others."""
        gaps = np.diff(np.unique(self.compared(signal)))
        if not (self._code[signal] and len(gaps)):
            return 0.0
        step = float(np.min(gaps))
        whole = np.all(np.abs(gaps / step - np.round(gaps / step)) <= _WHOLE * gaps / step)
        return step / math.sqrt(12.0) if whole else 0.0
