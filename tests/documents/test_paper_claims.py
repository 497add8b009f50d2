"""The page of the claims of the papers: its tables are those of the rows, and its figures those of runs."""

import pytest

from docs.papers import claims
from docs.papers.claim import VERDICTS, Claim
from proofmass.graphs.files.library import library_files

TEXT = claims.PAGE.read_text(encoding="utf-8")
STATED = claims.stated(TEXT)
SAMPLE = (
    "pn-sequence",
    "pn-tuning",
    "pn-mismatch",
    "pn-occupation",
    "quartz-eq-1",
    "quartz-arithmetic",
    "temperature-m2",
)
RUN = [
    pytest.param(claim, id=claim.name, marks=() if claim.name in SAMPLE else pytest.mark.exhaustive)
    for claim in claims.CLAIMS
    if claim.ours
]


def test_tables_are_those_of_the_rows() -> None:
    assert list(STATED) == [claim.name for claim in claims.CLAIMS]
    assert claims.rendered(TEXT, STATED) == TEXT, "python -m docs.papers.claims --write"


@pytest.mark.exhaustive("temperature-m2")
@pytest.mark.parametrize("claim", RUN)
def test_a_figure_is_that_of_a_run(claim: Claim) -> None:
    assert claims.ours(claim) == STATED[claim.name]


def test_rows_are_complete() -> None:
    names = [claim.name for claim in claims.CLAIMS]
    assert len(set(names)) == len(names)
    graphs = {file.removesuffix(".toml") for file in library_files()}
    for claim in claims.CLAIMS:
        assert claim.verdict in VERDICTS
        assert claim.why or claim.verdict == "holds", f"{claim.name} does not say why"
        assert claim.ours or claim.verdict in ("open", "fails") or "drawing" in claim.paper, claim.name
        known = claim.graph.startswith(("block ", "docs.papers.")) or claim.graph in graphs or not claim.graph
        assert known, f"{claim.name}: no graph {claim.graph}"


def test_a_row_that_is_wrong_is_noticed() -> None:
    wrong = TEXT.replace(f"| {STATED['pn-tuning']} |", "| 42 pm |", 1)
    assert claims.stated(wrong)["pn-tuning"] == "42 pm"
    assert claims.rendered(wrong.replace("tuning of the two modes", "tuning of one mode"), STATED) == TEXT


def test_the_command_prints_a_row_and_refuses_other_names(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["claims", "pn-axes-theirs"])
    claims.main()
    assert STATED["pn-axes-theirs"] in capsys.readouterr().out
    monkeypatch.setattr("sys.argv", ["claims", "nothing"])
    with pytest.raises(SystemExit, match="2"):
        claims.main()
    assert "no row begins with nothing" in capsys.readouterr().err
