"""A walk over the blocks of physics: a second derivation stands in the test of each, now and when one is added."""

from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import all_blocks, family_of
from proofmass.blocks.declaration.declare import Block
from tests.derivations import FACTS, ROOMS, derivations

KINDS = {name: kind for name, kind in all_blocks().items() if family_of(kind) in ROOMS}


def test_no_room_is_empty() -> None:
    counts = {room: sum(family_of(kind) == room for kind in KINDS.values()) for room in ROOMS}
    assert all(counts.values())
    assert sum(counts.values()) >= 60


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_second_derivation_stands_in_its_test(kind: type[Block]) -> None:
    stem = kind.__module__.rpartition(".")[2]
    marks = derivations(Path(__file__).parent / family_of(kind) / f"test_{stem}.py")
    own = [mark for mark in marks if mark["block"] == kind.__name__]
    assert own, f"tests/blocks/{family_of(kind)}/test_{stem}.py has no @pytest.mark.derivation({kind.__name__}, ...)"
    for mark in own:
        assert set(mark) - {"block", "wrong"} == set(FACTS)
        assert all(len(mark[name]) > 5 for name in FACTS)
