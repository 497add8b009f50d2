"""The grammar of formulas. Python evaluates nothing of it; length and depth are limited.

    sum      = product { ("+" | "-") product }
    product  = signed { ("*" | "/") signed }
    signed   = { "+" | "-" } power
    power    = atom [ ("^" | "**") signed ]
    atom     = number { unit } | name | function "(" sum { "," sum } ")" | "(" sum ")"

A unit that follows a number belongs to it: `1 / 2 ms` is 500 Hz.
"""

import math
import re
from fractions import Fraction
from functools import lru_cache

from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import is_unit, typed, unit
from proofmass.blocks.declaration.units import convert_exactly, not_vanishing
from proofmass.graphs.formulas.operations import FUNCTIONS, OPERATIONS
from proofmass.graphs.formulas.tree import LARGEST_WHOLE_POWER, Apply, Name, Number, Raised, Tree, evaluated, names_of

LENGTH = 400  # characters
DEPTH = 24  # brackets, signs and powers inside each other
_TOKEN = re.compile(
    r"\s*+(?:(?P<number>(?:\d[\d_]*+\.?[\d_]*+|\.\d[\d_]*+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[A-Za-zµμΩ_][A-Za-z0-9_µμΩ]*+|%)"
    r"|(?P<mark>\*\*|[-+*/^(),]))",
    re.ASCII,
)
_DOTTED = re.compile(r"[A-Za-z_]\w*(\.\w+)+", re.ASCII)
_EXAMPLE = 'write it as in "= 2 * pi * f0 / q"'


@lru_cache(maxsize=4096)
def parsed(text: str) -> Tree:
    """Return the tree of a formula, without its equals sign; raises `Refusal`."""
    if len(text) > LENGTH:
        raise Refusal(f"a formula of over {LENGTH} characters", "name its parts in [values]")
    return _Parser(_tokens(typed(text))).whole()


def _tokens(text: str) -> list[tuple[str, str]]:
    tokens, at = [], 0
    while text[at:].strip():
        token = _TOKEN.match(text, at)
        if token is None:
            raise _unreadable(text, at)
        tokens.append((str(token.lastgroup), token[token.lastindex or 0]))
        at = token.end()
    return tokens


def _unreadable(text: str, at: int) -> Refusal:
    rest = text[at:].strip()
    if rest[0] == ".":
        place = len(text.rstrip()) - len(rest)
        dotted = next((found for found in _DOTTED.finditer(text) if found.start() < place < found.end()), None)
        if dotted is not None:
            short = dotted[0].rpartition(".")[2][:30]
            hint = f"name the number in [values], {short} = ..., and write = {short} in both places"
            return Refusal(f"a formula knows values, not parameters: {shown(dotted[0], 60)[1:-1]}", hint)
    if rest[0] in "\"'":
        return Refusal("a formula has no texts in it", _EXAMPLE)
    if rest[0] in "=<>!&|~?:":
        return Refusal(f"a formula has no {shown(rest[0])[1:-1]}", _EXAMPLE)
    return Refusal(f"cannot be read at {shown(rest, 30)}", _EXAMPLE)


