"""What a certificate proves, beside the runs of a study of the same graph."""

from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.command_line import main
from proofmass.runner.design.proof.prove import prove
from proofmass.runner.studies.shown.plot import plot_distribution
from proofmass.runner.studies.shown.proved import proved_section
from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proved_bounds import proved_bounds
from tests.by_hand.design_texts import INTEGRATING

MEASURES = ["main.stable", "main.gain_margin", "main.phase_margin"]
STUDY = """
[study]
runs = 6
margins = "0 s"
spread = {{ "controller.gain" = {{ uniform = "{width} %", relative = true }} }}
"""
Captured = pytest.CaptureFixture[str]


def study_of(width: float) -> Study:
    return read_study_text(INTEGRATING + STUDY.format(width=width))


@pytest.fixture(scope="module")
def proof() -> str:
    return certificate(prove(study_of(10.0), gain_margin="18 dB", phase_margin="80 deg"))


def test_bounds_are_those_of_the_certificate_and_say_what_goes_beyond_them(proof: str) -> None:
    bounds = proved_bounds(proof, study_of(5.0), MEASURES)
    assert [(one.measure, one.limit) for one in bounds] == list(zip(MEASURES, (1.0, 18.0, 80.0), strict=True))
    assert bounds[1].claim == "main: gain margin of at least 18 dB"
    assert bounds[1].box == "controller.gain from 90 to 110"
    assert {one.beyond for one in bounds} == {()}
    assert {one.beyond for one in proved_bounds(proof, study_of(10.0), MEASURES)} == {()}
    assert {one.beyond for one in proved_bounds(proof, study_of(10.1), MEASURES)} == {("controller.gain",)}
    assert proved_bounds(proof, study_of(5.0), [])[1].measure == ""


@pytest.mark.defect("S918", before="all of a sweep lies within what is proved", after="what lies beyond is named")
def test_what_a_study_sweeps_beyond_a_proof_is_named(proof: str) -> None:
    """The proof has gains from 90 to 110."""
    for gains, beyond in (([95.0, 110.0], ()), ([95.0, 111.0], ("controller.gain",))):
        study = read_study_text(
            f"""{INTEGRATING}[study]\nmargins = "0 s"\nsweep = {{ "controller.gain" = {gains} }}\n"""
        )
        assert {one.beyond for one in proved_bounds(proof, study, MEASURES)} == {beyond}


def test_what_ages_beyond_a_proof_is_named(proof: str) -> None:
    ages = """[study.epochs]\nages = ["0 h", "1 year"]\n[study.drift]\n"controller.gain" = { ramp = "6 1/year" }\n"""
    aged = read_study_text(INTEGRATING + STUDY.format(width=5) + ages)
    assert {one.beyond for one in proved_bounds(proof, aged, MEASURES)} == {("controller.gain",)}
    within = read_study_text(INTEGRATING + STUDY.format(width=5) + ages.replace("6 1", "4 1"))
    assert {one.beyond for one in proved_bounds(proof, within, MEASURES)} == {()}


def test_scale_factors_stand_in_the_table_of_a_report() -> None:
    study = study_of(5.0)
    text = certificate(prove(study, input="wanted.output", scale_factor={"plant.output": [0.99, 1.01]}))
    least, most = proved_bounds(text, study, MEASURES)
    assert (least.measure, least.limit, most.limit) == ("", 0.99, 1.01)
    assert least.claim == "wanted.output to plant.output: scale factor of at least 0.99"
    page = proved_section(run_study(study, engine="python", runs=2), [least, most])
    assert "scale factor of at most 1.01" in page


def test_certificates_of_other_graphs_and_forged_ones_are_refused(proof: str) -> None:
    other = read_study_text(INTEGRATING.replace("gain = 100.0", "gain = 101.0") + STUDY.format(width=5))
    with pytest.raises(ModelError, match="is that of another graph"):
        proved_bounds(proof, other, MEASURES)
    with pytest.raises(ModelError, match="was changed"):
        proved_bounds(proof.replace("18.0", "18.5"), study_of(5.0), MEASURES)


def test_a_histogram_has_a_line_and_a_table_the_least_of_the_runs(proof: str) -> None:
    result = run_study(study_of(5.0), engine="python")
    (measure,) = [one for one in result.measures if one.name == "main.gain_margin"]
    least = float(result["main.gain_margin"].min())
    page = proved_section(result, proved_bounds(proof, result.study, MEASURES))
    assert "main: gain margin of at least 18 dB" in page
    assert f"{least:.4g} dB" in page
    assert "lies within" in page
    panel = plot_distribution(result, measure, [least - 0.1]).axes[0]
    (line,) = [line for line in panel.lines if line.get_label() == "proved within tolerances"]
    assert np.asarray(line.get_xdata()) == pytest.approx([least - 0.1] * 2)
    assert not plot_distribution(result, measure, [least - 60.0]).axes[0].lines  # it would only squeeze the picture


@pytest.mark.exhaustive
def test_the_report_of_a_study_shows_what_is_proved(
    proof: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(INTEGRATING + STUDY.format(width=5), encoding="utf-8")
    Path("proof.json").write_text(proof, encoding="utf-8")
    assert main(["montecarlo", "study.toml", "--out", "lot", "--no-report", "--quiet", "--engine", "python"]) == 0
    assert main(["report", "lot", "--proof", "proof.json"]) == 0
    page = Path("lot/report.html").read_text(encoding="utf-8")
    assert "main: gain margin of at least 18 dB" in page
    assert "lies within" in page
    Path("proof.json").write_text("{}", encoding="utf-8")
    capsys.readouterr()
    assert main(["report", "lot", "--proof", "proof.json"]) == 1
    assert "the certificate is not a proofmass proof" in capsys.readouterr().err
