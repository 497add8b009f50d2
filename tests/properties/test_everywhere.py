"""Random graphs over all kinds of blocks: the same traces and memory in every engine, by SHA-256 and byte by byte."""

from pathlib import Path

import pytest

from tests.by_hand.amounts import amounts
from tests.by_hand.everywhere import Compared, compared

PIECE = 25


def differences(graphs: list[Compared]) -> list[str]:
    """What differs, with the seed of its graph: `python -m tests.by_hand.everywhere FIRST LAST` runs a piece again."""
    return [f"seed {graph.seed}: {text}" for graph in graphs for text in graph.differences]


@pytest.mark.parametrize("count", amounts(1, 6))
def test_random_graphs_in_every_engine(count: int, tmp_path: Path) -> None:
    graphs = list(compared(range(count), tmp_path, largest=3))
    assert differences(graphs) == []
    assert len({graph.digest for graph in graphs}) == count
    assert sum(not graph.outcomes[0].fault for graph in graphs) > count / 2


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(0, 500, PIECE))
def test_five_hundred_random_graphs_in_every_engine(first: int, tmp_path: Path) -> None:
    assert differences(list(compared(range(first, first + PIECE), tmp_path))) == []