class _Parser:
    """Descends through the grammar; `depth` is that of brackets, signs and powers."""

    def __init__(self, tokens: list[tuple[str, str]]) -> None:
        self.tokens, self.at, self.depth = [*tokens, ("end", "")], 0, 0

    def whole(self) -> Tree:
        if len(self.tokens) == 1:
            raise Refusal("a formula without anything in it", _EXAMPLE)
        tree = self._sum()
        kind, text = self.tokens[self.at]
        if text == ")":
            raise Refusal("a bracket is closed that was not opened")
        if text == ",":
            raise Refusal("a comma stands outside the brackets of a function", "write decimals with a point")
        if kind != "end":
            raise Refusal(f"an operator is missing before {shown(text, 30)[1:-1]}", "write a product with *")
        return tree

    def _mark(self, *marks: str) -> str:
        kind, text = self.tokens[self.at]
        if kind == "mark" and text in marks:
            self.at += 1
            return text
        return ""

    def _sum(self) -> Tree:
        tree = self._product()
        while mark := self._mark("+", "-"):
            tree = Apply(mark, (tree, self._product()))
        return tree

    def _product(self) -> Tree:
        tree = self._signed()
        while mark := self._mark("*", "/"):
            begin = self.at
            tree = Apply(mark, (tree, self._signed()))
            if mark == "/":
                self._ended(begin)
        return tree

    def _ended(self, begin: int) -> None:
        """Refuse a divisor such as 9.8 m of a formula that goes on with /s^2: a reader takes 9.8 m/s^2 for one."""
        while self.tokens[begin][1] in ("+", "-"):
            begin += 1
        (kind, _), (unit_kind, _) = self.tokens[begin : begin + 2]
        (_, mark), *rest = self.tokens[self.at : self.at + 4]
        if kind != "number" or unit_kind != "name" or mark not in ("*", "/"):
            return
        words = [text for _, text in rest]
        name = words[2] if words[:2] == ["sqrt", "("] else words[0]
        if rest[0][0] == "name" and is_unit(name):
            divisor = " ".join(text for _, text in self.tokens[begin : self.at])
            message = f"after / the quantity {shown(divisor, 30)[1:-1]} ends before {mark} {shown(name, 30)[1:-1]}"
            raise Refusal(message, "put a quantity of several units into brackets, as in a / (9.8 m/s^2)")

    def _signed(self) -> Tree:
        self._deeper()
        mark = self._mark("+", "-")
        tree = self._signed() if mark else self._power()
        self.depth -= 1
        return Apply("negative", (tree,)) if mark == "-" else tree

    def _power(self) -> Tree:
        base = self._atom()
        return _raised(base, self._signed()) if self._mark("^", "**") else base

    def _atom(self) -> Tree:
        kind, text = self.tokens[self.at]
        self.at += 1
        if kind == "number":
            return self._quantity(text)
        if kind == "name":
            return self._call(text) if self._mark("(") else Name(text)
        if text == "(":
            tree = self._sum()
            self._close("(")
            return tree
        if kind == "end":
            raise Refusal("the formula ends too early", _EXAMPLE)
        raise Refusal(f"a number or a name is missing before {text}", _EXAMPLE)

    def _quantity(self, text: str) -> Tree:
        """A number with its units, rounded once: units bind closer than any operator."""
        units = []
        while self.tokens[self.at][0] == "name" and self.tokens[self.at + 1][1] != "(":
            units.append(self.tokens[self.at][1] + self._unit_power())
        name = "*".join(units) or "1"
        known = unit(name)  # refuses an unknown one, offers the nearest name
        return Number(_float(text, known.factor), known.exponents, name)

    def _unit_power(self) -> str:
        """The exponent of a unit, with its sign, as `unit` reads it."""
        self.at += 1
        if not self._mark("^", "**"):
            return ""
        sign, (kind, text) = self._mark("+", "-"), self.tokens[self.at]
        self.at += 1
        if kind != "number":
            raise Refusal("the exponent of a unit must be a number such as 2 or -1")
        return f"^{sign}{text}"

    def _call(self, name: str) -> Tree:
        if name not in FUNCTIONS:
            hint = did_you_mean(name, FUNCTIONS, "the functions")
            raise Refusal(f"there is no function {shown(name, 30)[1:-1]}", hint)
        arguments = [self._sum()]
        while self._mark(","):
            arguments.append(self._sum())
        self._close(name)
        wanted = OPERATIONS[name].arity
        if len(arguments) != wanted:
            raise Refusal(f"{name} takes {wanted} argument{'s' * (wanted > 1)}, not {len(arguments)}")
        return Apply(name, tuple(arguments))

    def _close(self, what: str) -> None:
        if not self._mark(")"):
            raise Refusal(f"the bracket of {what} is not closed" if what != "(" else "a bracket is not closed")

    def _deeper(self) -> None:
        self.depth += 1
        if self.depth > DEPTH:
            raise Refusal(f"a formula nested deeper than {DEPTH} levels", "name its parts in [values]")


def _raised(base: Tree, exponent: Tree) -> Tree:
    if not names_of(exponent):
        number = evaluated(exponent, {})
        if math.isfinite(number) and abs(number) <= LARGEST_WHOLE_POWER and number == round(number):
            return Raised(base, round(number))
    return Apply("power", (base, exponent))


def _float(text: str, factor: Fraction) -> float:
    """Return a number times a factor, rounded once."""
    try:
        return float(not_vanishing(convert_exactly(text, "1") * factor))
    except OverflowError:
        raise Refusal("holds a number that is too large") from None
