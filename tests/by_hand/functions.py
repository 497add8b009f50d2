"""Drive one block by hand, without graph or runner: its registered functions, called in the order of a tick."""

from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of


def drive(
    block: Block,
    samples: list[dict[str, Any]],
    period: float = 1.0,
    normal: float = 0.0,
    recorded: dict[str, list[float]] | None = None,
) -> list[dict[str, Any]]:
    """Outputs of a discrete block in each tick, for the inputs of each tick; `recorded` are its recordings."""
    constants: Any = block
    if "constants" in type(block).functions:
        constants = type(block).functions["constants"].function(block, period)
    known: dict[str, Any] = dict(recorded or {})
    known |= {
        name: [0 if buffer.dtype is int else 0.0] * shape_of(block, buffer)[0]
        for name, buffer in type(block).buffers.items()
        if name not in known
    }
    state_class = type(block).state_class()
    if "start" in type(block).functions:
        start = type(block).functions["start"]
        known["x"] = start.function(block, *({**known, "period": period}[name] for name in start.arguments))
    elif state_class is not None:
        known["x"] = state_class(*(kind(0) for kind in state_class.__annotations__.values()))
    rows = []
    for tick, inputs in enumerate(samples):
        known |= inputs | {"tick": tick, "time": tick * period, "normal": normal}
        row = {}
        for name, behaviour in type(block).output_functions.items():
            shape = shape_of(block, type(block).outputs[name])
            out = [0] * (shape[0] if shape else 0)
            arguments = [out if a == "out" else known[a] for a in behaviour.arguments]
            value = behaviour.function(constants, *arguments)
            row[name] = out if shape else value
        rows.append(row)
        if "update" in type(block).functions:
            update = type(block).functions["update"]
            known["x"] = update.function(constants, *(known[a] for a in update.arguments))
    return rows
