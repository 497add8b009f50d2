"""The gallery of the site: a page for every graph and study of the library, with picture, figures and file."""

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from html import escape
from itertools import groupby
from pathlib import Path

from docs.site.markdown import code, diagram_attributes, fence, plain, table
from proofmass.blocks.declaration.catalog import all_blocks, family_of
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.gallery import PARTS, TEMPLATE, Exhibit, exhibit_of, exhibits
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import write_rate
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run.simulate import simulate

THUMBNAILS = "thumbnails"  # folder of diagrams in the built site
TICKS = 5_000_000  # of a run whose figures are on a page; longer ones are left to the reader


def all_exhibits() -> tuple[Exhibit, ...]:
    """Return everything in the library that is a graph or a study, the template of `proofmass new` first."""
    return (exhibit_of(library_file(TEMPLATE)), *exhibits())


def gallery_pages(*, runs: bool, only: Sequence[str] = ()) -> Iterator[tuple[str, str]]:
    """Yield the index and the page of each graph, or of some; without `runs` no graph is run for its figures."""
    yield "gallery/index.md", _index()
    for item in all_exhibits():
        if only and item.name not in only:
            continue
        yield f"gallery/{item.name}.md", _page(item, runs=runs)


def gallery_pictures() -> Iterator[tuple[str, str]]:
    """Yield name and text of the diagram of each graph."""
    for item in all_exhibits():
        if not item.study:
            yield f"library/{item.name}.svg", _diagram(item.path)


@cache
def _diagram(path: Path) -> str:
    """Return the diagram of a graph, which its page and its card have."""
    return svg(read_graph(path))


def _index() -> str:
    lines = ["# All graphs of the library", "", "Each page has the diagram, the figures and the file.", ""]
    lines += ["```{toctree}", ":hidden:", "", *(item.name for item in all_exhibits()), "```", ""]
    for family, members in groupby(all_exhibits(), key=lambda item: item.family):
        lines += [f"## {_heading(family)}", "", *cards(members)]
    return "\n".join(lines) + "\n"


def cards(items: Iterable[Exhibit], above: str = "../") -> Iterator[str]:
    """Yield the lines of a card for each graph: diagram, name, title; `above` leads to the root of the site."""
    yield from ("```{raw} html", '<div class="cards">')
    for item in items:
        picture = f"{above}{THUMBNAILS}/{diagram_of(item)}.svg"
        yield (
            f'<a href="{above}gallery/{item.name}.html"><img src="{picture}" alt="" loading="lazy">'
            f"<b>{item.name.replace('_', '_<wbr>')}</b><span>{escape(item.title)}</span></a>"
        )
    yield from ("</div>", "```", "")


def diagram_of(item: Exhibit) -> str:
    """Return the name of the graph whose diagram stands for an exhibit: that of a study is its graph's."""
    return _graph_of(item) if item.study else item.name


def _graph_of(item: Exhibit) -> str:
    return next(name for name in item.beside if name.endswith(".toml")).removesuffix(".toml")


def _heading(family: str) -> str:
    if family == PARTS:
        return "Parts for graphs of your own"
    return family.replace("_", " ").capitalize() or "To start from"


def _page(item: Exhibit, *, runs: bool) -> str:
    lines = [f"# {plain(item.title[0].upper() + item.title[1:])}", "", plain(item.description), ""]
    if item.study:
        lines += _study(item, read_study(item.path))
    else:
        graph = read_graph(item.path)
        attributes = diagram_attributes(_diagram(item.path))
        lines += [f"![Diagram: {plain(item.title)}](../pictures/library/{item.name}.svg){attributes}", ""]
        lines += _graph(item.name, graph, runs=runs)
    lines += ["## File", "", f"`proofmass new sensor.toml --from {item.name}` copies it.", ""]
    lines += fence("toml", item.path.read_text(encoding="utf-8"))
    return "\n".join(lines) + "\n"


def _graph(name: str, graph: Graph, *, runs: bool) -> Iterator[str]:
    flat = flatten(graph)
    facts = [
        ("rate", write_rate(graph.rate) if graph.rate else ""),
        ("length of a run", f"{float(graph.duration):g} s" if graph.duration else ""),
        ("blocks, with those of its parts", str(len(flat.blocks))),
        ("wires", str(len(flat.wires))),
        ("CPU time of a second", _cost(name)),
        ("control loops", ", ".join(map(code, graph.loops))),
        ("has outside, as a part", ", ".join(map(code, graph.exports))),
    ]
    yield from ("## Figures", "")
    yield from table(("", "figure"), [fact for fact in facts if fact[1]])
    if runs and 0 < _ticks(graph) <= TICKS:
        yield from _run(graph)
    kinds = Counter(type(block) for block in flat.blocks.values())
    known = all_blocks()
    rows = [
        (_reference(kind) if kind.__name__ in known else code(kind.__name__), str(count))
        for kind, count in sorted(kinds.items(), key=lambda entry: entry[0].__name__)
    ]
    yield from ("## Blocks", "")
    yield from table(("kind", "how many"), rows)


def costs() -> dict[str, float]:
    """Return CPU seconds a simulated second of each graph that runs alone, by benchmarks/gallery_times.py."""
    return dict(json.loads((Path(__file__).parents[1] / "gallery_times.json").read_text(encoding="utf-8")))


def _cost(name: str) -> str:
    cost = costs().get(name)
    if cost is None:
        return ""
    return f"{1e3 * cost:.2g} ms of one core, " + ("faster than real time" if cost < 1.0 else "slower than real time")


def _ticks(graph: Graph) -> float:
    """Return the base ticks of a run by the graph's own rate; 0 of a part, which says no length."""
    return graph.samples or float((graph.duration or 0) * (graph.rate or 0))


def _run(graph: Graph) -> Iterator[str]:
    """Yield the tables of a run: its signals and its measures."""
    result = simulate(graph)
    rows = [
        (code(row["signal"]), code(row["unit"]), *(_number(row[key]) for key in ("mean", "std", "min", "max", "last")))
        for row in result.summary()
    ]
    yield from table(("signal", "unit", "mean", "std", "min", "max", "last"), rows)
    measures = [(code(name), _number(one.value), code(one.unit)) for name, one in result.measures.items()]
    yield from table(("measure", "value", "unit"), measures)


def _study(item: Exhibit, study: Study) -> Iterator[str]:
    graph = _graph_of(item)
    facts = [
        ("graph", f"[{graph}]({graph}.md)"),
        ("sensors", str(study.runs)),
        ("design", study.design),
        ("ages", str(len(study.epochs)) if len(study.epochs) > 1 else ""),
        ("points of its sweep", str(len(next(iter(study.sweep.values())))) if len(study.sweep) == 1 else ""),
        ("spread parameters", ", ".join(map(code, study.spread))),
        ("drifting parameters", ", ".join(map(code, study.drift))),
        ("limits on", ", ".join(map(code, study.limits))),
    ]
    yield from ("## Figures", "")
    yield from table(("", "figure"), [fact for fact in facts if fact[1]])


def _reference(kind: type) -> str:
    return f"[{kind.__name__}](../reference/blocks/{family_of(kind)}.md#{kind.__name__.lower()})"


def _number(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float | int) else str(value)
