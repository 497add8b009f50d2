"""The command `margins`: read, change, linearise, show, draw."""

import contextlib
import json
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import SETTLED
from proofmass.runner.analysis.linearisation.linearise import node_of, open_loop, tick_at
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import all_margins, missed
from proofmass.runner.commands.margins_text import hertz_text, margins_text, seconds_text
from proofmass.runner.commands.progress import progress_bar
from proofmass.runner.commands.run_command import changed, own_blocks
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

if TYPE_CHECKING:
    from proofmass.runner.analysis.margins.sensitivity import Sensitivity

_ROWS = 12  # of a table of parameters


def show_margins(
    graph: Path,
    loop: str,
    at: str,
    sensitivity: tuple[str, str] | None,
    gains: tuple[str, ...],
    amplitudes: tuple[str, ...],
    limit_cycle: str,
    picture: Path | None,
    changes: tuple[str, ...],
    own: Path | None,
    as_json: bool,
) -> int:
    """Everything that `proofmass margins` does; returns the exit code."""
    loaded = changed(read_graph(graph, own_blocks(own)), changes, ())
    if limit_cycle:
        return _show_limit_cycles(loaded, limit_cycle, as_json)
    if gains or amplitudes:
        from proofmass.runner.analysis.limit_cycles.quasi_linear import with_gains

        loaded = with_gains(loaded, _stated("--gain", gains), _stated("--amplitude", amplitudes))
    planned = plan(loaded)
    point: str | Fraction = at
    if at == SETTLED:
        bar = progress_bar(as_json)
        with bar or contextlib.nullcontext():
            point = settled_tick(planned, bar) / planned.schedule.base_rate
        click.echo(f"settled after {seconds_text(float(point))}", err=as_json)
    wanted = all_margins if loop or sensitivity is None else _loops_if_any
    found = wanted(planned, loop, point)
    moved = sensitivities(planned, found, *sensitivity, point) if sensitivity else []
    if as_json:
        data = {"graph": loaded.name, "loops": [margins.as_data() for margins in found.values()]}
        click.echo(json.dumps(data | ({"sensitivities": [s.as_data() for s in moved]} if moved else {}), indent=2))
    else:
        for margins in found.values():
            click.echo(margins_text(margins))
        for quantity in moved:
            click.echo(sensitivity_text(quantity))
    if picture is not None:
        for path in _draw(picture, found, moved):
            click.echo(f"wrote {path}", err=as_json)
    problems = missed(planned, found)
    if problems:
        raise ModelError(problems)
    return 0


def _stated(option: str, texts: tuple[str, ...]) -> dict[str, str]:
    """The values that an option gives to blocks."""
    pairs = [text.partition("=") for text in texts]
    for text, (name, equals, value) in zip(texts, pairs, strict=True):
        if not (name and equals and value):
            raise click.UsageError(f"{option} {text}: write BLOCK=VALUE, for example quantiser=0.7")
    return {name.strip(): value.strip() for name, _, value in pairs}


def _show_limit_cycles(graph: Graph, name: str, as_json: bool) -> int:
    """The limit cycles that the describing function of a block predicts, and that of a run."""
    from proofmass.runner.analysis.limit_cycles.limit_cycles import LimitCycle, predicted, simulated, unit_of

    cycles, unit = predicted(graph, name), unit_of(graph, name)
    seen = simulated(graph, name, None if graph.duration or graph.samples else cycles)
    if as_json:
        data: dict[str, Any] = {"block": name, "unit": unit, "predicted": [cycle.as_data() for cycle in cycles]}
        data["simulated"] = seen.as_data() if seen else None
        click.echo(json.dumps({"graph": graph.name, "limit_cycles": data}, indent=2))
        return 0
    click.echo(f"limit cycles at the input of {name}")
    rows: list[tuple[str, LimitCycle | None]] = [("predicted", cycle) for cycle in cycles]
    for what, cycle in [*(rows or [("predicted", None)]), ("simulated", seen)]:
        shown = f" {unit}" if unit != "1" else ""
        text = f"amplitude {cycle.amplitude:.5g}{shown}, {hertz_text(cycle.frequency)}" if cycle else "none"
        click.echo(f"  {what:<17} {text}")
    return 0


def missed_margins(graph: Graph) -> list[Problem]:
    """What `proofmass check` says of the margins that a graph asks for; linearised at tick 0."""
    planned = plan(graph)
    wanted = {name: loop for name, loop in planned.graph.loops.items() if loop.requirements}
    found: dict[str, Margins] = {}
    for name in wanted:
        found |= all_margins(planned, name)
    notes = [_noted(planned, margins, note) for margins in found.values() for note in margins.system.map.notes]
    return [*missed(planned, found), *notes]


def _noted(planned: Plan, margins: Margins, note: str) -> Problem:
    path = ("loops", margins.loop)
    return planned.graph.placed(Problem(message=note, key=f"loops.{margins.loop}", note=True, path=path))


def sensitivities(
    planned: Plan, found: dict[str, Margins], source: str, target: str, at: str | Fraction
) -> "list[Sensitivity]":
    """Scale factor and bias from one output to another, and the margins of loops, with what moves them."""
    from proofmass.runner.analysis.margins.sensitivity import margin_sensitivities, transfer_sensitivities

    tick = tick_at(planned, at)
    moved = list(transfer_sensitivities(planned, node_of(planned, source), node_of(planned, target), tick))
    for margins in found.values():
        if margins.system.continuous:
            continue  # their derivatives by parameters are those of sampled loops
        node = node_of(planned, margins.open_at)
        moved += margin_sensitivities(planned, margins, open_loop(planned, node, tick, by_parameters=True))
    return moved


def sensitivity_text(found: "Sensitivity") -> str:
    """A ranked table of parameters for people."""
    unit = f" {found.unit}" if found.unit != "1" else ""
    effects = [(e.parameter, f"{e.of_one_percent:+.4g}" if e.of_one_percent is not None else "") for e in found.effects]
    lines = [f"{found.quantity}: {found.value:.8g}{unit}", f"  {'parameter':<32} {'for +1 %':>12}  derivative"]
    for (name, change), effect in list(zip(effects, found.effects, strict=True))[:_ROWS]:
        per = f" {found.unit} per {effect.unit}" if effect.unit != "1" else unit
        lines.append(f"  {name:<32} {change:>12}  {effect.derivative:.6g}{per}")
    more = len(effects) - _ROWS
    lines += [f"  and {more} more"] if more > 0 else []
    lines += [f"  {name:<32} {'':>12}  none: a corner, or an infinite slope" for name in found.undefined]
    return "\n".join(lines)


def _loops_if_any(planned: Plan, loop: str, at: str | Fraction) -> dict[str, Margins]:
    """Sensitivities of scale factor and bias are answered for a graph without loops too."""
    from proofmass.runner.analysis.linearisation.find_loops import find_loops

    return all_margins(planned, loop, at) if planned.graph.loops or find_loops(planned) else {}


def _draw(picture: Path, found: dict[str, Margins], moved: "list[Sensitivity]") -> list[Path]:
    """A picture of each loop, and of the parameters: numbered by name where there are several."""
    from proofmass.runner.analysis.margins.plot import plot_margins, plot_sensitivities
    from proofmass.runner.output.plot import save_figure

    figures = {name: plot_margins(margins) for name, margins in found.items()}
    if moved:
        figures["sensitivity"] = plot_sensitivities(moved)
    names = [picture if len(figures) == 1 else picture.with_stem(f"{picture.stem}_{name}") for name in figures]
    return [save_figure(figure, path) for figure, path in zip(figures.values(), names, strict=True)]
