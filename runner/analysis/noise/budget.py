"""The noise budget of an output: what each source contributes, also at an input."""

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.call_numbers import frequencies_of
from proofmass.graphs.model.flatten import inside
from proofmass.graphs.model.graph import Endpoint, Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.analysis.decisions.one_bit import OneBit, noise_at, with_spectra
from proofmass.runner.analysis.decisions.truths import decided_by_noise
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import At, Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.analysis.linearisation.numbers import time_text
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, UnrepeatedError, late_by
from proofmass.runner.analysis.linearisation.periodic import PeriodicPoint
from proofmass.runner.analysis.linearisation.wire_response import grid
from proofmass.runner.analysis.margins.sensitivity import ranked
from proofmass.runner.analysis.noise.along_run import budgets_along, refusal
from proofmass.runner.analysis.noise.band import rule_of, within
from proofmass.runner.analysis.noise.derivatives import one_more, slopes_and_sizes
from proofmass.runner.analysis.noise.grid_errors import errors_about
from proofmass.runner.analysis.noise.noise_budget import DROPPED, QUANTISATION, NoiseBudget, NoiseSource
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map
from proofmass.runner.analysis.noise.validity import Dither, dithers, strained
from proofmass.runner.derivatives.dual_noise import ONE_BIT, ROUNDING, Noisy, noise_blocks, rounding_blocks, rounds
from proofmass.runner.derivatives.passed_on import reached_by_noise
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

_DECADES = 5.0  # below half the rate that are shown
DECISION = "one-bit quantisation"


class BudgetQuestion(NamedTuple):
    """Options of `noise`, of any output."""

    input: str = ""
    band: tuple[float, float] | None = None
    frequencies: Sequence[float] = ()
    derivatives: bool = False


_PLAIN = BudgetQuestion()


@named_arguments
def noise(
    graph: GraphSource,
    output: str,
    *,
    input: str = "",
    band: tuple[float, float] | None = None,
    at: At = AUTO,
    frequencies: Sequence[float] = (),
    derivatives: bool = False,
) -> NoiseBudget:
    """The noise budget of an output: density and rms of what each source makes there, exactly for small signals.

    Sources are blocks that draw random numbers, those of a user too, and quantisers, whose error
    counts as white, and uniform over one step or over the levels that are left of it. What
    sampling, holding and decimation fold into the band is in it. `band` is in Hz, up to half the
    rate of the output unless said; `at` is the operating point, as in `linearise`. With an `input`
    the density is referred to it as well. Densities are those at some `frequencies` in Hz,
    ascending, or on a logarithmic grid.

    With `derivatives` those of the rms by every real parameter come too, exactly, and what one more
    of each whole number of a quantiser does to it, such as one more bit.

    Raises `ModelError` for a graph that cannot be linearised, and for an output no noise reaches.

    `graph` is linearised; `output` and `input` are "block.port".

    >>> from proofmass import noise, read_graph
    >>> budget = noise(read_graph("library:recorded_motion"), "mean.mean", input="motion.output")
    >>> [(source.block, f"{source.share:.0%}") for source in budget.sources]
    [('amplifier', '66%'), ('gas', '26%'), ('adc', '7%')]
    """
    wanted = BudgetQuestion(input, band, frequencies_of(frequencies), derivatives)
    return budget_at(OperatingPoints(plan(graph), at), output, wanted)


def budget_at(points: OperatingPoints, output: str, wanted: BudgetQuestion = _PLAIN) -> NoiseBudget:
    """Return the budget of an output at an operating point; raises `ModelError`."""
    (answer,) = budgets_at(points, [output], wanted)
    if isinstance(answer, ModelError):
        raise answer
    return answer


def budgets_at(
    points: OperatingPoints, outputs: Sequence[str], wanted: BudgetQuestion = _PLAIN
) -> list[NoiseBudget | ModelError]:
    """Return the budget of each output, or why it has none: the operating point is looked for once.

    Where there is none since the orbit does not come back, the budgets are those along the run.
    """
    answers = list[NoiseBudget | ModelError]()
    beside = _beside(points, outputs, wanted.input) if len(outputs) > 1 else {}
    for output in outputs:
        try:
            answers.append(_budget_about(points, output, wanted, beside.get(output, ())))
        except ModelError as error:
            answers.append(error)
    left = [i for i, answer in enumerate(answers) if isinstance(answer, UnrepeatedError)]
    if left and points.at == AUTO and not wanted.input and not wanted.derivatives:
        found = budgets_along(points, [outputs[i] for i in left], wanted.band, wanted.frequencies)
        for i, answer in zip(left, found, strict=True):
            answers[i] = answer
    return answers


