"""The counter: counting by hand, the carry of a cascade, the reset."""

from proofmass.blocks import Counter, ShiftRegister
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import responses


def test_counting_by_hand() -> None:
    enable = [bool(int(b)) for b in "1101111110"]
    reset = [bool(int(b)) for b in "0000000100"]
    known = {"enable": enable, "reset": reset}
    assert responses(Counter(modulus=4), "count", **known) == [0, 1, 2, 2, 3, 0, 1, 2, 0, 1]
    assert responses(Counter(modulus=4), "carry", **known) == [False] * 4 + [True] + [False] * 5


def test_two_in_series_count_to_the_product() -> None:
    graph = Graph(
        name="cascade",
        rate=1,
        blocks={"bits": ShiftRegister(), "low": Counter(modulus=3), "high": Counter(modulus=5)},
        wires=["bits.bit -> low.enable", "low.carry -> high.enable"],
        probes=["bits.bit", "low.count", "high.count"],
    )
    result = simulate(graph, samples=500, engine="python")
    counted = 0
    for n in range(500):
        assert result["low.count"].values[n] + 3 * result["high.count"].values[n] == counted % 15
        counted += int(result["bits.bit"].values[n])
