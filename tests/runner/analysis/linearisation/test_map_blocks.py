"""When blocks of a map tick together again, by hand."""

from types import SimpleNamespace
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.linearisation.map_blocks import period_of_blocks


def planned(slow: int) -> Any:
    """`a` reads itself by way of its slow output, `b` and `far`; ticks of outputs and of blocks."""
    strides = {("a", "fast"): 1, ("a", "slow"): slow, ("b", "output"): 3, ("far", "output"): 5, ("end", "output"): 7}
    drivers = {("a", f"in_{i}"): node for i, node in enumerate(strides) if node[0] != "end"}
    schedule = SimpleNamespace(drivers=drivers, divisors={"a": 2, "b": 3})
    return SimpleNamespace(stride=strides.__getitem__, schedule=schedule)


def test_outputs_of_its_blocks_and_ends_count_and_what_comes_from_outside_does_not() -> None:
    assert period_of_blocks(planned(4), {"a", "b"}, []) == 12
    assert period_of_blocks(planned(4), {"a"}, []) == 4
    assert period_of_blocks(planned(4), {"a"}, [("far", "output")]) == 20
    assert period_of_blocks(planned(4), {"b"}, [("end", "output")]) == 21
    assert period_of_blocks(planned(4), set(), [("end", "output")]) == 7


def test_too_rarely() -> None:
    assert period_of_blocks(planned(100_000), {"a"}, []) == 100_000
    with pytest.raises(ModelError, match="tick together too rarely") as error:
        period_of_blocks(planned(100_002), {"a"}, [])
    assert error.value.problems[0].got == "100,002"
