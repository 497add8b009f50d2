"""The live page as a bench, by real hands: blocks that open, sliders that write, verdicts, fingers and keys."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from proofmass import margins, read_graph
from proofmass.runner.commands.run_files import write_run
from proofmass.runner.run.simulate import simulate
from tests.by_hand.chromium import BROKEN_WORDS, CHROMIUM, SMALLEST_TEXT, Process, digest, opened

pytest.importorskip("playwright.sync_api")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")

TUTORIAL = Path(__file__).parents[3] / "docs" / "tutorial"
ENDS = """() => [...document.querySelectorAll('.plots .u-over')].map(one => one.getBoundingClientRect().bottom)"""
ZOOM = """() => {
    const map = document.querySelector('.map svg');
    return map.width.baseVal.value / map.viewBox.baseVal.width;
}"""
LABELS = """() => [...document.querySelectorAll('.plots figcaption strong')].map(one => one.textContent)"""


def toml_of(page: str) -> str:
    text = (TUTORIAL / page).read_text(encoding="utf-8")
    return re.findall(r"^```toml\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)[0]


def tutorial() -> str:
    """The graph of the tutorial's third page, with what its fourth requires."""
    return toml_of("3-close-the-loop.md") + "\n" + toml_of("4-margins.md")


def bench(browser: Any, address: str, **options: Any) -> tuple[Any, list[str]]:
    """A page that fails soon where it fails."""
    page, lines = opened(browser, address, **options)
    page.set_default_timeout(8000)
    return page, lines


def pick(page: Any, block: str) -> None:
    page.locator(f"[data-block='{block}'] > .name").click()
    page.wait_for_selector(f".picked .title:text-is('{block}')")


class Slider:
    """A slider that a mouse holds."""

    def __init__(self, page: Any, name: str) -> None:
        self.page = page
        handle = page.locator(f"[aria-label='{name}, slider']")
        handle.scroll_into_view_if_needed()
        self.box = handle.bounding_box()
        self.part = float(handle.input_value()) / 1000.0

    def at(self, part: float) -> tuple[float, float]:
        ends = 8.0  # pixels, half of the thumb
        return self.box["x"] + ends + part * (self.box["width"] - 2 * ends), self.box["y"] + self.box["height"] / 2

    def hold(self) -> "Slider":
        self.page.mouse.move(*self.at(self.part))
        self.page.mouse.down()
        return self

    def drag(self, part: float, steps: int = 6) -> None:
        self.page.mouse.move(*self.at(part), steps=steps)

    def leave(self) -> None:
        self.page.mouse.up()


def chip(page: Any, name: str) -> Any:
    return page.locator(f".chip[data-of='{name}']")


def settled(page: Any) -> None:
    page.wait_for_selector(".strip:not(.waiting)", timeout=20_000)


def angle(page: Any) -> float:
    return float(chip(page, "main phase margin").inner_text().split()[-5])


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, Process]]:
    file = tmp_path_factory.mktemp("bench") / "loop.toml"
    file.write_text(tutorial())
    process = Process(file, "--edit")
    yield file, process
    process.kill()


@pytest.fixture(autouse=True)
def whole(live: tuple[Path, Process]) -> Iterator[None]:
    """What a test leaves broken is no matter of the next one."""
    yield
    if live[0].read_text() != tutorial():
        live[0].write_text(tutorial())


