"""Notes on blocks that run at another rate than their neighbours suggest, or that answer a tick late."""

import pytest

from proofmass.blocks import (
    Comparator,
    Constant,
    Difference,
    DiscreteIntegrator,
    Gain,
    LowPass,
    Ramp,
    Relay,
    Step,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.checks.check import check
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.graph_texts import ALONE, problems_of

REPEATED, PASSED, LATE = "reads the same value", "only one in", "switches after the tick"


def notes(*blocks_and_wires: object, rate: str = "512 kHz", **more: object) -> list[Problem]:
    blocks = {k: v for part in blocks_and_wires if isinstance(part, dict) for k, v in part.items()}
    wires = [part for part in blocks_and_wires if isinstance(part, str)]
    found = check(Graph(name="clocks", rate=rate, blocks=blocks, wires=wires, **more))  # type: ignore[arg-type]
    assert all(problem.note for problem in found), found
    return [p for p in found if p.message.startswith((REPEATED, PASSED, LATE))]


SLOW = {"slow": Ramp(), "memory": UnitDelay()}


@pytest.mark.defect(
    "S10", before="check is silent: 64 times too little", after="a note names block, wire and both rates"
)
def test_a_memory_without_a_rate_behind_a_slower_wire() -> None:
    (note,) = notes(SLOW, "slow.output -> memory.input", rates={"slow": "8 kHz"}, probes=["memory.output"])
    assert str(note) == (
        "note: blocks.memory: reads the same value 64 times: it has no rate of its own\n"
        "  got:      512 kHz, and slow.output at 8 kHz\n"
        '  hint:     add rate = "8 kHz" to the block, or rate = "512 kHz" where it is meant so'
    )


@pytest.mark.parametrize("rate", ["8 kHz", "512 kHz"])
def test_a_rate_of_its_own_says_that_it_is_meant(rate: str) -> None:
    rates = {"slow": "8 kHz", "memory": rate}
    assert notes(SLOW, "slow.output -> memory.input", rates=rates, probes=["memory.output"]) == []


def test_a_constant_beside_the_slow_wire_does_not_count() -> None:
    blocks = {"slow": Ramp(), "sum": DiscreteIntegrator(), "gain": Constant()}
    wires = ["slow.output -> sum.input", "gain.output -> sum.gain"]
    (note,) = notes(blocks, *wires, rates={"slow": "8 kHz"}, probes=["sum.output"])
    assert note.key == "blocks.sum"


def test_what_reads_a_fast_wire_too_or_has_no_memory_is_right() -> None:
    fast = SLOW | {"fast": Ramp(), "sum": Difference(), "amplifier": Gain()}
    wires = ["slow.output -> sum.first", "fast.output -> sum.second", "sum.output -> memory.input"]
    assert (
        notes(fast, *wires, "slow.output -> amplifier.input", rates={"slow": "8 kHz"}, probes=["memory.output"]) == []
    )


def test_an_integrator_that_faster_blocks_read_is_right() -> None:
    """The phase of a carrier, whose frequency a slow loop sets."""
    blocks: dict[str, Block] = {"slow": Ramp(), "phase": DiscreteIntegrator(), "fast": UnitDelay(unit="s")}
    wires = ["slow.output -> phase.input", "phase.output -> fast.input"]
    assert notes(blocks, *wires, rates={"slow": "8 kHz"}, probes=["fast.output"]) == []
    rates = {"slow": "8 kHz", "fast": "8 kHz"}
    assert [note.key for note in notes(blocks, *wires, rates=rates, probes=["fast.output"])] == ["blocks.phase"]


COMB: dict[str, Block] = {"sum": DiscreteIntegrator(), "source": Step(), "delay": UnitDelay(unit="s")}
COMB_WIRES = (
    "source.output -> sum.input",
    "sum.output -> delay.input",
    "sum.output -> comb.first",
    "delay.output -> comb.second",
)


@pytest.mark.defect(
    "S10", before="a delay forgotten behind a decimator: silence", after="a note names it and its reader"
)
def test_a_delay_without_a_rate_beside_a_decimated_wire() -> None:
    blocks = COMB | {"comb": Difference(unit="s")}
    (note,) = notes(blocks, *COMB_WIRES, rates={"comb": "8 kHz"}, probes=["comb.output"])
    assert str(note) == (
        "note: blocks.delay: only one in 64 of its values is read: it has no rate of its own\n"
        "  got:      512 kHz; comb reads sum.output at 8 kHz, directly and through delay\n"
        '  hint:     add rate = "8 kHz" to the block, or rate = "512 kHz" where it is meant so'
    )
    assert notes(blocks, *COMB_WIRES, rates={"comb": "8 kHz", "delay": "8 kHz"}, probes=["comb.output"]) == []


def test_an_integrator_before_a_decimator_is_right() -> None:
    blocks: dict[str, Block] = {"source": Step(), "sum": DiscreteIntegrator(), "slow": UnitDelay(unit="s")}
    wires = ["source.output -> sum.input", "sum.output -> slow.input"]
    assert notes(blocks, *wires, rates={"slow": "8 kHz"}, probes=["slow.output"]) == []


RELAY: dict[str, Block] = {"step": Step(amplitude=2.0, offset=-1.0, start_time=2e-3), "relay": Relay()}


def test_relays_of_one_block_with_memory_are_late_each() -> None:
    blocks = {"step": Step(), "delay": UnitDelay(), "one": Relay(), "other": Relay()}
    wires = ["step.output -> delay.input", "delay.output -> one.input", "delay.output -> other.input"]
    late = notes(blocks, *wires, rate="1 kHz", probes=["one.output", "other.output"])
    assert [note.key for note in late] == ["blocks.one", "blocks.other"]
    assert all(note.got == "delay.output, held from tick to tick" for note in late)


@pytest.mark.defect("S9", before="a Relay read at ticks is late, silently", after="a note names the Comparator")
def test_a_relay_of_a_held_signal_that_is_read_at_ticks() -> None:
    (note,) = notes(RELAY, "step.output -> relay.input", rate="1 kHz", probes=["relay.output"])
    assert note.message.startswith(LATE)
    assert "take a Comparator" in note.hint
    late = Graph(name="late", rate="1 kHz", blocks=RELAY, wires=["step.output -> relay.input"], probes=["relay.output"])
    assert simulate(late, samples=5, engine="python")["relay.output"].values.tolist() == [-1.0, -1.0, -1.0, 1.0, 1.0]
    at_once = Graph(
        name="at once",
        rate="1 kHz",
        blocks=RELAY | {"relay": Comparator()},
        wires=["step.output -> relay.input"],
        probes=["relay.sign"],
    )
    assert simulate(at_once, samples=5, engine="python")["relay.sign"].values.tolist() == [-1.0, -1.0, 1.0, 1.0, 1.0]


def test_a_relay_between_continuous_blocks_is_right() -> None:
    smooth = RELAY | {"before": LowPass()}
    wires = ["step.output -> before.input", "before.output -> relay.input"]
    assert notes(smooth, *wires, rate="1 kHz", probes=["relay.output"]) == []
    wires = ["step.output -> relay.input", "relay.output -> behind.input"]
    assert notes(RELAY | {"behind": LowPass()}, *wires, rate="1 kHz", probes=["behind.output"]) == []
    moving = {"sources": "continuous"}
    assert notes(RELAY, "step.output -> relay.input", rate="1 kHz", probes=["relay.output"], integration=moving) == []


@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_no_graph_of_the_library_gets_such_a_note(path: object) -> None:
    found = problems_of(path.read_text(encoding="utf-8"), folder=str(path.parent))  # type: ignore[attr-defined]
    assert [p for p in found if p.message.startswith((REPEATED, PASSED, LATE))] == []
