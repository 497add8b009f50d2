"""Which wires are looked at for numbers that are not finite."""

import math
import random
from typing import Any

import pytest

from proofmass.blocks import PID, Gain, Product, Saturation, Sum
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.plan.constants import constants_of
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.watched import passes_on, watched
from tests.blocks.test_every_block import KINDS
from tests.by_hand.graph_texts import LIBRARY


def constants(block: Block) -> Any:
    return constants_of(block, block, 1e-3)


@pytest.mark.parametrize(
    ("block", "port", "argument", "expected"),
    [
        (Gain(gain=2.0), "output", "input", True),
        (Sum(), "output", "second", True),
        (Product(), "output", "first", True),
        (PID(), "output", "error", True),
        (PID(limited=True), "output", "error", False),
        (Saturation(), "output", "input", False),
    ],
)
def test_sums_and_products_pass_it_on_and_limits_do_not(block: Block, port: str, argument: str, expected: bool) -> None:
    assert passes_on(block, port, argument, constants(block)) is expected


def test_it_is_so_of_every_block_of_which_it_is_said() -> None:
    draw, said = random.Random(5), set()
    for kind in KINDS.values():
        if kind.has_formats():
            continue
        block = kind()
        for port, output in kind.output_functions.items():
            for argument in set(kind.inputs) & set(output.arguments):
                if kind.inputs[argument].dtype is not float or not passes_on(block, port, argument, constants(block)):
                    continue
                said.add(kind)
                state: Any = kind.state_class()
                for bad in (math.inf, -math.inf, math.nan):
                    given = {name: draw.uniform(-2.0, 2.0) for name in output.arguments} | {argument: bad}
                    given["x"] = state and state(*(draw.uniform(-2.0, 2.0) for _ in state._fields))
                    found = output.function(constants(block), *(given[name] for name in output.arguments))
                    assert not math.isfinite(found), (kind, port, argument, bad)
    assert len(said) > 10


def test_of_a_loop_what_a_limit_would_hide() -> None:
    path = next(path for path in LIBRARY if path.stem == "closed_loop_accelerometer")
    looked_at = {".".join(node) for node in watched(plan(read_graph(path)))}
    # The converters clip; nothing reads the velocity; the reference enters a product that clips.
    assert looked_at == {"pendulum.angular_velocity", "pickoff.output", "pid.output", "reference.output"}
