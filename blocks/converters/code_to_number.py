"""Integer code as a number: number = code, exact up to 2^53."""

from proofmass.blocks.declaration.declare import Block, Input


class CodeToNumber(Block):
    """Lets blocks that compute with numbers read an integer code."""

    code = Input("1", "Integer code.", dtype=int)


@CodeToNumber.output("1")
def number(p: CodeToNumber, code: int) -> float:
    """The code as a number."""
    return float(code)
