"""Words of hints: the nearest valid names, and what a TOML parser's complaint means to a beginner."""

import math
import re
from collections.abc import Iterable

from proofmass.blocks.declaration.problem import nearest

_LISTED = 12
_LONGEST_LINE = 400  # characters
_COMPARED = 2000  # names; comparing takes some microseconds each
_NUMBER_AND_UNIT = re.compile(r"[+-]?\.?\d.*[A-Za-zµμΩ%]")
_WORD = re.compile(r"[A-Za-z_][\w ./-]*")


def like(word: str, names: Iterable[str], what: str) -> str:
    """The nearest valid name, or the valid names when none is near; `what` is their plural.

    >>> like("voltag", ["voltage"], "inputs of adc")
    'did you mean voltage?'
    >>> like("x", ["code", "number"], "outputs of adc")
    'outputs of adc: code, number.'
    """
    names = sorted(names)
    near = nearest(word, names) if len(names) <= _COMPARED else ""
    if near:
        return f"did you mean {near}?"
    more = [f"and {len(names) - _LISTED} more"] if len(names) > _LISTED else []
    return f"{what}: {', '.join([*names[:_LISTED], *more]) or 'none'}."


def counted(shape: tuple[int, ...]) -> str:
    """The shape of a port in words.

    >>> counted(()), counted((16,))
    ('a single value', 'a vector of 16 entries')
    """
    return f"a vector of {math.prod(shape)} entries" if shape else "a single value"


def syntax_hint(message: str, line: str) -> str:
    """What to write instead of a line that is not TOML.

    >>> syntax_hint("Expected newline", "rate = 50 kHz")
    'a number with a unit is written in quotes: rate = "50 kHz"'
    """
    key, equals, value = (part.strip() for part in line.partition("#")[0].partition("="))
    if len(line) > _LONGEST_LINE:
        return ""
    if message.startswith(("Cannot declare", "Cannot overwrite", "Duplicate", "Cannot mutate")):
        return "the same name is given twice: rename or remove one of them"
    if '"' in line and line.count('"') % 2:
        return "a quote is missing"
    if equals and value.startswith("["):
        return 'a list is written as ["first", "second"]: look for a missing quote, comma or bracket, here or above'
    if equals and _NUMBER_AND_UNIT.fullmatch(value):
        return f'a number with a unit is written in quotes: {key} = "{value}"'
    if equals and _WORD.fullmatch(value):
        return f'a text is written in quotes: {key} = "{value}"'
    if not equals and "->" in line and '"' not in line:
        return 'a wire is a text in the list wires: wires = ["block.output -> block.input"]'
    if message.startswith("Unclosed array"):
        return "a list ends with ], with commas between its entries: look for a missing comma or bracket, here or above"
    if equals and not value:
        return f"the value is missing: {key} = ... and then a number, or a text in quotes"
    return 'a line gives a key its value, as in bits = 16 or kind = "Gain"'
