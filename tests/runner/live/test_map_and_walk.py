"""Live pages as Chromium runs them: the map, named values, walks, many seeds, and what the process adds."""

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import Gain, MisalignedTriad, Sine, Sum
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.changes import with_parameters
from proofmass.runner.command_line import main
from proofmass.runner.commands.run_files import write_run
from proofmass.runner.run.simulate import simulate
from tests.by_hand.chromium import CHROMIUM, Process, digest, hash_of, opened

pytest.importorskip("playwright.sync_api")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")

PART = """
name = "a counter in steps"
rate = "1 kHz"
exports = { output = "sum.output", step = "one.value" }
wires = ["one.output -> sum.input"]

[blocks.one]
kind = "Constant"
value = 1.0

[blocks.sum]
kind = "DiscreteIntegrator"
gain = 1000.0
output_unit = "V"
"""
GRAPH = """
name = "counting"
rate = "1 kHz"
samples = 400
seed = 7
wires = ["noise.output -> total.first", "count.output -> total.second", "total.output -> meter.voltage"]
probes = ["total.output"]

[values]
step = 2.0
loudness = "= step^3 / 100"

[blocks.count]
graph = "part.toml"
step = "= sqrt(step) * 4"

[blocks.noise]
kind = "WhiteNoise"
density = "= loudness * 1 V/sqrt(Hz)"
unit = "V"

[blocks.total]
kind = "Sum"
unit = "V"

[blocks.meter]
kind = "AnalogToDigital"
bits = 12

[measures.level]
statistic = "std"
signal = "total.output"

[measures]
loss = "= log(level / 1 V)"
"""
STUDY = """
[study]
runs = 90
seed = 3

[study.spread]
step = { normal = "1 %", relative = true }

[study.limits]
level = { at_most = 1000.0 }
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "part.toml").write_text(PART)
    (tmp_path / "graph.toml").write_text(GRAPH)
    return tmp_path


@pytest.fixture
def report(folder: Path) -> str:
    """Address of the live report of a run."""
    write_run(simulate(read_graph(folder / "graph.toml")), folder, (), live=True)
    return (folder / "report.html").as_uri()


def shown(page: Any, selector: str) -> float:
    """Number that an element shows first, whatever its prefix."""
    text = str(page.text_content(selector)).replace("−", "-")
    number, unit = re.findall(r"(-?[\d.]+(?:e-?\d+)?) ?([kmµun]?)V", text)[0]
    return float(number) * {"": 1.0, "k": 1e3, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "n": 1e-9}[unit]


@pytest.mark.exhaustive
def test_a_named_value_moves_what_follows_from_it_to_the_bits_of_the_command_line(
    browser: Any, folder: Path, report: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    page, lines = opened(browser, report, permissions=["clipboard-read", "clipboard-write"])
    before = digest(page)
    page.locator("[aria-label='step, slider']").focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    after = digest(page, before)
    moved = float(page.input_value("[id='step']"))
    page.click("summary:has-text('count.one')")
    assert float(page.input_value("[id='count.one.value']")) == pytest.approx(4.0 * math.sqrt(moved), rel=1e-15)
    monkeypatch.chdir(folder)
    assert main(["run", "graph.toml", "--set", f"step={moved!r}", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert hash_of(after) == told["digest"] != hash_of(before)
    page.click("text=Copy TOML")
    page.wait_for_selector(".status:text-is('copied')")
    assert page.evaluate("navigator.clipboard.readText()").strip() == f"[values]\nstep = {moved!r}"
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_many_seeds_have_the_measures_of_single_runs(browser: Any, folder: Path, report: str) -> None:
    page, lines = opened(browser, report)
    digest(page)
    page.click("text=Seeds")
    page.wait_for_selector(".histograms p:has-text('300 of 300 runs, of the seeds 7 to 306')", timeout=30_000)
    graph = with_parameters(read_graph(folder / "graph.toml"), {})
    levels = [simulate(graph, seed=seed).measures["level"].value for seed in (*range(7, 27), *range(287, 307))]
    text = page.text_content(".histogram p")
    mean = shown(page, ".histogram p")
    assert mean == pytest.approx(
        np.mean(levels), rel=4.0 * np.std(levels) / np.mean(levels) / math.sqrt(len(levels)) + 1e-4
    )
    assert "standard deviation" in text
    assert page.locator(".histogram figcaption").all_inner_texts() == ["level", "loss"]
    said = page.text_content(".histogram:has(figcaption:text-is('loss')) p").split()[1]
    losses = np.log(levels)
    allowed = 4.0 * np.std(losses) / math.sqrt(len(losses)) + 1e-4
    assert float(said.rstrip(",").replace("−", "-")) == pytest.approx(np.mean(losses), abs=allowed)
    assert page.locator(".histogram .bin").count() >= 5
    assert lines == []
    page.context.close()


def test_a_walk_goes_tick_by_tick_and_takes_other_parameters_on_the_way(browser: Any, report: str) -> None:
    """The counter grows by its step each tick: 4 sqrt(2) at first, then what it is set to."""
    page, lines = opened(browser, report)
    digest(page)
    page.click("text=Walk")
    page.click("text='10 ticks'")
    page.wait_for_selector(".walk-line:has-text('tick 10 at 9 ms')")
    step = 4.0 * math.sqrt(2.0)
    unit = "[data-of='count.sum.output']"
    assert float(page.text_content(unit).split()[0]) == pytest.approx(9.0 * step, rel=1e-4)
    page.click("summary:has-text('count.one')")
    page.fill("[id='count.one.value']", "-1")
    page.press("[id='count.one.value']", "Enter")
    page.wait_for_selector(".walk-line:has-text('were changed on the way')")
    for _ in range(2):
        page.click("text='Tick'")
    page.wait_for_selector(".walk-line:has-text('tick 12 ')")
    assert float(page.text_content(unit).split()[0]) == pytest.approx(10.0 * step - 1.0, rel=1e-4)
    page.click("text='Play'")
    page.wait_for_selector("button:text-is('Pause')")
    page.click("text='Pause'")
    page.wait_for_timeout(200)  # ticks that were asked for before
    stood = page.text_content(".walk-line")
    page.wait_for_timeout(200)
    assert page.text_content(".walk-line") == stood
    page.click("text=Walk")
    digest(page)
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_the_map_unfolds_colours_tells_and_plots(browser: Any, folder: Path, report: str) -> None:
    page, lines = opened(browser, report)
    digest(page)
    assert page.locator("[data-block='count.sum']").count() == 0
    page.click("[data-fold=count]")
    page.wait_for_selector("[data-block='count.sum']")
    assert "part.toml" in page.text_content("[data-block=count]")
    page.click(".map-bar >> text='rates'")
    assert page.evaluate("document.querySelector('svg.proofmass').classList.contains('rates')")
    assert page.locator(".legend.only.rates").is_visible()
    page.locator(".plots .u-over").first.click(position={"x": 200, "y": 60})
    page.wait_for_selector("[data-of='count.one.output']")
    wire = page.locator("[data-signal='count.one.output'] .reach").first
    wire.hover(force=True)
    assert "count.one.output = 5.65685" in page.text_content(".map-time")
    wire.click(force=True)
    page.wait_for_selector("figcaption:has-text('count.one.output')")
    page.wait_for_function("document.querySelectorAll('.plots figure')[0].querySelector('canvas')")
    page.click(".plots .close")
    assert page.locator("figcaption:has-text('count.one.output')").count() == 0
    page.click("[data-fold=count]")
    page.wait_for_selector("[data-block='count.sum']", state="detached")
    assert page.locator("[data-of='total.output']").count() == 1
    assert lines == []
    page.context.close()


def long_way() -> Graph:
    """A tone whose wire to the end of a long chain is named, and two wires past nine gains that run as one."""
    gains = [f"g{i}" for i in range(160)]
    past = [*gains[:9], "after.true_x"], ["before.sensed_x", *(f"{name}.output" for name in gains[:9])]
    on = [*gains[9:], "total.first"], ["after.sensed_x", *(f"{name}.output" for name in gains[9:])]
    wires = [
        f"{source} -> {target if '.' in target else f'{target}.input'}"
        for targets, sources in (past, on)
        for source, target in zip(sources, targets, strict=True)
    ]
    wires += [f"tone.output -> before.true_{axis}" for axis in "xyz"] + ["tone.output -> total.second"]
    wires += [f"before.sensed_{axis} -> after.true_{axis}" for axis in "yz"]
    named = {"tone": Sine(), "before": MisalignedTriad(unit="1"), "after": MisalignedTriad(unit="1"), "total": Sum()}
    blocks = {**named, **{name: Gain() for name in gains}}
    return Graph(name="long way", rate="1 kHz", samples=50, blocks=blocks, wires=wires, probes=["total.output"])


@pytest.mark.exhaustive
def test_a_tab_marks_its_net_and_a_bundle_shows_all_it_carries(browser: Any, tmp_path: Path) -> None:
    write_run(simulate(long_way(), engine="python"), tmp_path, (), live=True)
    page, lines = opened(browser, (tmp_path / "report.html").as_uri())
    digest(page)
    net = page.locator("[data-net='tone.output']")
    assert net.locator(".label").count() == 2
    net.locator(".label").last.hover(force=True)
    lit = "one => getComputedStyle(one).strokeOpacity"
    assert {float(wire.evaluate(lit)) for wire in net.locator(".reach").all()} == {0.35}
    assert page.text_content(".map-time").startswith("tone.output")
    net.locator(".label").last.click(force=True)
    page.wait_for_selector("figcaption:has-text('tone.output')")
    assert page.locator("[data-signal='tone.output'].marked").count() == 4
    page.locator(".plots .u-over").first.click(position={"x": 200, "y": 60})
    peek = page.locator("[data-of='tone.output']")
    peek.first.wait_for()
    tab, number = net.locator(".label").last.bounding_box(), peek.first.bounding_box()
    assert number["x"] >= tab["x"] + tab["width"] or number["y"] + number["height"] <= tab["y"]
    assert page.locator(".bundle").count() == 1
    page.locator(".bundle .count").hover(force=True)
    assert {"before.sensed_y", "before.sensed_z"} <= set(re.findall(r"[\w.]+", page.text_content(".map-time")))
    page.locator(".bundle .count").click(force=True)
    for axis in "yz":
        page.wait_for_selector(f"figcaption:has-text('before.sensed_{axis}')")
    assert lines == []
    page.context.close()


CHANGED = """(frames) => new Promise(resolve => {
  const range = document.querySelector("[aria-label='pickoff.gain, slider']"), changed = [];
  const watch = new MutationObserver(all => changed.push(...all.map(one => one.target.localName)));
  for (const part of document.querySelectorAll('.strip, figcaption, svg.proofmass'))
    watch.observe(part, {subtree: true, childList: true, attributes: true, characterData: true});
  let asked = 0;
  const next = () => {
    if (asked === frames) return resolve(changed);
    range.value = String(400 + ++asked);
    range.dispatchEvent(new Event('input'));
    setTimeout(next, 30);
  };
  next();
})"""


@pytest.mark.exhaustive
def test_a_drag_writes_only_what_changes(browser: Any, tmp_path: Path) -> None:
    graph = read_graph("library:closed_loop_accelerometer")
    write_run(simulate(graph, samples=2000, engine="python"), tmp_path, (), live=True)
    page, lines = opened(browser, (tmp_path / "report.html").as_uri())
    before = digest(page)
    page.click("summary:text-is('pickoff')")
    page.evaluate(CHANGED, 1)
    after = digest(page, before)
    changed = page.evaluate(CHANGED, 12)
    assert changed == ["text"] * 11, (
        "the gain on its block with each move but the first; no chip, no caption, no other word"
    )
    last = digest(page, after)
    assert " V/rad" in page.text_content("[data-block=pickoff] .now")
    page.click("text=Reset")
    assert digest(page, last) == before
    assert page.locator(".now").count() == 0
    assert page.text_content("[data-block=pickoff] .setting") == "8 kV/rad"
    assert lines == []
    page.context.close()


@pytest.fixture
def live(folder: Path) -> Iterator[tuple[Path, Process]]:
    file = folder / "graph.toml"
    file.write_text(GRAPH + STUDY)
    process = Process(file)
    yield file, process
    process.kill()


@pytest.mark.exhaustive
def test_the_process_takes_integers_draws_and_runs_a_study(browser: Any, live: tuple[Path, Process]) -> None:
    file, process = live
    page, lines = opened(browser, process.url)
    digest(page)
    page.click("summary:text-is('meter')")
    assert page.input_value("[id='meter.bits']") == "12"
    page.fill("[id='meter.bits']", "9")
    page.press("[id='meter.bits']", "Enter")
    page.wait_for_selector("[data-block=meter] .setting:text-is('9 bit')")
    page.fill("[id='meter.bits']", "many")
    page.press("[id='meter.bits']", "Enter")
    page.wait_for_selector(".problem:has-text('meter.bits')")
    page.fill("[id='meter.bits']", "10")
    page.press("[id='meter.bits']", "Enter")
    page.wait_for_selector("[data-block=meter] .setting:text-is('10 bit')")
    page.wait_for_selector(".problems", state="hidden")
    page.click("[data-fold=count]")
    page.wait_for_selector("[data-block='count.sum']")
    page.click("[data-tab=study]")
    page.wait_for_selector(".panel p:has-text('90 of 90 runs, finished')", timeout=60_000)
    graph = read_graph(file)
    low, high = (simulate(with_parameters(graph, {"step": step})).measures["level"].value for step in (1.97, 2.03))
    assert low < shown(page, ".panel .histogram p") < high
    page.click("[data-tab=spectra]")
    page.wait_for_selector(".panel svg", timeout=60_000)
    assert "total.output: 400 values at 1000 Hz" in page.text_content(".panel pre")
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_the_process_does_what_is_too_long_for_a_page(browser: Any, live: tuple[Path, Process]) -> None:
    """21 million ticks of a counter: lowest and highest values of each pixel, the last near the end."""
    file, process = live
    file.write_text(GRAPH.replace('"= loudness * 1 V/sqrt(Hz)"', "0.0"))
    page, lines = opened(browser, process.url)
    digest(page)
    page.fill("#run-duration", "21000")
    page.press("#run-duration", "Enter")
    page.wait_for_selector(".status:has-text('21,000,001 of 21,000,001 ticks by the process in')", timeout=60_000)
    step = 4.0 * math.sqrt(2.0)
    ticks = 21_000_001
    level = step * math.sqrt((ticks**2 - 1) / 12.0)  # standard deviation of 0, step, and so on
    text = str(page.inner_text(".measures td"))
    assert float(text.split()[0]) * {"MV": 1e6, "kV": 1e3}[text.split()[1]] == pytest.approx(level, rel=1e-5)
    assert lines == []
    page.context.close()