def _beside(points: OperatingPoints, outputs: Sequence[str], input: str) -> dict[str, list[Endpoint]]:
    """Return the outputs whose maps have the period of that of each output, and blocks of it, where
    they are several.

    Maps that share no block are taken apart: together they would be mostly zeros.
    """
    planned, groups = points.plan, list[tuple[int, set[str], list[str]]]()
    drawing = noise_blocks(planned)
    sources = (node_of(planned, input),) if input else ()
    for output in outputs:
        with suppress(ModelError):  # its own budget says so
            target, own = node_of(planned, output), [output]
            if target not in _reached(points, drawing):
                continue
            ends = Ends(sources, (target,), noise=drawing)
            period, blocks = ends.common_period(planned), ends.blocks(planned)[1]
            joined = [group for group in groups if group[0] == period and not group[1].isdisjoint(blocks)]
            for _, others, names in joined:
                blocks, own = blocks | others, own + names
            groups = [*(group for group in groups if group not in joined), (period, blocks, own)]
    return {output: [node_of(planned, o) for o in own] for _, _, own in groups if len(own) > 1 for output in own}


def _budget_about(
    points: OperatingPoints, output: str, wanted: BudgetQuestion, beside: Sequence[Endpoint]
) -> NoiseBudget:
    """Return the budget at the first operating point that has one."""
    planned, (input, band, frequencies, derivatives) = points.plan, wanted
    target = node_of(planned, output)
    sources = [node_of(planned, input)] if input else []

    def ask(about: Linearisation) -> tuple[Linearisation, Noisy, PeriodMap, NoiseMap]:
        noisy = noise_at(about, [target])
        exact = about.map(sources, [target], noise=noisy, by_parameters=derivatives, beside=beside)
        whole = with_spectra(exact, noisy)
        to_output = noise_map(whole, target)
        if to_output.grows:
            message = f"the noise of {output} grows without end: a loop is unstable"
            got = f"a mode that grows by {to_output.radius:.6g} in {to_output.period:.3g} s"
            hint = "proofmass margins says how stable the loops are; another operating point may do: --at"
            raise refusal(planned, output, message, got, hint)
        drawn = [column for column, variance in enumerate(to_output.variances) if variance]
        _, b, _, d = to_output.matrices
        if not to_output.sources or not (np.any(b[:, drawn]) or np.any(d[:, drawn])):
            raise silence(about, target, len(to_output.sources), noisy)
        return about, noisy, whole, to_output

    drawing = noise_blocks(planned)
    upstream = upstream_of(planned, target[:1]) & drawing.keys()
    if not upstream:
        raise _no_noise(planned, output, 0)
    first = Ends(tuple(sources), (target,), noise=drawing).common_period(planned)  # in tick 0 processes start
    if target not in _reached(points, drawing):
        raise silence(points.after_start(first), target, len(upstream), {})
    about, noisy, whole, to_output = points.answered(ask, first)
    ends = Ends(tuple(sources), (target,), noise=noisy, beside=tuple(beside))
    strain = "" if isinstance(about.point, PeriodicPoint) else strained(about, ends, target, whole, to_output)
    errors, to_quantisers = errors_about(about, ends)
    moved = [one for given in to_quantisers for one in dithers(errors.of(given), about.course.kept, errors.apart)]
    to_output = noise_map(errors.of(whole), target)
    limits = _band(to_output, band)
    squares = rule_of(to_output, limits)[2] if band is not None or not to_output.settles else to_output.mean_squares
    low = limits[0] if limits[0] > 0.0 else 0.5 * to_output.rate * 10.0**-_DECADES
    _refuse_beyond(frequencies, 0.5 * to_output.rate)
    shown = np.asarray(frequencies, dtype=np.float64) if len(frequencies) else grid(to_output, low, limits[1])
    densities = to_output.densities(shown)
    sources_made = _sources(planned, to_output.sources, squares, densities, moved)
    total = float(np.sum(squares))
    budget = NoiseBudget(
        output=output,
        unit=short_unit(planned.unit(target)),
        rate=to_output.rate,
        band=limits,
        sources=tuple(sorted(sources_made, key=lambda source: (-source.rms, source.block, source.kind))),
        rms=math.sqrt(total),
        frequencies=shown,
        density=np.sum(densities, axis=1),
        input=input,
        input_unit=short_unit(planned.unit(sources[0])) if sources else "",
        gain=to_output.gain(shown, sources[0], late_by(planned, sources[0], target))
        if sources
        else np.zeros(0, dtype=complex),
        period=to_output.period,
        notes=(
            *whole.notes,
            *_notes(noisy, sources_made, to_output, band, derivatives),
            *filter(None, [strain]),
            *_lost(about, target),
        ),
    )
    if not derivatives:
        return budget
    counted = limits if band is not None or not to_output.settles else None
    slopes, sizes = slopes_and_sizes(to_output, counted, budget.rms)
    rounding = [source.block for source in sources_made if source.kind in (QUANTISATION, DROPPED)]

    def again(changed: Graph) -> float:
        return noise(changed, output, band=band, at=points.at, frequencies=shown[:1].tolist()).rms

    return replace(
        budget,
        derivatives=ranked(
            planned, f"noise of {output}", budget.unit, budget.rms, slopes, whole.undefined, sizes=sizes
        ),
        steps=tuple(one_more(planned, rounding, budget.rms, again)),
    )


