"""Units of a block that are parameters: which of them to set so that a quantity fits."""

import re
from collections.abc import Iterator, Mapping

from proofmass.blocks.declaration.unit_expressions import UnitError, unit
from proofmass.blocks.declaration.units import named_unit, short_unit, split_quantity

_NAMES = re.compile(r"\{(\w+)\}")
_RATIO = re.compile(r"\(?\{(\w+)\}\)?/\(\{(\w+)\}\)")
_NONE = "1"  # of a plain number, which is what these parameters are unless they are set


def unit_to_set(template: str, value: object, texts: Mapping[str, object]) -> str:
    """Return a hint at the parameters to set, of those that a unit such as "{output_unit}/({input_unit})" names.

    >>> unit_to_set("{output_unit}/({input_unit})", "2 V/m", {"output_unit": "V", "input_unit": "1"})
    'set input_unit = "m"'
    >>> unit_to_set("{output_unit}/({input_unit})", "2 V/m", {"output_unit": "1", "input_unit": "1"})
    'set output_unit = "V" and input_unit = "m"'
    """
    try:
        symbol = split_quantity(str(value))[1] if isinstance(value, str) else ""
        wanted = unit(symbol) if symbol else None
        right = wanted is None or unit(_filled(template, texts)).exponents == wanted.exponents
    except UnitError:
        return ""
    if right:
        return ""
    ratio, above, below = _RATIO.fullmatch(template), *symbol.partition("/")[::2]
    if ratio and {str(texts[name]) for name in ratio.groups()} == {_NONE} and below and "/" not in below:
        return f'set {ratio[1]} = "{above}" and {ratio[2]} = "{below.strip("()")}"'
    choices = sorted(_choices(template, symbol, texts), key=lambda choice: (choice[2], choice[1]))
    if not choices or (choices[0][2] and _NAMES.fullmatch(template)):  # the unit that the block says is meant
        return ""
    name, needed, said = choices[0]
    return f'set {name} = "{needed}"' + (f", or give it in {short_unit(_filled(template, texts))}" if said else "")


def _choices(template: str, symbol: str, texts: Mapping[str, object]) -> Iterator[tuple[str, str, bool]]:
    """Yield each parameter with the unit it would need, and whether it says another one already."""
    for name in dict.fromkeys(_NAMES.findall(template)):
        rest = _filled(template, {**texts, name: _NONE})
        for expression in (f"({symbol})/({rest})", f"({rest})/({symbol})"):
            needed = named_unit(expression)
            if needed and unit(_filled(template, {**texts, name: needed})).exponents == unit(symbol).exponents:
                yield name, needed, str(texts[name]) != _NONE
                break


def _filled(template: str, texts: Mapping[str, object]) -> str:
    return _NAMES.sub(lambda found: str(texts[found[1]]), template)
