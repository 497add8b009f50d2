"""A noise budget in the report of a run: its sources, their parts and what they make together."""

import pytest

from proofmass import Graph, noise
from proofmass.blocks import Gain, Sum, WhiteNoise
from proofmass.runner.analysis.noise import report_part
from tests.runner.output.test_report import texts


def test_the_table_has_every_source_and_the_sum(monkeypatch: pytest.MonkeyPatch) -> None:
    """Densities 3 and 4 over 500 Hz: 67.082 and 89.443, with 36 % and 64 % of the mean square of 111.8."""
    monkeypatch.setattr(report_part, "plot_noise", lambda budget: None)
    monkeypatch.setattr(report_part, "picture", lambda drawn, name: f"<p>{name}</p>")
    graph = Graph(
        name="",
        rate=1000,
        blocks={"weak": WhiteNoise(density=3.0), "strong": WhiteNoise(density=4.0), "sum": Sum(), "end": Gain()},
        wires=["weak.output -> sum.first", "strong.output -> sum.second", "sum.output -> end.input"],
    )
    heading, html = report_part.noise_section(noise(graph, "end.output"))
    assert heading == "Noise of end.output"
    rows = "strong WhiteNoise 89.443 64.00 % weak WhiteNoise 67.082 36.00 % all 111.8 100 %"
    assert rows in texts(html)
    assert "0 Hz to 500 Hz" in html
