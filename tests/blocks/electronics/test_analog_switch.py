"""The switch in both positions of both kinds."""

from proofmass.blocks import AnalogSwitch
from tests.by_hand.functions import drive


def outputs(block: AnalogSwitch) -> list[float]:
    rows = drive(block, [{"input": 1e-3, "control": False}, {"input": 2e-3, "control": True}])
    return [row["output"] for row in rows]


def test_normally_open_and_normally_closed() -> None:
    assert outputs(AnalogSwitch(leakage=1e-9)) == [1e-9, 2e-3]
    assert outputs(AnalogSwitch(leakage=1e-9, normally_closed=True)) == [1e-3, 1e-9]


def test_without_a_command_it_stays_as_it_is_normally() -> None:
    assert AnalogSwitch.inputs["control"].default == 0.0