@pytest.mark.exhaustive
def test_the_tutorials_loop_is_tuned_to_45_degrees_by_mouse_alone_and_saved(
    browser: Any, live: tuple[Path, Process]
) -> None:
    """More damping, then more gain until it has 45 degrees; the file keeps its comments and, undone, its bytes."""
    file, process = live
    before = file.read_bytes()
    page, lines = bench(browser, process.url)
    first = digest(page)
    settled(page)
    assert chip(page, "main gain margin").get_attribute("data-met") == "false"
    pick(page, "sensor")
    Slider(page, "sensor.damping").hold().drag(1.0)
    page.mouse.up()
    damping = page.input_value("[id='sensor.damping']")
    assert float(damping) == pytest.approx(5e-4, rel=0.02)
    assert page.text_content("[data-block=sensor] .now") == f"damping {damping} kg/s"
    pick(page, "controller")
    slider, low, high = Slider(page, "controller.integral").hold(), 0.72, 0.86
    for _ in range(14):
        slider.drag((low + high) / 2)
        settled(page)
        low, high = ((low + high) / 2, high) if angle(page) > 45.3 else (low, (low + high) / 2)
        if 45.0 <= angle(page) <= 45.5:
            break
    slider.leave()
    assert 45.0 <= angle(page) <= 45.5
    assert [chip(page, f"main {name} margin").get_attribute("data-met") for name in ("gain", "phase")] == ["true"] * 2
    integral = page.input_value("[id='controller.integral']")
    assert page.text_content("[data-block=controller] .now") == f"integral {integral} 1/s"
    tuned = digest(page, first)
    page.click("text='Save'")
    page.wait_for_selector(".status:has-text('saved: ')")
    page.wait_for_function("() => !document.querySelector('#live .now')")
    assert digest(page) == tuned, "the file has the bits that the sliders had"
    text = before.decode().replace('"5e-5 kg/s"', f'"{damping} kg/s"').replace('"6000 1/s"', f'"{integral} 1/s"')
    assert file.read_text() == text
    assert "# the loop is cut here" in text
    saved = margins(read_graph(file))
    assert math.degrees(saved.phase_margin or 0.0) == pytest.approx(angle(page), abs=0.01)
    page.fill("[id='controller.integral']", "7 kHz")
    page.keyboard.press("Control+s")
    page.wait_for_selector("[data-block=controller] .setting:not(.now):text-is('integral 7000 1/s')")
    assert '"7000 1/s"' in file.read_text()
    page.click("text='Undo save'")
    page.wait_for_selector(f"[data-block=controller] .setting:not(.now):text-is('integral {integral} 1/s')")
    assert file.read_text() == text
    page.click("text='Undo save'")
    page.wait_for_selector("[data-block=controller] .setting:text-is('integral 6000 1/s')")
    assert file.read_bytes() == before
    assert digest(page, tuned) == first
    assert lines == []
    page.context.close()


def test_broken_text_while_dragging_empties_nothing_and_windows_stay_in_step(
    browser: Any, live: tuple[Path, Process]
) -> None:
    file, process = live
    text = tutorial()
    page, lines = bench(browser, process.url)
    other, other_lines = bench(browser, process.url)
    first = digest(page)
    digest(other)
    pick(page, "controller")
    slider = Slider(page, "controller.integral").hold()
    slider.drag(0.4)
    file.write_text(text.replace("[blocks.sensor]", "[blocks.sensor"))
    page.wait_for_selector(".problem")
    slider.drag(0.3)
    slider.leave()
    moved = digest(page, first)
    settled(page)
    assert page.locator("svg [data-block]").count() == 10
    shown = chip(page, "main").inner_text()
    assert shown.split()[:2] == ["main", "stable,"]
    page.click("text='Save'")
    page.wait_for_selector(".problems:has-text('Nothing was written.')")
    assert file.read_text() == text.replace("[blocks.sensor]", "[blocks.sensor")
    value = page.input_value("[id='controller.integral']")
    other.wait_for_selector(f"[data-block=controller] .now:text-is('integral {value} 1/s')")
    assert digest(other, first) == moved
    settled(other)
    assert chip(other, "main").inner_text() == shown
    file.write_text(text)
    page.wait_for_selector(".problems", state="hidden")
    assert digest(page) == moved
    assert page.input_value("[id='controller.integral']") == value
    other.click("text=Reset")
    page.wait_for_function("() => !document.querySelector('#live .now')")
    assert digest(page, moved) == first
    assert lines == other_lines == []
    other.context.close()
    page.context.close()


