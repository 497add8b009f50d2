"""A hash of what decides the bits of a run beside graph, seed and recordings."""

import hashlib
from typing import Any

from proofmass.runner.plan.planned import Plan


def code_of(planned: Plan, *beginnings: Plan, once: str = "") -> str:
    """Return a hash of the program of a plan, and of the numbers with which it and others of its kind begin.

    The program has what functions do in each tick. What others do before the first one, and what
    parameters are where the graph says nothing, is known by the numbers that come of it, and for
    sensors with other parameters by the text of these functions, `once`.
    """
    # start-up time: only what is kept on disk needs the program
    from proofmass.runner.program.tick import write_tick
    from proofmass.runner.targets.llvm_text import content_of

    digest = hashlib.sha256(content_of(write_tick(planned).program).encode() + once.encode())
    for each in (planned, *beginnings):
        digest.update(repr(_numbers(each)).encode())
    return digest.hexdigest()


def _numbers(planned: Plan) -> list[object]:
    """Return parameters, constants, states and buffers of all blocks at tick 0, without recordings."""
    given = {}
    for name, block in planned.blocks.items():
        record: Any = type(block).parameters_class()
        given[name] = [getattr(block, parameter) for parameter in record._fields]
    filled = {repr(node): held for node, held in planned.buffers.items() if node not in planned.recorded}
    return [sorted(table.items()) for table in (given, planned.constants, planned.starts, filled)]
