"""Pictures of analyses and diagrams in Chromium, narrow and wide, light and dark: letters that can be read."""

import itertools
from pathlib import Path
from typing import Any

import pytest

from proofmass import allan, margins_over, margins_together, noise, response, simulate, spectrum
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.analysis.allan.plot import plot_allan
from proofmass.runner.analysis.margins.plot import plot_margins
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.noise.report_part import noise_section
from proofmass.runner.analysis.response.plot import plot_response
from proofmass.runner.analysis.several.plot import plot_over, plot_together
from proofmass.runner.analysis.spectrum.plot import plot_spectrum
from proofmass.runner.output.page import inline, picture, save_page
from tests.by_hand.chromium import CHROMIUM, SMALLEST_TEXT, opened

pytest.importorskip("playwright.sync_api")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")
DRAWN = (
    "fibre_optic_gyroscope",
    "closed_loop_fluxgate",
    "force_balance_seismometer",
    "imu_3dof",
    "open_loop_gyroscope",
    "phase_locked_loop",
    "quartz_accelerometer",
    "recorded_motion",
    "resonant_accelerometer",
    "sigma_delta_accelerometer",
)


def page_of_all(folder: Path) -> Path:
    graph = read_graph("library:closed_loop_accelerometer")
    trace = simulate(graph, samples=4000, engine="python")["dac.code"]
    figures = {
        "margins": plot_margins(margins(graph)),
        "together": plot_together(margins_together(graph, ["dac.voltage", "adc.number"])),
        "over": plot_over(margins_over(graph, "pid.integral", [1.0, 30.0])),
        "response": plot_response(response(graph, "acceleration.output", "adc.number")),
        "spectrum": plot_spectrum(spectrum(trace)),
        "allan": plot_allan(allan(trace)),
    }
    budget = noise(read_graph("library:recorded_motion"), "mean.mean", input="motion.output")
    sections = [(name, f'<div class="wide">{picture(figure, name)}</div>') for name, figure in figures.items()]
    sections.append(noise_section(budget))
    for name in DRAWN:
        drawn = inline(svg(read_graph(f"library:{name}")))
        sections.append((name, f'<div class="wide diagram">{drawn}</div>'))
    return save_page(folder / "page.html", "pictures", "", sections, "")


@pytest.mark.exhaustive
def test_no_letter_is_smaller_than_ten_pixels(browser: Any, tmp_path: Path) -> None:
    page, lines = opened(browser, page_of_all(tmp_path).as_uri())
    for scheme, width in itertools.product(("light", "dark"), (400, 1400)):
        page.emulate_media(color_scheme=scheme)
        page.set_viewport_size({"width": width, "height": 900})
        size, text = page.evaluate(SMALLEST_TEXT)
        assert size >= 10.0, (text, scheme, width)
        assert page.evaluate("document.documentElement.scrollWidth") == width, "pictures scroll, not the page"
    assert lines == []
    page.context.close()


def test_a_diagram_alone_has_its_paper_all_around(browser: Any, tmp_path: Path) -> None:
    file = tmp_path / "loop.svg"
    file.write_text(svg(read_graph("library:phase_locked_loop")), encoding="utf-8")
    page, _ = opened(browser, file.as_uri())
    for scheme, paper in (("light", "rgb(255, 255, 255)"), ("dark", "rgb(18, 24, 30)")):
        page.emulate_media(color_scheme=scheme)
        assert page.evaluate("getComputedStyle(document.documentElement).backgroundColor") == paper
    page.context.close()