@pytest.mark.exhaustive
def test_fields_take_units_as_files_write_them_and_say_their_range(browser: Any, live: tuple[Path, Process]) -> None:
    page, lines = bench(browser, live[1].url)
    digest(page)
    typed = [
        ("acceleration.amplitude", "g0", "1", "12 m/s^2", 12.0 / 9.80665),
        ("acceleration.amplitude", "g0", "1", "1.5", 1.5),
        ("readout.gain", "V/um", "20", "30 mV/nm", 30.0),
        ("controller.integral", "1/s", "6000", "6.5 kHz", 6500.0),
        ("inertia.gain", "ug", "20", "0.025 mg", 25.0),
    ]
    for name, unit, value, text, expected in typed:
        block = name.partition(".")[0]
        pick(page, block)
        row = page.locator(f".parameter[data-name='{name}']")
        assert row.locator(".unit").inner_text() == unit
        assert row.locator("input[type=text]").input_value() == value
        row.locator("input[type=text]").fill(text)
        row.locator("input[type=text]").press("Enter")
        now = page.text_content(f"[data-block={block}] .now")
        assert float(re.findall(r"\d[\d.]*", now)[0]) == pytest.approx(expected, rel=1e-5)
        assert float(row.locator("input[type=text]").input_value()) == pytest.approx(expected, rel=1e-15)
        ends = [float(one) for one in row.locator(".ends span").all_inner_texts()]
        assert ends == pytest.approx([float(value) / 10.0, float(value) * 10.0], rel=1e-2)
        page.click("text=Reset")
    pick(page, "controller")
    page.fill("[id='controller.integral']", "2x")
    page.press("[id='controller.integral']", "Enter")
    said = page.evaluate("document.getElementById('controller.integral').validationMessage")
    assert said == "integral has the unit x: write it in 1/s"
    assert page.locator("#live .now").count() == 0
    page.fill("#run-duration", "20 ms")
    page.press("#run-duration", "Enter")
    page.wait_for_selector(".status:has-text('1,001 ticks')")
    page.click("text=Reset")
    page.wait_for_selector(".status:has-text('2,501 ticks')")
    assert page.input_value("#run-duration") == "50 ms"
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_the_first_screen_has_diagram_verdicts_and_two_plots_in_the_order_of_the_file(
    browser: Any, live: tuple[Path, Process]
) -> None:
    page, lines = bench(browser, live[1].url)
    digest(page)
    settled(page)
    assert page.evaluate(LABELS) == ["sensor.displacement", "dac.code"]
    assert max(page.evaluate(ENDS)) < 900.0
    assert page.evaluate("document.querySelector('.strip').getBoundingClientRect().top") > 0.0
    assert page.evaluate("document.querySelector('.map svg').getBoundingClientRect().top") < 200.0
    page.evaluate("window.scrollTo(0, 400)")
    assert page.evaluate("document.querySelector('.strip').getBoundingClientRect().top") >= 0.0, "always in sight"
    assert page.evaluate("parseFloat(getComputedStyle(document.querySelector('.bits')).fontSize)") < 12.0
    pick(page, "sensor")
    page.wait_for_selector(".scopes figcaption:has-text('forces.output')")
    scopes = page.locator(".scopes figcaption strong").all_inner_texts()
    assert scopes == ["forces.output", "sensor.displacement", "sensor.velocity"]
    page.wait_for_function("() => document.querySelectorAll('.scopes canvas').length === 3")
    assert "m x'' + c x' + k x = F" in page.inner_text(".equation")
    assert page.locator(".equation > p.prose").count() == 1, "set as the documents set it"
    assert page.locator("details.block:visible").count() == 1
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_plots_share_zoom_and_marks_and_show_the_spectrum_of_what_is_seen(
    browser: Any, live: tuple[Path, Process]
) -> None:
    page, lines = bench(browser, live[1].url)
    digest(page)
    plot = page.locator(".plots .u-over").first
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 50, steps=4)
    page.mouse.up()
    page.click("text='Spectra'")
    page.wait_for_selector("figcaption:has-text('√Hz')")
    stretches = [re.findall(r"([\d.]+) ms to ([\d.]+) ms", one) for one in page.locator("figcaption").all_inner_texts()]
    assert stretches[0] == stretches[1]
    assert [float(end) for end in stretches[0][0]] == pytest.approx([10.0, 30.0], abs=0.1)
    page.click("text='Traces'")
    page.wait_for_selector("figcaption:has-text('√Hz')", state="hidden")
    plot.click(position={"x": 0.25 * box["width"], "y": 40})
    page.wait_for_selector(".peek")
    values, at, number, unit = page.inner_text(".map-time").split()
    assert (values, at, unit) == ("values", "at", "ms")
    assert float(number) == pytest.approx(15.0, abs=0.1)
    plot.hover(position={"x": 0.5 * box["width"], "y": 40})
    page.wait_for_selector("output:has-text('ms, Δ')")
    for reading in page.locator(".plots output").all_inner_texts():
        at, since = re.findall(r"at ([\d.]+) ms, Δ .* in ([\d.]+) ms", reading)[0]
        assert [float(at), float(since)] == pytest.approx([20.0, 5.0], abs=0.1)
    page.locator(".plots figure").first.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("0")
    plot.hover(position={"x": box["width"] - 1, "y": 40})
    page.wait_for_function("() => /at (49.9|50)/.test(document.querySelector('.plots output').textContent)")
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_keys_and_fingers_do_what_a_mouse_does(browser: Any, live: tuple[Path, Process]) -> None:
    page, lines = bench(browser, live[1].url, has_touch=True, color_scheme="dark")
    page.set_viewport_size({"width": 400, "height": 800})
    digest(page)
    page.locator("[data-block=sensor]").focus()
    page.keyboard.press("Enter")
    page.wait_for_selector(".picked .title:text-is('sensor')")
    page.keyboard.press("Escape")
    page.wait_for_selector(".picked", state="hidden")
    page.locator("[data-block=acceleration] > .name").tap()
    page.wait_for_selector(".picked .title:text-is('acceleration')")
    page.wait_for_function("() => document.querySelectorAll('.scopes canvas').length === 1")
    assert page.evaluate("document.documentElement.scrollWidth") == 400
    assert page.evaluate(BROKEN_WORDS) == []
    size, text = page.evaluate(SMALLEST_TEXT)
    assert size >= 10.0, text
    plot = page.locator(".plots .u-over").first
    plot.scroll_into_view_if_needed()
    box, hand = plot.bounding_box(), page.context.new_cdp_session(page)

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    y = box["y"] + 40
    touch("touchStart", (box["x"] + 0.2 * box["width"], y))
    for part in (0.3, 0.4, 0.6):
        touch("touchMove", (box["x"] + part * box["width"], y))
    touch("touchEnd")
    page.click("text='Spectra'")
    page.wait_for_selector("figcaption:has-text('10 ms to 30 ms')")
    page.locator(".map svg").scroll_into_view_if_needed()
    box = page.locator(".map .wide").bounding_box()
    x, y = box["x"] + 150, box["y"] + 150
    touch("touchStart", (x - 20, y), (x + 20, y))
    for apart in (30, 40):
        touch("touchMove", (x - apart, y), (x + apart, y))
    touch("touchEnd")
    assert page.evaluate(ZOOM) == pytest.approx(2.0, rel=0.05)
    assert lines == []
    page.context.close()


@pytest.mark.exhaustive
def test_a_report_opens_blocks_and_judges_measures_without_a_process(browser: Any, tmp_path: Path) -> None:
    graph = tutorial() + (
        '\n[measures.rest]\nstatistic = "last"\nsignal = "dac.code"\n'
        '\n[requirements]\nsmall = { quantity = "rest", at_least = -70000, at_most = 0, text = "Within the range." }\n'
    )
    (tmp_path / "graph.toml").write_text(graph)
    write_run(simulate(read_graph(tmp_path / "graph.toml")), tmp_path, (), live=True)
    page, lines = bench(browser, (tmp_path / "report.html").as_uri())
    first = digest(page)
    assert page.locator("h1 + #live").count() == 1
    assert max(page.evaluate(ENDS)) < 900.0
    small = chip(page, "small")
    assert small.get_attribute("data-met") == "true"
    assert chip(page, "main").inner_text().split("\n")[-1] == "not asked here"
    pick(page, "acceleration")
    Slider(page, "acceleration.amplitude").hold().drag(0.6)
    page.mouse.up()
    digest(page, first)
    assert small.get_attribute("data-met") == "false"
    assert page.text_content("[data-block=acceleration] .now").startswith("amplitude ")
    assert lines == []
    page.context.close()
