"""When hardware in the generated loop settles."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.rtl.model.hardware_loop import settled_before

EARLY, CODE, NOW, LATER = ("a", "early"), ("adc", "code"), ("b", "now"), ("b", "later")


@pytest.mark.parametrize(
    ("order", "strides", "expected"),
    [
        ((EARLY, CODE, NOW, LATER), {}, {EARLY, NOW}),
        ((CODE, EARLY, NOW, LATER), {}, {EARLY}),
        ((EARLY, NOW, LATER, CODE), {}, {EARLY}),
        ((CODE, EARLY, NOW), {EARLY: 4, NOW: 8}, {EARLY}),  # in every eighth tick it has settled
        ((CODE, EARLY, NOW, LATER), {EARLY: 4, NOW: 2, LATER: 2}, {EARLY, NOW}),  # in every second not
    ],
)
def test_before_what_is_read_first(
    order: Sequence[Endpoint], strides: dict[Endpoint, int], expected: set[Endpoint]
) -> None:
    found = settled_before(order, lambda node: strides.get(node, 1), {CODE}, {EARLY, NOW, LATER})
    assert found == expected


@given(
    kinds=st.lists(
        st.tuples(st.sampled_from(["input", "output", "other"]), st.sampled_from([1, 2, 3, 4, 6])), max_size=8
    )
)
def test_no_output_is_read_unsettled(kinds: list[tuple[str, int]]) -> None:
    order = [("node", str(n)) for n in range(len(kinds))]
    strides = {node: stride for node, (_, stride) in zip(order, kinds, strict=True)}
    of_kind = {
        kind: {n for n, each in zip(order, kinds, strict=True) if each[0] == kind} for kind in ("input", "output")
    }
    before = settled_before(order, strides.__getitem__, of_kind["input"], of_kind["output"])
    for tick in range(12):
        settled = False
        for node in order:
            if tick % strides[node] == 0:
                settled = (settled or node in before) and node not in of_kind["input"]
                assert settled or node not in of_kind["output"]
