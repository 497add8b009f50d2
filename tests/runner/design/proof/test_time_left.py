"""Claims share the time, and one that took all of its part has what others leave."""

import pytest

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.design.proof import attempt, prove, search
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.by_hand.design_texts import INTEGRATING

GRAPH = read_graph_text(INTEGRATING)


class CountingClock:
    """A clock that is a second later at each look."""

    def __init__(self) -> None:
        self.looks = 0

    def monotonic(self) -> float:
        self.looks += 1
        return float(self.looks)


@pytest.mark.exhaustive("open")
@pytest.mark.parametrize(("seconds", "status"), [(52.0, "open"), (56.0, "proved")])
def test_time_that_others_leave_is_used(monkeypatch: pytest.MonkeyPatch, seconds: float, status: str) -> None:
    """Of 19.17 dB at the worst 19 take 9 looks at boxes, others one each; a third of 56 s serves for fewer."""
    clock = CountingClock()
    for module in (attempt, prove, search):
        monkeypatch.setattr(module, "time", clock)
    margins = {"gain_margin": "19 dB", "phase_margin": "45 deg"}
    found = prove.prove(GRAPH, tolerances={"controller.gain": "10 %"}, seconds=seconds, workers=1, **margins)
    assert [one.claim.kind for one in found.proofs] == ["stable", "gain margin", "phase margin"]
    assert [one.status for one in found.proofs] == ["proved", status, "proved"]
    assert 0.0 < found.proofs[1].searched.part <= 1.0
    assert found.proofs[1].searched.why == ("the time is up" if status == "open" else "")
    assert len(check_certificate(certificate(found))) == 2 + (status == "proved")
    assert seconds - 10.0 < clock.looks < seconds + 15.0
