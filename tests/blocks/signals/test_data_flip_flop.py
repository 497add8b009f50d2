"""The flip-flop: it takes its data at rising edges only, and a chain of them shifts."""

from proofmass.blocks import DataFlipFlop, NotGate, ShiftRegister
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import responses


def test_at_rising_edges_only() -> None:
    data = [bool(int(b)) for b in "101100101"]
    clock = [bool(int(b)) for b in "011010110"]
    assert responses(DataFlipFlop(), data=data, clock=clock) == [bool(int(b)) for b in "000000011"]


def test_a_chain_shifts_by_one_every_edge() -> None:
    graph = Graph(
        name="shift register",
        rate=1,
        blocks={
            "bits": ShiftRegister(),
            "clock": DataFlipFlop(),
            "low": NotGate(),
            "tick": ShiftRegister(length=2, taps=3, seed=1),
            "first": DataFlipFlop(),
            "second": DataFlipFlop(),
        },
        wires=[
            "low.output -> clock.data",
            "tick.bit -> clock.clock",
            "clock.output -> low.input",
            "bits.bit -> first.data",
            "clock.output -> first.clock",
            "first.output -> second.data",
            "clock.output -> second.clock",
        ],
        probes=["bits.bit", "clock.output", "first.output", "second.output"],
    )
    result = simulate(graph, samples=200, engine="python")
    bits, clock = result["bits.bit"].values, result["clock.output"].values
    taken = [False, False]
    for n in range(200):
        assert [result["first.output"].values[n], result["second.output"].values[n]] == taken
        if clock[n] and (n == 0 or not clock[n - 1]):
            taken = [bool(bits[n]), taken[0]]
    assert clock.any()
