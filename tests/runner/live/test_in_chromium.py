"""Live pages as Chromium runs them: what a person drags, saves, opens twice and kills."""

import contextlib
import json
import math
import shlex
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.commands.run_files import write_run
from proofmass.runner.run.simulate import simulate
from tests.by_hand.chromium import BROKEN_WORDS, CHROMIUM, SMALLEST_TEXT, Process, digest, hash_of, opened

pytest.importorskip("playwright.sync_api")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")

GRAPH = """
name = "an oscillator"
rate = "1 kHz"
samples = 2000
seed = 4
wires = ["push.output -> body.force", "pickoff.output -> meter.voltage", "body.displacement -> pickoff.input"]
probes = ["body.displacement", "meter.code"]

[blocks.push]
kind = "Step"
amplitude = "2 uN"
unit = "N"

[blocks.body]
kind = "MassSpringDamper"
mass = "1 mg"
damping = "10 uN*s/m"
stiffness = "2 N/m"

[blocks.meter]
kind = "AnalogToDigital"
reference = "5 V"

[blocks.pickoff]
kind = "Gain"
gain = 1e6
input_unit = "m"
output_unit = "V"

[blocks.gas]
kind = "BrownianForce"
damping = "1 ug/s"

[measures.settled]
statistic = "mean"
signal = "body.displacement"
from = "1 s"

[measures]
decibels = "= 20 * log10(settled / 1 um)"
turned = { formula = "= settled / 1 m * 1 rad", unit = "deg" }
"""


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a graph and its live report."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "graph.toml").write_text(GRAPH)
    write_run(simulate(read_graph(folder / "graph.toml")), folder, (), live=True)
    return folder


@pytest.mark.exhaustive
def test_dragging_gives_the_bits_of_the_command_line(
    browser: Any, report: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    page, lines = opened(browser, (report / "report.html").as_uri(), permissions=["clipboard-read", "clipboard-write"])
    before = digest(page)
    assert hash_of(before) == json.loads((report / "summary.json").read_text())["digest"]
    page.click("summary:text-is('body')")
    slider = page.locator("[aria-label='body.stiffness, slider']")
    slider.focus()
    for _ in range(3):
        slider.press("ArrowRight")  # the keyboard does what dragging does
    after = digest(page, before)
    page.fill("[id='body.mass']", "1.25")
    page.press("[id='body.mass']", "Enter")
    after = digest(page, after)
    page.click("text=Copy command")
    page.wait_for_selector(".status:text-is('copied')")
    command = shlex.split(page.evaluate("navigator.clipboard.readText()"))
    monkeypatch.chdir(report)
    assert main([*command[1:], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert hash_of(after) == told["digest"] != hash_of(before)
    shown = float(page.inner_text(".measures td").split()[0])
    assert shown == pytest.approx(told["measures"]["settled"]["value"] * 1e9, rel=1e-5)
    rows = [row.split("\t") for row in page.locator(".measures tbody tr").all_inner_texts()]
    values = [float(row[1].split()[0].replace("−", "-")) for row in rows]
    decibels = 20.0 * math.log10(told["measures"]["settled"]["value"] * 1e6)
    assert values[1:] == pytest.approx([decibels, math.degrees(values[0] * 1e-9)], rel=1e-5)
    assert [row[1].split()[1:] + row[2:] for row in rows[1:]] == [
        ["= 20 * log10(settled / 1 um)"],
        ["°", "= settled / 1 m * 1 rad"],
    ]
    page.fill("[id='body.mass']", "-1")
    page.press("[id='body.mass']", "Enter")
    assert "must be above 0" in page.evaluate("document.getElementById('body.mass').validationMessage")
    page.click("text=Reset")
    assert digest(page, after) == before
    assert lines == []
    page.context.close()


def test_a_frozen_run_and_spectra_are_drawn(browser: Any, report: Path) -> None:
    page, lines = opened(browser, (report / "report.html").as_uri() + "#push")
    before = digest(page)
    page.click("text=Freeze")
    assert page.locator("details.block[open] > summary").all_inner_texts() == ["push"]
    page.fill("[id='push.amplitude']", "3")
    page.press("[id='push.amplitude']", "Enter")
    digest(page, before)
    assert page.inner_text(".measures tbody tr").split("\t")[3] == "50.00\u00a0%"
    traces = page.locator(".plots canvas").first.screenshot()
    page.click("text=Spectra")
    page.wait_for_selector("figcaption:has-text('√Hz')")
    assert page.locator(".plots canvas").first.screenshot() != traces
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_a_click_on_a_plot_shows_what_the_wires_hold(browser: Any, report: Path) -> None:
    page, lines = opened(browser, (report / "report.html").as_uri())
    digest(page)
    page.locator(".plots .u-over").first.click(position={"x": 150, "y": 60})
    page.wait_for_selector(".peek")
    number, unit = page.inner_text(".map-time").removeprefix("values at ").split()
    tick = round(float(number) * {"s": 1000.0, "ms": 1.0}[unit])
    expected = simulate(read_graph(report / "graph.toml"))["body.displacement"].values[tick]
    assert 0 < tick < 1999
    number, unit = page.text_content(".peek[data-of='body.displacement']").split()
    assert float(number.replace("−", "-")) == pytest.approx(expected * {"nm": 1e9, "µm": 1e6}[unit], rel=1e-4)
    page.click("text='+'")
    assert page.evaluate("document.querySelector('svg.proofmass').viewBox.baseVal.x") > 0.0
    page.click("text='fit'")
    assert page.evaluate("document.querySelector('svg.proofmass').viewBox.baseVal.x") == 0.0
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive("dark")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_telephone_shows_all_of_it(browser: Any, report: Path, scheme: str) -> None:
    page, lines = opened(browser, (report / "report.html").as_uri(), color_scheme=scheme)
    page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true })")
    assert page.evaluate(BROKEN_WORDS) == [], "names break at underscores alone, also in the column of a wide screen"
    page.set_viewport_size({"width": 400, "height": 800})
    digest(page)
    assert page.evaluate("document.documentElement.scrollWidth") == 400
    assert page.evaluate(BROKEN_WORDS) == []
    size, text = page.evaluate(SMALLEST_TEXT)
    assert size >= 10.0, text
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 24, 30)"
    assert dark == (scheme == "dark")
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_without_scripts_the_report_remains(browser: Any, report: Path) -> None:
    page, lines = opened(browser, (report / "report.html").as_uri(), java_script_enabled=False)
    heads = page.locator("h2").all_inner_texts()
    assert heads == ["Block diagram", "Signals", "Measures", "Traces", "Blocks", "Run", "To repeat it"]
    assert not page.locator("#live").is_visible()
    assert lines == []
    page.context.close()


