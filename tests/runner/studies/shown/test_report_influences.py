"""What a report says of the factors of one measure: at the last age, and over all ages."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.shown import report
from tests.runner.studies.shown.test_plot import influence, influences

RESULT: Any = SimpleNamespace(study=SimpleNamespace(epochs=(0.0, 3600.0, 7200.0), drift={}))


def at(epoch: int, share: float) -> Any:
    found = influences(influence(1.5, "sensor.mass", share=share), influence(-0.5, "gain.gain", share=0.125))
    return type(found)(found.measure, epoch, np.zeros(600, dtype=int), found.factors, found.values, found.regression)


@pytest.mark.parametrize(
    ("epochs", "tornado", "ages"), [((2,), True, 0), ((0, 2), True, 2), ((0, 1), False, 2), ((0,), False, 0)]
)
def test_a_tornado_at_the_last_age_and_shares_at_each(
    epochs: tuple[int, ...], tornado: bool, ages: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures: list[str] = []
    monkeypatch.setattr(report, "picture", lambda _, name: pictures.append(name) or f"<{name}>")
    text = report._of_measure(RESULT, "bias", [at(epoch, 0.25 * (epoch + 1)) for epoch in epochs]).replace("<wbr>", "")
    assert pictures == ["influences on bias"] * tornado + ["what scatters bias at each age"] * bool(ages)
    assert ("bias does not scatter at the last age" in text) == (not tornado)
    if tornado:
        assert "Linear regression explains 90.0 % of the variance of bias at the age of 2 h (80.0 % for ranks)." in text
    if ages:
        assert [share in text for share in ("sensor.mass 25.0 %", "gain.gain 12.5 %", "90.0 %")] == [True] * 3
        assert ("sensor.mass 50.0 %" in text) == (1 in epochs)
        assert ("sensor.mass 75.0 %" in text) == (2 in epochs)
