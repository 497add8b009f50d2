"""Operations that are the low bits of another, as two's complement: wires, no logic."""

from proofmass.runner.fixed.integer_ir import Node


def operands_of(node: Node) -> tuple[Node, ...]:
    """What the expression of a node is made of."""
    kept = wrapped(node)
    return node.operands if kept is None else (kept,)


def is_bit(node: Node) -> bool:
    return node.low >= 0 and node.high <= 1


def wrapped(node: Node) -> Node | None:
    """What a node is the low bits of as two's complement: (value & mask ^ sign) - sign, as `wrap` makes it."""
    if node.operation != "subtract" or node.operands[1].constant is None:
        return None
    flipped, sign = node.operands[0], node.operands[1].constant
    if flipped.operation != "xor" or (node.low, node.high) != (-sign, sign - 1):
        return None
    for masked, other in (flipped.operands, flipped.operands[::-1]):
        if other.constant == sign and masked.operation == "and":
            for value, mask in (masked.operands, masked.operands[::-1]):
                if mask.constant == 2 * sign - 1 and value.width >= node.width and not is_bit(value):
                    return value
    return None