def _sources(
    planned: Plan, entries: Sequence[Endpoint], squares: Array, densities: Array, moved: Sequence[Dither]
) -> list[NoiseSource]:
    """Return the sources, all roundings of a fixed-point block as one."""
    columns: dict[tuple[str, str], list[int]] = {}
    for column, (name, part) in enumerate(entries):
        kinds = {ROUNDING: QUANTISATION, ONE_BIT: DECISION}
        kind = kinds.get(part) or (DROPPED if rounds(part) else type(planned.blocks[name]).__name__)
        columns.setdefault((name, kind), []).append(column)
    total = float(np.sum(squares))
    sources = []
    for (name, kind), own in columns.items():
        parts = {entries[column][1] for column in own}
        square = float(np.sum(squares[own]))
        sources.append(
            NoiseSource(
                block=name,
                kind=kind,
                rms=math.sqrt(square),
                share=square / total if total else 0.0,
                density=densities[:, own].sum(axis=1),
                dither=_dither(planned, name, (d for d in moved if d.block == name and d.part in parts))
                if square
                else None,
            )
        )
    return sources


def _dither(planned: Plan, block: str, moved: Iterable[Dither]) -> Dither | None:
    """Return the least motion of what a block rounds, if it rounds."""
    own = list(moved)
    least = min(own, key=lambda dither: min(dither.rms, dither.change), default=None)
    cut = getattr(planned.blocks[block], "rounding", "") == "toward_zero"
    return least and replace(least, cut=cut, apart=max(dither.apart for dither in own))


def _refuse_beyond(frequencies: Sequence[float], top: float) -> None:
    """Raise `ModelError` for a frequency that values of an output do not have."""
    beyond = next((f for f in frequencies if not 0.0 <= f <= top * (1.0 + 1e-9)), None)
    if beyond is not None:
        expected = f"0 Hz to {top:g} Hz, half the rate of the output"
        raise Problem(message="out of range", key="frequencies", got=f"{beyond:g} Hz", expected=expected).error


def _band(of: NoiseMap, band: tuple[float, float] | None) -> tuple[float, float]:
    top = 0.5 * of.rate
    if band is None:
        return (0.0, top) if of.settles else (top * 10.0**-_DECADES, top)
    return within(of, band)


