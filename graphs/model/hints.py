"""Words of hints: sizes of ports, keys that other tools call otherwise, what a TOML parser's complaint means."""

import math
import re
from collections.abc import Collection, Mapping

from proofmass.blocks.declaration.problem import did_you_mean

TWICE = ("Cannot declare", "Cannot overwrite", "Cannot mutate", "Duplicate")  # of a key given twice
_LONGEST_LINE = 400  # characters
_NUMBER_AND_UNIT = re.compile(r"[+-]?\.?\d.*[A-Za-zµμΩ%]")
_CURLY_QUOTES = "\u201c\u201d\u2018\u2019"
_WORD = re.compile(r"[A-Za-z_][\w ./-]*")
_ELSEWHERE: Mapping[str, tuple[str, ...]] = {  # a key, and what other tools call it
    "normal": ("gaussian", "gauss", "sigma", "std", "stddev", "standard_deviation"),
    "uniform": ("flat", "rectangular", "range", "half_width", "tolerance"),
    "lognormal": ("log_normal", "logn"),
    "triangular": ("triangle",),
    "truncated": ("truncate", "cutoff", "clip", "cut"),
    "values": ("choices", "discrete", "list", "options"),
    "ramp": ("linear", "slope", "rate"),
    "random_walk": ("walk", "brownian", "wiener"),
    "logarithmic": ("log", "logarithm"),
    "arrhenius": ("thermal", "activation"),
    "spread": ("distributions", "variation", "tolerances"),
    "drift": ("ageing", "aging"),
    "epochs": ("ages", "times"),
    "runs": ("n", "samples", "count", "trials", "sensors"),
    "from": ("after", "since", "start", "begin"),
    "until": ("before", "end", "to", "stop"),
    "at_least": ("min", "minimum", "lower", "low"),
    "at_most": ("max", "maximum", "upper", "high"),
}


def counted(shape: tuple[int, ...]) -> str:
    """The shape of a port in words.

    >>> counted(()), counted((16,))
    ('a single value', 'a vector of 16 entries')
    """
    return f"a vector of {math.prod(shape)} entries" if shape else "a single value"


def syntax_hint(message: str, line: str) -> str:
    """Hint at what to write instead of a line that is not TOML.

    >>> syntax_hint("Expected newline", "rate = 50 kHz")
    'a number with a unit is written in quotes: rate = "50 kHz"'
    """
    key, equals, value = (part.strip() for part in line.partition("#")[0].partition("="))
    if message.startswith(TWICE):
        return "the same name is given twice: rename or remove one of them"
    if len(line) > _LONGEST_LINE:
        return ""
    if any(quote in line for quote in _CURLY_QUOTES):
        return 'the quotes are curly: write straight ones, as in kind = "Gain"'
    if "Unescaped '\\'" in message or "escape" in message:
        return "in a text in quotes a backslash needs a second one; in names of files write / instead"
    if equals and "//" in line.partition('"')[0]:
        return "a comment begins with #"
    if line.count('"') % 2:
        return "a quote is missing"
    if equals and value.startswith("["):
        return 'a list is written as ["first", "second"]: look for a missing quote, comma or bracket, here or above'
    if equals and value in ("True", "False"):
        return f"TOML writes true and false in lower case: {key} = {value.lower()}"
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


def key_hint(key: str, keys: Collection[str], beside: Collection[str] = ()) -> str:
    """Return a hint at the key that was meant: the one that other tools call so, or the nearest.

    >>> key_hint("gaussian", ["normal", "uniform"]), key_hint("unifrom", ["normal", "uniform"])
    ('here that is normal', 'did you mean uniform?')
    """
    same = known_as(key, keys)
    return f"here that is {same}" if same else did_you_mean(key, keys, "the keys", beside)


def known_as(key: str, keys: Collection[str]) -> str:
    """Return the key that other tools call so, or ""."""
    return next((own for own, others in _ELSEWHERE.items() if own in keys and key.lower() in others), "")
