"""The report: one whole file, everything in it, everything escaped, and a run that can be repeated from it."""

import dataclasses
import re
import shlex
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from proofmass.blocks import Delay, Gain, PiecewiseConstant, Ramp, Step, Sum
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.output.report import save_report
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from tests.by_hand.results import GRAPH, made_result, made_trace, mixed_result

VOID = {"meta", "br", "wbr", "link", "hr", "img", "input"}


class Outline(HTMLParser):
    """The elements of a page; refuses tags that do not close in order."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.headings: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.tags: set[str] = set()
        self.feed(page)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def page_of(result: Result, folder: Path, extra: tuple[tuple[str, str], ...] = ()) -> str:
    return save_report(result, folder / "report.html", extra).read_text()


def texts(page: str) -> str:
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]*>", " ", page.replace("<wbr>", ""))))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    return page_of(mixed_result(), tmp_path_factory.mktemp("report"), (("Margins & more", "<p>60 <b>deg</b></p>"),))


@pytest.mark.friendly(28, "the page is whole")
def test_the_page_is_whole_and_in_order(page: str) -> None:
    expected = ["Block diagram", "Signals", "Margins & more", "Traces", "Blocks", "Run", "To repeat it"]
    assert Outline(page).headings == expected
    assert "<p>60 <b>deg</b></p>" in page


@pytest.mark.friendly(28, "it asks nothing of the network")
def test_the_page_asks_nothing_of_the_network(page: str) -> None:
    outline = Outline(page)
    assert not outline.tags & {"script", "link", "iframe", "object", "embed", "base"}
    links = [value for name, value in outline.attributes if name in ("src", "href", "xlink:href", "action")]
    assert all(value.startswith(("#", "data:")) for value in links)
    assert not re.search(r"@import|url\((?!#)", page)
    assert "default-src 'none'" in page


@pytest.mark.friendly(26, "a report holds what it was made with")
def test_the_page_holds_what_came_out_and_what_it_was_made_with(page: str) -> None:
    text = texts(page)
    for expected in (
        "a sine and bits",
        "Two sources.",
        "60 ticks at 50 kHz, 0.00118 s",
        "adc.code",
        "The sine wave. µV 60 ",
        "V/s 6 of 4",
        "amplitude 3 µV Peak value about the offset.",
        "ShiftRegister",
        "engine python",
        "time of the loop 250 ms, 4.167 ms a tick",
        "seed 7",
        "SHA-256 of the graph 0123abcd",
        "proofmass 0.1.0, 2026-01-02T03:04:05+00:00",
        'kind = "ShiftRegister"',
    ):
        assert expected in text


def test_blocks_stand_in_signal_order_with_what_they_are_set_to_and_the_rest_folded(tmp_path: Path) -> None:
    graph = Graph(
        name="a chain and a loop",
        rate="1 kHz",
        samples=3,
        blocks={
            "source": Step(amplitude=2.0, unit="V"),
            "zero": Sum(unit="V"),
            "again": Delay(unit="V"),
            "after": Gain(input_unit="V", output_unit="V"),
        },
        wires=[
            "source.output -> after.input",
            "after.output -> zero.first",
            "zero.output -> again.input",
            "again.output -> zero.second",
        ],
        probes=["zero.output"],
    )
    page = page_of(simulate(graph, engine="python"), tmp_path)
    blocks = page[page.index("<h2>Blocks") : page.index("<h2>Run")]
    places = [blocks.index(f">{name}<br>") for name in ("source", "after", "zero", "again")]
    assert places == sorted(places)
    source, after = texts(blocks[places[0] : places[1]]), texts(blocks[places[1] : places[2]])
    assert source.index("amplitude 2 V") < source.index("and start_time, duration, offset, unit")
    assert after.index("gain 1 V/V Output per input.") < after.index("and input_unit, output_unit"), "set to nothing"


@pytest.mark.friendly(28, "a page of many blocks is folded")
def test_a_page_of_many_blocks_folds_them(tmp_path: Path) -> None:
    blocks = {f"step_{number}": Step() for number in range(25)}
    graph = Graph(name="many", rate="1 kHz", samples=2, blocks=blocks, probes=["step_0.output"])
    page = page_of(simulate(graph, engine="python"), tmp_path)
    assert "<summary>25 blocks, in signal order</summary>" in page


def test_the_plot_takes_its_colours_and_letters_from_the_page(page: str) -> None:
    traces = page[page.index("<h2>Traces") : page.index("<h2>Blocks")]
    assert "stroke: var(--blue)" in traces
    assert not re.search("#0072b2|#1b1b1b|#ffffff", traces)
    assert "sine.output [µV]</text>" in traces
    assert all("fill: var(--ink)" in tag for tag in re.findall("<text[^>]*>", traces))
    assert "prefers-color-scheme: dark" in page
    assert "@media print" in page


@pytest.mark.friendly(13, "the file in a report has what was written")
def test_the_run_can_be_repeated_from_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from proofmass.runner.command_line import cli

    monkeypatch.chdir(tmp_path)
    result = simulate(GRAPH, samples=50, seed=11, engine="python")
    texts_of_page = re.findall("<pre[^>]*>(.*?)</pre>", page_of(result, tmp_path), re.DOTALL)
    command, toml = map(unescape, texts_of_page)
    program, *arguments = shlex.split(command)
    assert (program, arguments[:2]) == ("proofmass", ["run", "graph.toml"])
    Path("graph.toml").write_text(toml)
    assert read_graph("graph.toml") == GRAPH
    ran = CliRunner().invoke(cli, [*arguments, "--out", "again", "--format", "csv"], catch_exceptions=False)
    assert ran.exit_code == 0
    again = np.loadtxt("again/traces.csv", delimiter=",", skiprows=1)
    assert again[:, 1].tolist() == result["sine.output"].values.tolist()


def test_everything_is_escaped(tmp_path: Path) -> None:
    bad = "<script>alert('x')</script> & \"quoted\" $title"
    graph = dataclasses.replace(GRAPH, name=bad, description=f"{bad}\n\n{bad}")
    trace = made_trace("sine.output", [1.0, 2.0], "V", doc=bad)
    result = made_result([trace], graph, provenance={"engine": bad, "note": bad})
    page = page_of(result, tmp_path, ((bad, ""),))
    assert "script" not in Outline(page).tags
    assert "<script" not in page
    assert texts(page).count("alert('x')") >= 8


def test_driven_parameters_rates_lists_and_truths_are_shown(tmp_path: Path) -> None:
    graph = Graph(
        name="driven",
        rate="1 kHz",
        rates={"ramp": "100 Hz"},
        blocks={
            "ramp": Ramp(),
            "gain": Gain(),
            "steps": PiecewiseConstant(times=[float(n) for n in range(12)], values=[0.5] * 12),
        },
        wires=["ramp.output -> gain.gain", "steps.output -> gain.input"],
    )
    text = texts(page_of(made_result([], graph), tmp_path))
    assert "gain driven by ramp.output" in text
    assert "ramp Ramp at 100 Hz" in text
    assert "0, 1, 2, 3, 4, 5, 6, 7, ... (12 numbers) s" in text
    assert "No probes." in text
    assert "Traces" not in text


def test_an_interrupted_run_says_so_first(tmp_path: Path) -> None:
    page = page_of(dataclasses.replace(mixed_result(), planned_ticks=1000), tmp_path)
    assert '<p class="warning">Interrupted: 60 of 1,000 ticks were run.</p>' in page
    assert "--samples 1000 --seed 7" in page


@pytest.mark.exhaustive
def test_the_page_of_many_long_noises_stays_small(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).normal(size=(50_000, 16))
    result = made_result([made_trace(f"noise{i}.output", noise[:, i], "V") for i in range(16)])
    assert len(page_of(result, tmp_path).encode()) < 2_000_000


def test_measures_are_in_the_report(tmp_path: Path) -> None:
    """One that there is, one that the run was too short for, and a run without measures."""
    late = {"signal": "ramp.output", "statistic": "mean", "from": "1 s"}
    graph = Graph(
        name="ramp",
        rate="1 kHz",
        blocks={"ramp": Ramp(slope=1000.0, unit="V")},
        probes=["ramp.output"],
        measures={"level": {"signal": "ramp.output", "statistic": "max"}, "late": late},
    )
    page = page_of(simulate(graph, samples=5), tmp_path)
    assert "Measures" in Outline(page).headings
    assert re.search(r"level .{0,3}4 .{0,3}V .{0,3}max of ramp.output", texts(page))
    assert "none: the run ended before it began" in texts(page)
    bare = dataclasses.replace(graph, measures={})
    assert "Measures" not in Outline(page_of(simulate(bare, samples=5), tmp_path)).headings
