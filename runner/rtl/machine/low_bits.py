"""Operations that are the low bits of another, as two's complement: wires, no logic."""

from proofmass.runner.fixed.integer_ir import Operation


def operands_of(operation: Operation) -> tuple[Operation, ...]:
    """Operands in the expression of an operation."""
    kept = wrapped(operation)
    return operation.operands if kept is None else (kept,)


def is_bit(operation: Operation) -> bool:
    return operation.low >= 0 and operation.high <= 1


def wrapped(operation: Operation) -> Operation | None:
    """Operation whose low bits, as two's complement, are this one: (value & mask ^ sign) - sign, as `wrap` makes it."""
    if operation.kind != "subtract" or operation.operands[1].constant is None:
        return None
    flipped, sign = operation.operands[0], operation.operands[1].constant
    if flipped.kind != "xor" or (operation.low, operation.high) != (-sign, sign - 1):
        return None
    for masked, other in (flipped.operands, flipped.operands[::-1]):
        if other.constant == sign and masked.kind == "and":
            for value, mask in (masked.operands, masked.operands[::-1]):
                if mask.constant == 2 * sign - 1 and value.width >= operation.width and not is_bit(value):
                    return value
    return None
