"""A run as one HTML file: the sensor, its results, and everything needed to repeat the run."""

import math
import shlex
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of, written
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.shown_units import as_written, in_print, pretty
from proofmass.graphs.drawing.layers import Link, signal_order
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.flatten import FlatGraph, flatten
from proofmass.graphs.model.graph import Graph, Wire, split
from proofmass.graphs.model.rates import write_rate
from proofmass.runner.output.counts import count
from proofmass.runner.output.page import (
    STILL,
    Html,
    LivePart,
    broken,
    facts,
    folded,
    inline,
    paragraphs,
    picture,
    save_page,
    small,
    table,
)
from proofmass.runner.output.plot import plot_traces
from proofmass.runner.plan.measuring import Measured
from proofmass.runner.run.engine_table import ENGINES
from proofmass.runner.run.result import Result

_LISTED = 8  # numbers of a list that are shown
_ONE_PAGE = 9  # panels that fit on one printed page
_OPEN_BLOCKS = 24  # of a graph whose table of blocks is not folded
_NUMBERS = 4  # of a block with nothing set
_UNIT = "unit"  # last word of the names of parameters that are units: the values have them


def save_report(
    result: Result, path: str | Path, extra: Sequence[tuple[str, str]] = (), live: LivePart = STILL
) -> Path:
    """Write the report: diagram, summary, plots, blocks with their parameters, and how to repeat the run.

    `extra` is a sequence of (heading, HTML fragment), put after the summary unchanged; `live`
    stands above all.
    """
    graph = result.graph
    sections = [
        ("Block diagram", _diagram(graph)),
        ("Signals", _summary(result)),
        *([("Measures", _measures(result))] if result.measures else []),
        *([("Overflows", _overflows(result))] if any(result.overflows.values()) else []),
        *extra,
        *([("Traces", _plots(result))] if result.traces else []),
        ("Blocks", _blocks(graph)),
        ("Run", _facts(result)),
        ("To repeat it", _repeat(result)),
    ]
    footer = f"proofmass {result.provenance.get('proofmass', '')}, {result.provenance.get('date', '')}"
    return save_page(path, graph.name, _opening(result), sections, footer, live)


def _opening(result: Result) -> str:
    texts = paragraphs(result.graph.description)
    seconds = float((result.ticks - 1) / result.base_rate) if result.ticks else 0.0
    ticks, rate = count(result.ticks, "tick"), escape(write_rate(result.base_rate))
    texts.append(f'<span class="soft">{ticks} at {rate}, {seconds:.9g} s</span>')
    missing = f"Interrupted: {result.ticks:,} of {result.planned_ticks:,} ticks were run."
    warning = f'<p class="warning">{missing}</p>' if result.interrupted else ""
    return "".join(f"<p>{text}</p>\n" for text in texts) + warning


def _diagram(graph: Graph) -> str:
    # start-up time: only reports draw the diagram
    from proofmass.graphs.drawing.diagram import svg

    return f'<div class="wide diagram">{inline(svg(graph))}</div>'


def _plots(result: Result) -> str:
    page = " page" if len(result.traces) <= _ONE_PAGE else ""
    return f'<div class="wide{page}">{picture(plot_traces(result), "traces of the probes")}</div>'


def _summary(result: Result) -> str:
    rows = []
    for signal, unit, number, *cells, last in result.shown_rows():
        trace = result[signal]
        vector = trace.values.ndim > 1
        texts = f"{number} of {trace.entries}" if vector else number, *cells, "" if vector else last
        rows.append((Html(f"{broken(signal)}<br>{small(trace.doc)}"), unit, *texts))
    heads = ("signal", "unit", "rows", "mean", "std", "min", "max", "last")
    return table(heads, rows, numbers=range(2, 8)) if rows else "<p>No probes.</p>"


def _measures(result: Result) -> str:
    rows = [
        (broken(name), _or_none(measure), Html(f"{escape(measure.statistic)} of {broken(measure.signal)}"))
        for name, measure in result.measures.items()
    ]
    return table(("measure", "value", ""), rows, numbers=(1,))


def _or_none(measure: Measured) -> str:
    return "none: the run ended before it began" if math.isnan(measure.value) else measure.text()


def _overflows(result: Result) -> str:
    rows = [(broken(name), f"{ticks:,}") for name, ticks in result.overflows.items() if ticks]
    about = "<p>Ticks in which a value did not fit its format, and saturated or wrapped.</p>"
    return about + table(("block", "ticks"), rows, numbers=(1,))


