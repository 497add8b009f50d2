"""What a notebook shows of results: tables that hold the numbers, pictures, and values for pandas and NumPy."""

import ast
import inspect
import re
import xml.etree.ElementTree as ElementTree
from html import escape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import proofmass
from proofmass.blocks import Gain, Step

NOTEBOOKS = Path(__file__).parents[3] / "docs" / "notebooks"


class Cells(HTMLParser):
    """Texts of the cells of a table, row by row; every tag is closed."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        if tag != "polyline":
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        if tag != "polyline":
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.rows and self.rows[-1] and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


@pytest.mark.friendly(16, "a run shows itself")
def test_a_run_in_a_notebook() -> None:
    result = proofmass.simulate("library:template")
    rows = Cells(result._repr_html_()).rows
    assert rows[0][:3] == ["signal", "unit", "rows"]
    last = result["sensor.displacement"].values
    assert rows[1][:3] == ["sensor.displacement", "nm", f"{len(last):,}"]
    assert float(rows[1][6]) == pytest.approx(1e9 * last.max(), rel=1e-5)
    frame = result.to_pandas()
    assert list(frame.columns) == ["sensor.displacement [m]", "adc.code [1]"]
    assert frame.index[10] == result["adc.code"].times[10]
    assert np.array_equal(np.asarray(result["adc.code"]), frame["adc.code [1]"])
    assert len(result.plot().axes) == 2
    assert result["adc.code"].plot().axes[0].get_ylabel() == "adc.code"
    assert "to_pandas" in dir(result["adc.code"])


def test_probes_of_two_rates_have_gaps_in_one_frame() -> None:
    graph = proofmass.read_graph("library:template")
    graph = graph.changed(probes=(proofmass.Probe("sensor.displacement"), proofmass.Probe("adc.code", every=4)))
    frame = proofmass.simulate(graph, samples=9).to_pandas()
    assert frame["adc.code [1]"].notna().tolist() == [True, False, False, False, True, False, False, False, True]


@pytest.mark.exhaustive
@pytest.mark.friendly(16, "margins, noise and studies show themselves")
def test_margins_noise_and_a_study_in_a_notebook() -> None:
    margins = proofmass.margins("library:closed_loop_accelerometer")
    rows = dict(Cells(margins._repr_html_()).rows)
    assert rows["verdict"] == "stable"
    assert float(rows["gain margin"].removesuffix(" dB")) == pytest.approx(20 * np.log10(margins.gain_margin), rel=1e-3)
    assert margins.to_pandas()["phase_margin_deg"] == pytest.approx(np.degrees(margins.phase_margin))
    assert len(margins.plot().axes) >= 4
    budget = proofmass.noise("library:recorded_motion", "mean.mean")
    frame = budget.to_pandas()
    assert frame["share"].sum() == pytest.approx(1.0)
    assert [row[0] for row in Cells(budget._repr_html_()).rows[1:]] == frame["source"].tolist()
    assert budget.plot().axes
    study = proofmass.run_study("library:scale_factor_drift", runs=3)
    table = Cells(study._repr_html_()).rows
    assert table[1][2] == "0 s"
    assert {row[0] for row in table[1:]} == {"noise", "scale_factor"}
    assert len(study.to_pandas()) == 3 * len(study.study.epochs)
    assert study.plot().axes


def test_a_block_shows_its_parameters_as_its_signature() -> None:
    assert str(inspect.signature(Step)).startswith("(*, amplitude: float = 1.0, start_time: float = 0.0")


@pytest.mark.exhaustive
def test_results_with_a_text_are_a_line_at_a_prompt_and_the_text_of_their_command_in_a_notebook() -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=400)
    results: list[Any] = [
        proofmass.response("library:recorded_motion", "motion.output", "mean.mean"),
        proofmass.allan(values, rate=10.0),
        proofmass.spectrum(values, rate=10.0),
        proofmass.deviation_over_runs("library:recorded_motion", "mean.mean", until="0.1 s"),
        proofmass.prove("library:closed_loop_accelerometer"),
        proofmass.design_modulator(2, 32, samples=1024),
        proofmass.worst("library:closed_loop_accelerometer", tolerances={"torquer.gain": "5 %"}, samples=0),
    ]
    for result in results:
        line, text = repr(result), str(result)
        assert line.startswith(f"<{type(result).__name__}: {text.splitlines()[0]}")
        assert "\n" not in line
        assert len(text.splitlines()) > 1
        assert escape(text) in result._repr_html_()
    assert set(proofmass._TEXTS) - {type(result).__name__ for result in results} == {"Fitted", "Tuned"}


@pytest.mark.defect("S690", before="<Figure size 900x498 with 2 Axes>", after="the picture")
@pytest.mark.friendly(16, "figures show themselves")
def test_a_figure_is_shown_without_pyplot() -> None:
    """A notebook asks the class of a value for its pictures; matplotlib's own figure has none."""
    for kind in proofmass._PICTURES:
        assert hasattr(getattr(proofmass, kind), "plot")
    picture = proofmass.simulate("library:template").plot()._repr_svg_()
    drawing = ElementTree.fromstring(picture)
    assert drawing.tag == "{http://www.w3.org/2000/svg}svg"
    assert len(list(drawing.iter("{http://www.w3.org/2000/svg}path"))) > 10


def test_problems_are_texts_and_an_empty_list_is_one() -> None:
    none = proofmass.check("library:template")
    assert none == []
    assert repr(none) == "[]"
    assert "no problems" in none._repr_html_()
    graph = proofmass.Graph(name="open", rate="1 kHz", samples=1, blocks={"gain": Gain()})
    problems = proofmass.check(graph)
    assert repr(problems) == "\n".join(map(str, problems))
    assert "the input input is not connected" in problems._repr_html_()


@pytest.mark.exhaustive("noise-of-a-readout.md", "ten-years-of-drift.md")
@pytest.mark.parametrize("page", sorted(path.name for path in NOTEBOOKS.glob("*.md")))
def test_the_notebooks_of_the_documents_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text, names = (NOTEBOOKS / page).read_text(encoding="utf-8"), dict[str, Any]()
    cells = re.findall(r"^```\{code-cell\} python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    assert len(cells) > 4
    pictures = 0
    for cell in cells:
        *before, last = ast.parse(cell).body
        exec(compile(ast.Module(before, []), page, "exec"), names)
        if isinstance(last, ast.Expr):
            shown = eval(compile(ast.Expression(last.value), page, "eval"), names)
            pictures += hasattr(shown, "_repr_svg_")
        else:
            exec(compile(ast.Module([last], []), page, "exec"), names)
    assert pictures
