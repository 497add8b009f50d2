"""The data that a live page has of a graph, and the part of a page that shows it."""

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.catalog import facts
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.shown_units import display, prefix
from proofmass.blocks.declaration.spelled_units import spellings
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.measures import MEASURES
from proofmass.graphs.model.rates import write_seconds
from proofmass.runner.live.bundle import allowed, elements, styles
from proofmass.runner.live.carried import SHOWN_IN, carried_loop, packed
from proofmass.runner.live.named_values import named_values
from proofmass.runner.live.sliders import fixed_parameters, sliders
from proofmass.runner.live.verdicts import loop_names, required_measures
from proofmass.runner.output.page import LivePart
from proofmass.runner.output.typeset import typeset
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan as make_plan

_DECADES = range(-24, 25)
_MOST_DRAWINGS = 24  # with one subgraph unfolded


def live_model(graph: Graph, ticks: int | None = None, seed: int | None = None) -> dict[str, Any]:
    """Plain data of a graph for a page: its loop, its parameters, length and seed of the first run.

    Raises `ModelError` for a graph that is wrong, or that no browser can run.
    """
    plan = make_plan(graph)
    moving = sliders(graph, plan)
    loop = carried_loop(plan, [slider.node for slider in moving])
    chosen = tuple(slider for slider in moving if slider.node in loop.varied)
    named = named_values(graph, {slider.node: slider for slider in chosen})
    fixed = (*named.fixed, *fixed_parameters(plan, chosen))
    every = (*named.sliders, *chosen)
    carried, usual = loop.as_data(), ticks in (None, plan.ticks())
    units = {slider.unit for slider in every}
    units |= {row["unit"] for table in ("wires", "probes", "measures") for row in carried[table]}
    return {
        "name": graph.name,
        "file": Path(graph.place.file or "graph.toml").name,
        "seed": str(graph.seed if seed is None else seed),
        "ticks": plan.ticks() if ticks is None else ticks,
        "loop": carried,
        "sliders": [slider.as_data() for slider in every],
        "named": named.as_data(),
        "fixed": [parameter.as_data() for parameter in fixed],
        "units": {name: scales_of(name) for name in sorted(units)},
        "options": _method_options(graph, plan),
        "order": [probe.signal for probe in graph.probes],
        "duration": _duration(graph if usual else None, plan, ticks),
        "blocks": blocks_of(plan),
        "kinds": {type(block).__name__: about(type(block)) for block in plan.blocks.values()},
        "spelled": _spelled([("s", "s"), *sorted({(slider.shown_in, slider.unit) for slider in every})]),
        "loops": loop_names(plan),
        "required": required_measures(plan.graph),
    }


def _duration(graph: Graph | None, plan: Plan, ticks: int | None) -> str:
    """Return the length of the run as the graph has it, or as a decimal that is no tick shorter."""
    text = "/" if graph is None or graph.duration is None else write_seconds(graph.duration)
    if "/" not in text:
        return text
    seconds = ((plan.ticks() if ticks is None else ticks) - 1) / plan.schedule.base_rate
    decimals = Context(prec=12, rounding=ROUND_CEILING)
    return f"{decimals.divide(Decimal(seconds.numerator), Decimal(seconds.denominator)):f}"


def blocks_of(plan: Plan) -> dict[str, dict[str, Any]]:
    """Return the kind of each block, and the signals at its ports: first those that come in."""
    drivers = plan.schedule.drivers
    return {
        name: {
            "kind": type(block).__name__,
            "inputs": {
                port: ".".join(drivers[name, port])
                for port in (*type(block).inputs, *type(block).parameters)
                if (name, port) in drivers
            },
            "outputs": [f"{name}.{port}" for port in type(block).outputs],
        }
        for name, block in plan.blocks.items()
        if not name.startswith(f"{MEASURES}.")
    }


def about(kind: type[Block]) -> dict[str, str]:
    """Return what a block is, as `proofmass blocks` says it, and its equation as HTML."""
    known = facts(kind)
    return {"doc": known["doc"], "equation": typeset(known["equation"])}


def _spelled(units: Iterable[tuple[str, str]]) -> dict[str, list[dict[str, Any]]]:
    """Return the forms of units that a field takes: by the unit that it shows, from this one and
    the parameter's own.

    A form has, for each place in it, the names that may stand there and their factors.
    """
    spelled = dict[str, list[dict[str, Any]]]()
    for shown, own in units:
        forms = spelled.setdefault(shown, [])
        for of in (shown, own):
            times = unit(of).factor / unit(shown).factor
            for form, (first, *others) in spellings(of):
                if form not in [known["form"] for known in forms]:
                    names = [{name: factor * times for name, factor in first.items()}, *others]
                    forms.append({"form": form, "names": [_exact(one) for one in names]})
    return spelled


def _exact(factors: Mapping[str, Fraction]) -> dict[str, list[str]]:
    return {name: [str(part) for part in factor.as_integer_ratio()] for name, factor in factors.items()}


def live_part(graph: Graph, model: dict[str, Any]) -> LivePart:
    """The part of a page that carries a model and runs it. Without scripts it is not seen."""
    carried = json.dumps(model | {"drawings": _drawings(graph)}, allow_nan=False).replace("<", "\\u003c")
    html = (
        f'<section id="live" hidden aria-label="{escape(model["name"])}, live"></section>\n'
        f'<script type="application/json" id="live-model">{carried}</script>\n{elements()}'
    )
    return LivePart(html, styles(), allowed())


def _drawings(graph: Graph) -> str:
    """The diagram with each subgraph unfolded, alone and with all others, packed: by the paths that are unfolded."""
    paths = subgraph_paths(graph)
    wanted = {tuple(path for path in paths if f"{one}.".startswith(f"{path}.")) for one in paths[:_MOST_DRAWINGS]}
    wanted |= {tuple(paths)} if paths else set()
    return packed(json.dumps({",".join(sorted(some)): svg(graph, some) for some in sorted(wanted)}).encode())


@cache
def scales_of(unit: str) -> list[dict[str, Any]]:
    """The prefixes of a unit, each with the power of ten that it stands for; of a unit in which one is shown, that."""
    own, _, wanted = unit.partition(SHOWN_IN)
    if wanted:
        factor, text = display(own, wanted, 1.0)
        return [{"exponent": -math.log10(factor), "text": "" if text == "1" else text}]
    texts = dict[int, str]()
    for decade in _DECADES:
        factor, text = prefix(short_unit(unit), 10.0**decade)
        texts.setdefault(-round(math.log10(factor)), "" if text == "1" else text)
    return [{"exponent": exponent, "text": text} for exponent, text in sorted(texts.items())]


def _method_options(graph: Graph, plan: Plan) -> list[str]:
    """Options by which the command line steps continuous blocks as this plan does, whatever the parameters are."""
    stepped = [solver for solver in plan.solvers if not solver.exact]
    if not stepped or graph.integration.substeps is not None:
        return []
    methods = {solver.method for solver in stepped}
    changes: dict[str, Any] = {"substeps": max(solver.substeps for solver in stepped)}
    if methods != {"runge_kutta_4"}:
        changes["method"] = min(methods)
    try:
        other = make_plan(graph.changed(integration=dataclasses.replace(graph.integration, **changes)))
    except ModelError:
        return []
    if other.solvers != plan.solvers:
        return []
    return [f"--set integration.{key}={value}" for key, value in changes.items()]
