"""Random loops of a controller, a delay and a gain in registers, at two rates: no proof is false in any run."""

import random

import pytest

from proofmass import Graph
from proofmass.blocks import (
    Constant,
    FixedDelay,
    FixedDifference,
    FixedGain,
    FixedPID,
    FixedQuantiser,
    RepeatingSequence,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.runner.design.proof.prove import prove
from proofmass.runner.run.simulate import simulate
from tests.by_hand.fixed_point import ROUNDINGS

WORD, TICKS = Fixed(14, 6), 300


def random_loop(rng: random.Random) -> Graph:
    ways = {"overflow": rng.choice(("wrap", "saturate"))}

    def gain(most: float) -> FixedGain:
        rounding = rng.choice(ROUNDINGS)
        return FixedGain(
            gain=rng.uniform(-most, most), input_format=WORD, output_format=WORD, rounding=rounding, **ways
        )

    return Graph(
        name="loop",
        rate=1000,
        blocks={
            "source": Constant(value=0.0),
            "quantiser": FixedQuantiser(output_format=WORD),
            "error": FixedDifference(input_format=WORD, output_format=WORD, **ways),
            "controller": FixedPID(
                proportional=rng.uniform(0.0, 0.8),
                integral=rng.choice([0.0, rng.uniform(0.0, 300.0)]),
                derivative_gain=rng.choice([0.0, rng.uniform(0.0, 2e-4)]),
                derivative_pole=100.0,
                input_format=WORD,
                output_format=WORD,
                sum_format=Fixed(24, 14),
                rounding=rng.choice(ROUNDINGS),
                **ways,
            ),
            "delay": FixedDelay(format=WORD, ticks=rng.randint(1, 3)),
            "gain": gain(0.9),
            "slow": gain(1.0),
        },
        wires=[
            "source.output -> quantiser.input",
            "quantiser.output -> error.first",
            "gain.output -> error.second",
            "error.output -> controller.error",
            "controller.output -> delay.input",
            "delay.output -> gain.input",
            "controller.output -> slow.input",
        ],
        rates={"slow": 500},
        probes=["controller.output", "slow.output", "error.output"],
    )


@pytest.mark.parametrize("seed", [1, 2, *[pytest.param(s, marks=pytest.mark.exhaustive) for s in range(3, 150)]])
def test_no_proof_is_false(seed: int) -> None:
    rng = random.Random(seed)
    graph, most = random_loop(rng), rng.choice([1.0, 5.0, 20.0, 60.0])
    (found,) = prove(graph, no_overflow=True, input_ranges={"source.output": [-most, most]}).digital
    assert found.status in ("proved", "refuted")
    if found.run is not None:
        assert any(simulate(found.run.graph).overflows.values())
        return
    rooms = {room.at: room for room in found.rooms if (room.lowest, room.highest) == (WORD.lowest, WORD.highest)}
    steady = [rng.choice((-most, most))] * (TICKS // 2)
    for values in (rng.choices((-most, most), k=TICKS), [*steady, *(rng.uniform(-most, most) for _ in steady)]):
        blocks = {**graph.blocks, "source": RepeatingSequence(values=tuple(values))}
        run = simulate(graph.changed(blocks=blocks), samples=TICKS)
        assert not any(run.overflows.values())
        for signal in run:
            mantissas = run[signal].mantissas
            assert rooms[signal].low - 1e-6 <= mantissas.min() <= mantissas.max() <= rooms[signal].high + 1e-6
