"""Golden results of graphs that have changed, and files that a person has edited."""

import json
import math
from pathlib import Path

import pytest

from proofmass import Graph
from proofmass.blocks import Constant, Gain, Sum, UnitDelay
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.verification.golden import compared, read_golden, record
from proofmass.runner.verification.verify import Measurements


def grows(gain: float, unit: str = "1") -> Measurements:
    """Return the measurements of x[n+1] = g x[n] + 1."""
    graph = Graph(
        name="grows",
        rate="1 kHz",
        samples=100,
        blocks={
            "push": Constant(value=1.0, unit=unit),
            "sum": Sum(unit=unit),
            "delay": UnitDelay(unit=unit),
            "gain": Gain(gain=gain, input_unit=unit, output_unit=unit),
        },
        wires=[
            "push.output -> sum.first",
            "gain.output -> sum.second",
            "sum.output -> delay.input",
            "delay.output -> gain.input",
        ],
        measures={"last": {"signal": "sum.output", "statistic": "last"}},
        loops={"main": {"open_at": "gain.output"}},
    )
    return Measurements(graph, None, "python")


@pytest.mark.defect("H924", before="no finding at all where the run fails", after="none has a value, and each says why")
def test_a_run_that_fails_has_no_golden_results(tmp_path: Path) -> None:
    record(grows(0.5), tmp_path / "golden.json")
    found = {one.quantity: one for one in compared(grows(1e30), read_golden(tmp_path / "golden.json"))}
    assert math.isnan(found["last"].value)
    assert "is not finite in tick" in found["last"].reason
    assert not any(one.met for one in found.values())


@pytest.mark.defect("H925", before="`no value` of a quantity in another unit", after="both units are told")
def test_another_unit_is_told(tmp_path: Path) -> None:
    record(grows(0.5), tmp_path / "golden.json")
    found = {one.quantity: one for one in compared(grows(0.5, "V"), read_golden(tmp_path / "golden.json"))}
    assert not found["last"].met
    assert found["last"].reason == "its unit was 1, and is V"


@pytest.mark.defect(
    "C901",
    before="OverflowError; a tolerance of `true` was 100 %, one of NaN none",
    after="not a file of golden results",
)
@pytest.mark.parametrize(
    "change",
    [{"value": 10**400}, {"relative": True}, {"absolute": False}, {"relative": math.nan}, {"absolute": -1.0}],
)
def test_numbers_that_nothing_is_compared_with(change: dict[str, object], tmp_path: Path) -> None:
    path = tmp_path / "golden.json"
    record(grows(0.5), path)
    data = json.loads(path.read_text())
    data["quantities"]["last"] |= change
    path.write_text(json.dumps(data))
    with pytest.raises(ModelError, match="is not a file of golden results"):
        read_golden(path)
