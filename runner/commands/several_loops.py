"""Answers of `margins` with --together and --over: several loops at once, margins over a parameter or age."""

import math
from pathlib import Path

import click

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.units import convert, short_unit
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.ages import age_text
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_tables import StudyTables
from proofmass.runner.analysis.margins.figures import decibels
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.text import operating_point
from proofmass.runner.analysis.several.over import MarginsOver, margins_over, margins_over_age, spread_evenly
from proofmass.runner.analysis.several.plot import plot_over, plot_together
from proofmass.runner.analysis.several.together import Together, margins_together
from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_answer, print_picture
from proofmass.runner.output.text_table import text_table

POINTS = 9


def show_together(graph: Graph, loops: tuple[str, ...], at: str, picture: Path | None, as_json: bool) -> int:
    """Show the disk margin of several loops at once; exit code 1 if they are not stable."""
    together = margins_together(graph, loops, at=at)
    print_answer(as_json, lambda: {"graph": graph.name} | together.as_data(), _together_lines(together))
    print_picture(lambda: plot_together(together), picture, as_json)
    return DONE if together.margin is not None else WRONG_MODEL


def _together_lines(together: Together) -> list[str]:
    named = ", ".join(f"{name} at {place}" for name, place in zip(together.loops, together.open_at, strict=True))
    lines = [f"{len(together.loops)} loops at once: {named}"]
    if together.margin is None:
        return [*lines, f"  the loops are {together.verdict}", *_notes(together)]
    gain = together.gain or math.inf
    gains = "by any factor" if math.isinf(gain) else f"by +-{20.0 * math.log10(gain):.3g} dB"
    lines.append(f"  disk margin {together.margin:.5g}, least at {together.frequency:.5g} Hz")
    phase = math.degrees(together.phase or 0.0)
    lines.append(f"  every gain may move {gains}, or every phase by +-{phase:.3g} deg, at once")
    if together.reached is not None and together.reached > together.margin * (1.0 + 1e-6):
        known = "  it is at least that; a perturbation that makes the loops unstable is known at"
        lines.append(f"{known} {together.reached:.5g}")
    factors = [f"{n} {_polar(f)}" for n, f in zip(together.loops, together.factors, strict=False)]
    lines += [f"  these factors make them unstable: {', '.join(factors)}"] * bool(factors)
    alone = ((n, f"{v:.5g}") for n, v in zip(together.loops, together.alone, strict=True))
    lines += [f"  {line}" for line in text_table([("loop", "disk margin alone"), *alone], left=(0,), indent=2)]
    lines.append(f"  with perturbations between the wires too: {together.unstructured:.5g}")
    for title, peaks in (("sensitivity S", together.sensitivities), ("T = I - S", together.complementary)):
        cells = [(n, *(_level(value) for value in row)) for n, row in zip(together.loops, peaks.tolist(), strict=True)]
        lines += [f"  peaks of {title}, to a row from a disturbance at a column"]
        lines += [f"    {line}" for line in text_table([("", *together.loops), *cells], left=(0,))]
    return [*lines, *_notes(together)]


def _notes(together: Together) -> list[str]:
    place = operating_point(together.tick, together.time, together.told)
    return [f"  linearised at {place}", *(f"  note: {note}" for note in together.notes)]


def _level(value: float) -> str:
    return f"{20.0 * math.log10(value):.3g} dB" if value > 0.0 else "none"


def _polar(factor: complex) -> str:
    return f"{abs(factor):.4g} at {math.degrees(math.atan2(factor.imag, factor.real)):+.3g} deg"


def show_over(source: Graph | Study, over: str, loop: str, at: str, picture: Path | None, as_json: bool) -> int:
    """Show margins over a parameter, or of a study over age; exit code 1 if some loop is not stable somewhere."""
    if isinstance(source, Study):
        name, by_age = source.graph.name, margins_over_age(source, loop=loop, at=at)
    else:
        name, by_age = source.name, _over(source, over, loop, at)
    print_answer(as_json, lambda: {"graph": name} | by_age.as_data(), _over_lines(by_age))
    print_picture(lambda: plot_over(by_age), picture, as_json)
    return DONE if all(m.stable for loops in by_age.margins for m in loops.values()) else WRONG_MODEL


def _over(graph: Graph, over: str, loop: str, at: str) -> MarginsOver:
    name, equals, bounds = over.partition("=")
    low, dots, rest = bounds.partition("..")
    high, colon, count = rest.partition(":")
    wrong = click.UsageError(f'--over {over}: write age, or PARAMETER="LOW..HIGH", or PARAMETER="LOW..HIGH:POINTS"')
    if not (equals and dots and low.strip() and high.strip() and name.strip()):
        raise wrong
    if colon and not (count.strip().isdigit() and 1 <= int(count) <= 1000):
        raise wrong
    read = StudyTables(checked(graph))
    both = read.parameters("over", {name.strip(): (low, high)}, _ends)
    if read.problems:
        raise ModelError([graph.placed(problem) for problem in read.problems])
    ((signal, (ends, unit)),) = both.items()
    values = spread_evenly(ends[0], ends[1], int(count) if colon else POINTS)
    return margins_over(graph, signal, values, unit=unit, loop=loop, at=at)


def _ends(bounds: object, unit: str) -> tuple[list[float], str]:
    """Read the ends of a range in the unit of what varies."""
    assert isinstance(bounds, tuple)
    return [convert(end.strip(), unit) for end in bounds], short_unit(unit)


def _over_lines(over: MarginsOver) -> list[str]:
    age = over.axis == "age"
    head = ("age" if age else f"{over.axis}", "loop", "gain margin", "phase margin", "sensitivity peak", "bandwidth")
    rows: list[tuple[str, ...]] = [head]
    for value, loops in zip(over.values, over.margins, strict=True):
        at = age_text(value) if age else f"{value:.6g}" + (f" {over.unit}" if over.unit != "1" else "")
        rows += [(at, name, *_figures(margins)) for name, margins in loops.items()]
    return text_table(rows, left=(1,))


def _figures(margins: Margins) -> tuple[str, ...]:
    if not margins.stable:
        return margins.verdict, "", "", ""
    gain, phase, peak = margins.least_gain_margin, margins.phase_margin, decibels(margins.sensitivity_peak)
    return (
        "no limit" if math.isinf(gain) else f"{gain:.4g} dB",
        "no limit" if phase is None else f"{math.degrees(phase):.4g} deg",
        "" if peak is None else f"{peak:.4g} dB",
        "" if margins.bandwidth is None else f"{margins.bandwidth:.5g} Hz",
    )
