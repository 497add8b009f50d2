"""Outputs of every block of the library, called with balls or polynomials for parameters, hold those of all sensors."""

import random
import zlib

import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.example import example_of
from proofmass.runner.derivatives.ball import Ball, UndecidedError, ball
from proofmass.runner.derivatives.polynomial import PolynomialBall
from proofmass.runner.design.proof.ball_ticks import BallTicks, with_balls
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference.interpret import Interpreter, TickError
from tests.by_hand.amounts import chosen
from tests.by_hand.taylor_models import number_at

TICK = 37  # of the example, whose signals move by then
KINDS = [
    kind
    for name, kind in all_blocks().items()
    if kind.outputs and not kind.has_formats() and name != "RecordedSignal"  # it needs a file
]
ROUNDING = ("AnalogToDigital", "MashModulator", "Quantiser", "SigmaDeltaModulator")  # what polynomials count as ideal
SAMPLE = [kind for kind in KINDS if zlib.crc32(kind.__name__.encode()) % 5 == 0]  # the same when others come


def free(block: Block) -> dict[str, float]:
    """Parameters that may have a tolerance."""
    kinds = type(block).parameters
    return {n: getattr(block, n) for n, p in kinds.items() if p.kind is float and getattr(block, n) != 0.0}


def within_bounds(kind: type[Block], name: str, value: float, part: float) -> list[float]:
    """A relative tolerance about a value, no further than the block takes."""
    ends = sorted((value * (1.0 - part), value * (1.0 + part)))
    return [end if kind.parameters[name].inside(end) else value for end in ends]


def outputs_hold(kind: type[Block], part: float, sensors: int, follow: bool = False) -> int:
    """Return how many outputs in a box of relative tolerances were compared with those of sensors in it.

    Polynomials `follow` the parameters: they hold each sensor at its own place, but for the rounding of its run.
    """
    graph, draw = example_of(kind), random.Random(zlib.crc32(kind.__name__.encode()))
    assert isinstance(graph, Graph)
    nominal = plan(graph)
    values = free(nominal.blocks["block"])
    if not values or any(isinstance(b, Deviate) for port in kind.outputs for b in nominal.bindings("block", port)):
        return 0
    run = Interpreter(nominal, seed=0)
    run.advance(TICK, [[0.0] * TICK for _ in nominal.probes])
    memory = run.memory()
    ends = {f"block.{n}": within_bounds(kind, n, v, part) for n, v in values.items()}
    numbers = {
        n: PolynomialBall.coordinate(low, high, i) if follow else ball(low, high)
        for i, (n, (low, high)) in enumerate(ends.items())
    }
    try:
        whole = BallTicks(
            with_balls(nominal, numbers),
            memory.copy(), set(nominal.blocks), [], [], False, False,
        )  # fmt: skip
        whole.advance(TICK + 1, ())
    except (UndecidedError, TickError, TypeError):
        return 0  # it decides differently within the box, or draws from what has no ball
    seen = 0
    for _ in range(sensors):
        places = [draw.uniform(-1.0, 1.0) for _ in ends]
        values = {n: 0.5 * (a * (1.0 - d) + b * (1.0 + d)) for d, (n, (a, b)) in zip(places, ends.items(), strict=True)}
        try:
            other = plan(graph.with_parameters(values))
        except ModelError:
            continue  # parameters that do not go together
        one = Interpreter(other, seed=0, memory=memory.copy())
        one._compute(TICK)
        for port in kind.outputs:
            mine, all_of = one.memory().wires["block", port], whole.memory().wires["block", port]
            for number, enclosure in zip(*((v if isinstance(v, list) else [v]) for v in (mine, all_of)), strict=True):
                if isinstance(enclosure, Ball):
                    low, high = Ball(number_at(enclosure, places)).ends()
                    room = 1e-12 * abs(number) * follow
                    assert low - room <= number <= high + room, f"{kind.__name__}.{port} with a tolerance of {part}"
                    seen += 1
    return seen


@pytest.mark.exhaustive("ModeCoupledGyroscope", "EllipticBand")  # of many parameters
@pytest.mark.parametrize(
    "kind", chosen(SAMPLE, [kind for kind in KINDS if kind not in SAMPLE]), ids=lambda kind: kind.__name__
)
def test_outputs_hold_those_of_all_sensors(kind: type[Block]) -> None:
    for part in (1e-9, 1e-4, 1e-2):
        outputs_hold(kind, part, 4)
        if kind.__name__ not in ROUNDING:
            outputs_hold(kind, part, 4, follow=True)


def test_most_blocks_have_an_answer() -> None:
    answers = {kind.__name__: outputs_hold(kind, 1e-9, 1) for kind in SAMPLE if free(kind())}
    assert sum(count > 0 for count in answers.values()) > 0.5 * len(answers), answers