@pytest.fixture
def live(tmp_path: Path) -> Iterator[tuple[Path, Process]]:
    file = tmp_path / "graph.toml"
    file.write_text(GRAPH)
    process = Process(file)
    yield file, process
    process.kill()


@pytest.mark.exhaustive
def test_a_file_is_live(browser: Any, live: tuple[Path, Process]) -> None:
    """A mistake is shown with its line above the last good run; sliders stay; windows stay in step; kills are seen."""
    file, process = live
    page, lines = opened(browser, process.url)
    before = digest(page)
    page.click("summary:text-is('push')")
    page.fill("[id='push.amplitude']", "3")
    page.press("[id='push.amplitude']", "Enter")
    moved = digest(page, before)
    other, other_lines = opened(browser, process.url)
    assert digest(other) == moved  # a new window shows what the others have set
    other.click("text=Reset")
    assert digest(page, moved) == before
    file.write_text(GRAPH.replace('stiffness = "2 N/m"', 'stifness = "2 N/m"'))
    page.wait_for_selector(".problem")
    wrong = page.inner_text(".problem")
    assert f"{file}:18" in wrong
    assert "did you mean stiffness?" in wrong
    assert digest(page) == before
    page.fill("[id='push.amplitude']", "3")
    page.press("[id='push.amplitude']", "Enter")
    assert digest(page, before) == moved
    file.write_text(GRAPH.replace('stiffness = "2 N/m"', 'stiffness = "3 N/m"'))
    page.wait_for_selector(".problems", state="hidden")
    stiffer = digest(page, moved)
    assert stiffer != before
    assert page.input_value("[id='push.amplitude']") == "3"
    page.click("[data-tab=margins]")
    assert "the graph has no loop" in page.inner_text(".panel .problem")
    assert lines == other_lines == []
    other.context.close()
    process.kill()
    page.wait_for_selector(".lost:visible")
    assert "start proofmass live again" in page.inner_text(".lost")
    page.context.close()


@pytest.mark.exhaustive
@pytest.mark.defect("S561", before="a page sends its token to whoever listens after the server", after="nothing")
def test_a_stranger_on_the_port_is_told_nothing(browser: Any, live: tuple[Path, Process]) -> None:
    file, process = live
    page = browser.new_context().new_page()
    page.goto(process.url)
    page.wait_for_selector("[data-tab]")
    parts = urlsplit(process.url)
    process.kill()
    heard = list[bytes]()
    with socket.create_server(("127.0.0.1", parts.port or 0), reuse_port=False) as stranger:
        stranger.settimeout(6.0)
        for _ in range(3):
            with contextlib.suppress(TimeoutError):
                connection, _ = stranger.accept()
                heard.append(connection.recv(65536))
                connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nno")
                connection.close()
    assert heard
    assert not any(parts.fragment.encode() in request for request in heard)
    page.context.close()
    again = Process(file)
    assert urlsplit(again.url).fragment != parts.fragment
    again.kill()
