"""Every meter with a begin and an end: what comes after the end changes nothing, nor what comes before the begin."""

import random
from typing import Any

import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from tests.by_hand.functions import drive

METERS = {name: kind for name, kind in all_blocks().items() if {"skip", "until"} <= kind.parameters.keys()}
OF_THE_WHOLE_RUN = {"BandMeter"}  # its filters have settled where it begins
SAMPLES = [random.Random(5).gauss(1.0, 2.0) for _ in range(120)]


def after(block: Block, samples: list[float]) -> dict[str, Any]:
    """Outputs after some samples."""
    return drive(block, [{"input": sample} for sample in [*samples, 0.0]], 1e-3)[-1]


@pytest.mark.parametrize(("skip", "until"), [(0, 70), (30, 70), (30, 90), (70, 120), (70, 500)])
@pytest.mark.parametrize("name", METERS)
def test_only_samples_between_them_count(name: str, skip: int, until: int) -> None:
    found = after(METERS[name](skip=skip, until=until), SAMPLES)
    assert found == after(METERS[name](skip=skip), SAMPLES[:until])
    if name not in OF_THE_WHOLE_RUN:
        assert found == after(METERS[name](), SAMPLES[skip:until])


def test_meters_have_both() -> None:
    assert len(METERS) > 8