def _blocks(graph: Graph) -> str:
    """Return the blocks in signal order: of each what it is set to, the rest folded."""
    flat = flatten(graph)
    drivers = {wire.target: wire.source for wire in flat.wires}
    links = [_link(flat, wire) for wire in flat.wires]
    rows = []
    for name in signal_order(flat.blocks, links):
        block = flat.blocks[name]
        of_block = list(_parameters(name, block, drivers)) or ["<td></td>" * 3]
        about = (type(block).__doc__ or "").strip().split("\n")[0]
        rate = f" at {write_rate(flat.rates[name])}" if name in flat.rates else ""
        kind = f"{escape(type(block).__name__)}{escape(rate)}<br>{small(about)}"
        head = f'<th rowspan="{len(of_block)}">{broken(name)}<br><span class="kind">{kind}</span></th>'
        rows += [(head if i == 0 else "") + cells for i, cells in enumerate(of_block)]
    shown = f'<div class="parameters">{table(("block", "parameter", "value", ""), rows, numbers=(2,))}</div>'
    return shown if len(flat.blocks) <= _OPEN_BLOCKS else folded(f"{len(flat.blocks)} blocks, in signal order", shown)


def _link(flat: FlatGraph, wire: Wire) -> Link:
    (source, output), (target, port) = split(wire.source), split(wire.target)
    return Link(source, output, target, port, port in type(flat.blocks[target]).parameters)


def _parameters(name: str, block: Block, drivers: dict[str, str]) -> Iterator[str]:
    """Yield a row for each parameter that matters, and one with the rest, folded.

    What is driven or set matters, but for units, which the values have; of a block with nothing
    set, its first numbers.
    """
    rows, mattering, numbers = dict[str, str](), list[str](), list[str]()
    for parameter in type(block).parameters.values():
        driver = drivers.get(f"{name}.{parameter.name}")
        value = f"driven by {driver}" if driver else _value(block, parameter)
        doc = small(parameter.doc)
        rows[parameter.name] = f'<td>{parameter.name}</td><td class="number">{escape(value)}</td><td>{doc}</td>'
        default = repr(getattr(block, parameter.name)) == repr(parameter.default)
        if driver or not (default or parameter.name.endswith(_UNIT)):
            mattering.append(parameter.name)
        if parameter.kind in (float, int):
            numbers.append(parameter.name)
    shown = mattering or numbers[:_NUMBERS]
    yield from (rows.pop(parameter) for parameter in shown)
    if rows:
        about = f"{'and ' if shown else ''}{', '.join(rows)}"
        yield f'<td colspan="3">{folded(about, table((), rows.values()))}</td>'


def _value(block: Block, parameter: Parameter) -> str:
    """A value with its unit, as it was written; a number with the unit that suits its size."""
    value, unit = getattr(block, parameter.name), unit_of(block, parameter)
    if isinstance(value, tuple):
        more = [f"... ({len(value)} numbers)"] if len(value) > _LISTED else []
        listed = ", ".join([*(f"{number:.6g}" for number in value[:_LISTED]), *more])
        return listed if unit == "1" else f"{listed} {pretty(unit)}"
    if isinstance(value, float):
        return as_written(written(block, parameter.name), value, unit)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value} {pretty(unit)}" if isinstance(value, int) and unit not in ("1", "") else str(value)


def _facts(result: Result) -> str:
    provenance, ticks = dict(result.provenance), max(result.ticks, 1)
    about = {
        "engine": provenance.pop("engine", ""),
        "time of the loop": f"{in_print(result.seconds, 's')}, {in_print(result.seconds / ticks, 's')} a tick",
        "time before it": in_print(result.preparation, "s"),
        "seed": str(result.seed),
        "ticks": f"{result.ticks:,} at {write_rate(result.base_rate)}",
    }
    origin = {
        "SHA-256 of the graph": provenance.pop("graph_hash", ""),
        "SHA-256 of the traces": result.digest if result.traces else "",
        **provenance,
    }
    return facts(about.items()) + folded("hashes and versions", facts(origin.items()))


def _repeat(result: Result) -> str:
    file = Path(result.graph.place.file or "graph.toml").name
    words = ["proofmass", "run", file, "--samples", str(result.planned_ticks), "--seed", str(result.seed)]
    engine = result.provenance.get("engine", "")
    if engine in ENGINES:
        words += ["--engine", engine]
    text = escape(write_graph(result.graph, as_written=True))
    return (
        f"<p>Save the graph below as <code>{escape(file)}</code>; it has every parameter as it was in this run.</p>"
        f"<pre>{escape(shlex.join(words))}</pre>\n" + folded(file, f"<pre class='file'>{text}</pre>")
    )