def _notes(
    noisy: Noisy,
    sources: list[NoiseSource],
    to_output: NoiseMap,
    band: tuple[float, float] | None,
    derivatives: bool,
) -> list[str]:
    """Notes that a reader needs to judge the numbers."""
    notes = [
        f"{source.block}: noise moves its input by {source.dither.change:.2g} steps from value to value, and"
        f" {source.dither.rms:.2g} in all: its error is noise only if signals move it more, and else anything"
        " up to half a step"
        for source in sources
        if source.dither is not None and not source.dither.moves
    ]
    notes += [
        f"{source.block}: what it rounds is nearly a multiple of what was rounded before. So its error is not white and"
        f" uniform, and its mean square may be off by up to {100.0 * source.dither.apart:.2g} %"
        for source in sources
        if source.dither is not None and source.dither.moves and source.dither.gridded
    ]
    notes += [
        f"{source.block}: it cuts towards zero what noise moves by {source.dither.rms:.2g} steps. Where that turns the"
        f" sign, the noise is {min(40.0 / source.dither.rms, 100.0):.0f} % less; where not, the error is half as much"
        for source in sources
        if source.dither is not None and source.dither.moves and source.dither.turns
    ]
    made = {source.block for source in sources if source.kind == DECISION and source.rms}
    decided = [(name, one) for name in sorted(made) for one in noisy[name]]
    notes += [one.note(name) for name, one in decided if isinstance(one, OneBit)]
    notes += _locked(noisy)
    if decided and derivatives:
        notes.append("derivatives take gains and errors of one-bit quantisers as fixed")
    if not to_output.settles and band is None:
        notes.append("the output wanders without bound: its rms is that of the band named above")
    return notes


def _locked(noisy: Noisy) -> list[str]:
    """Return the notes on quantisers of one bit that noise does not pass."""
    return [one.note(name) for name, own in noisy.items() for one in own if isinstance(one, OneBit) and one.cycle]


def _lost(about: Linearisation, target: Endpoint) -> list[str]:
    """Return the notes on truth values that noise decides."""
    lost = decided_by_noise(about.plan, target, about.tick, about.course.kept)
    why = "noise decides this truth value, which has no slope: what it does is not in the budget"
    return [f"{wire}: {why}; a study of many runs shows it" for wire in lost]


def _reached(points: OperatingPoints, drawing: Noisy) -> set[Endpoint]:
    """Return the outputs that noise may reach at some operating point: of any other all points would be silent."""
    kept = points.course.kept
    if "reached" not in kept:
        kept["reached"] = reached_by_noise(points.plan, drawing)
    reached: set[Endpoint] = kept["reached"]
    return reached


def behind_sources(planned: Plan, outputs: Sequence[str]) -> list[str]:
    """Return the outputs that have a source of noise upstream; all of them if none has."""
    drawing = noise_blocks(planned).keys()
    blocks = {output: inside(planned.graph.root, output).rpartition(".")[0] for output in outputs}
    heard = [output for output, block in blocks.items() if upstream_of(planned, [block]) & drawing]
    return heard or [*outputs]


def silence(about: Linearisation, target: Endpoint, sources: int, noisy: Noisy) -> ModelError:
    """Return that no noise reaches an output at an operating point, and why, of so many sources that may."""
    output, lost = ".".join(target), decided_by_noise(about.plan, target, about.tick, about.course.kept)
    if lost:
        message = f"noise reaches {output} by truth values alone, which have no slope"
        return refusal(about.plan, output, message, ", ".join(lost), "a study of many runs shows what they do")
    return _no_noise(about.plan, output, sources, "; ".join(_locked(noisy)), about.tick)


def _no_noise(planned: Plan, output: str, sources: int, hint: str = "", tick: int = 0) -> ModelError:
    got, path = f"{sources} sources upstream of it", "a WhiteNoise, or a converter, must lie on a path to it"
    still = upstream_of(planned, [node_of(planned, output)[0]]) & rounding_blocks(planned)
    if sources:
        here = f"at {time_text(tick * planned.period)} a switch may be open, or a register wait"
        path = f"{here}: --at another time, or --until one for the value there alone"
    elif still:
        path = f"what {', '.join(sorted(still))} would round stands still here: let an input move, or add a WhiteNoise"
    return refusal(planned, output, f"no noise reaches {output}", got, hint or path)
