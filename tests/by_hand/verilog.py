"""A module of Verilog run by the rules of IEEE 1364-2001 on sizes and signs, clock by clock: no tool has to be there.

It knows declarations, assignments and one clock, and expressions in the form in which they are written, one or two
operators a line. Numbers are patterns of bits; what is signed and how wide follows from the text alone.
"""

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

_TOKEN = re.compile(r"\s*(\d+'s?[dhb][0-9a-f]+|\$signed|\d+|\w+|<<<|>>>|<=|>=|==|!=|&&|[-+*&|^<>?:!(){}\[\],])")
_LEVELS = (("&&",), ("|",), ("^",), ("&",), ("==", "!="), ("<", "<=", ">", ">="), ("<<<", ">>>"), ("+", "-"), ("*",))
_DECLARED = re.compile(r"(input wire|output wire|wire|reg)( signed)?(?: \[(\d+):0\])? (\w+)")


class Kind(NamedTuple):
    """Of an expression: its own width, and whether it is signed."""

    width: int
    signed: bool


class ModuleByHand:
    """The last module of a text, with those that it joins; registers hold zero until a clock with reset."""

    def __init__(self, text: str, above: Mapping[str, str] | None = None) -> None:
        own = re.split(r"(?<=endmodule)\n", text.strip())
        texts = dict(above or {}) | {re.search(r"^module (\w+)", each, re.M)[1]: each for each in own}  # type: ignore[index]
        self.kinds: dict[str, Kind] = {}
        self.inputs: list[str] = []
        self.outputs: list[str] = []
        self.assigned: list[tuple[str, Any]] = []
        self.moves: list[tuple[list[Any], str, Any]] = []  # conditions, register, value
        self.parts: list[tuple[ModuleByHand, dict[str, Any]]] = []  # with what each port is joined to
        conditions: list[tuple[int, list[Any]]] = []  # by indent
        for line in own[-1].splitlines():
            code = line.partition("//")[0].rstrip().removesuffix(",")
            declared = _DECLARED.search(code)
            if declared:
                self._declare(*declared.groups())
            _, equals, value = code.partition(" = ")
            if equals:
                name = code.partition(" = ")[0].split()[-1]
                self.assigned.append((name, _parsed(value.removesuffix(";"))))
            part = re.fullmatch(r"    (\w+) \w+ \(", code)
            joined = re.fullmatch(r" +\.(\w+)\((.*)\)", code)
            if part:
                self.parts.append((ModuleByHand(texts[part[1]], texts), {}))
            elif joined:
                self.parts[-1][1][joined[1]] = _parsed(joined[2])
            indent = len(code) - len(code.lstrip())
            conditions = [each for each in conditions if each[0] < indent]
            before = [one for _, each in conditions for one in each]
            move = re.fullmatch(r"((?:end )?else )?(?:if \((.*?)\) )?(\w+) <= (.*);", code.strip())
            branch = re.fullmatch(r"(end else )?if \((\w+)\) begin", code.strip())
            refused = [("!", ("name", "reset"))]
            if branch:
                conditions.append((indent, [*(refused if branch[1] else []), ("name", branch[2])]))
            elif move:
                own = [_parsed(move[2])] if move[2] else []
                self.moves.append(([*before, *(refused if move[1] else []), *own], move[3], _parsed(move[4])))
        self.held = {name: 0 for _, name, _ in self.moves}

    def _declare(self, what: str, signed: str | None, high: str | None, name: str) -> None:
        self.kinds[name] = Kind(int(high or 0) + 1, bool(signed))
        if what == "input wire":
            self.inputs.append(name)
        elif what == "output wire":
            self.outputs.append(name)

    def clock(self, values: Mapping[str, int], *, reset: int = 0, enable: int = 1) -> dict[str, int]:
        """The outputs before a clock, as numbers; then the registers take what they are given."""
        now = self.settled({"reset": reset, "enable": enable, **values})
        self.move(now)
        return {name: self.number(now[name], self.kinds[name]) for name in self.outputs}

    def settled(self, values: Mapping[str, int]) -> dict[str, int]:
        """The bits of every wire, once nothing changes any more."""
        now = dict.fromkeys(self.kinds, 0) | self.held
        now |= {name: value & _ones(self._kind(("name", name)).width) for name, value in values.items()}
        while True:
            before = dict(now)
            for name, value in self.assigned:
                now[name] = self._assigned(name, value, now)
            for part, joined in self.parts:
                inside = part.settled(self._given(part, joined, now))
                now |= {joined[name][1]: inside[name] for name in part.outputs if name in joined}
            if now == before or not self.parts:
                return now

    def move(self, now: Mapping[str, int]) -> None:
        """A clock in which wires have these bits."""
        for part, joined in self.parts:
            part.move(part.settled(self._given(part, joined, now)))
        held = {}
        for conditions, name, value in self.moves:
            if all(self._value(each, self._kind(each).width, False, now) for each in conditions):
                held[name] = self._assigned(name, value, now)
        self.held |= held

    def _given(self, part: "ModuleByHand", joined: Mapping[str, Any], now: Mapping[str, int]) -> dict[str, int]:
        """The bits at the inputs of a part, by its names."""
        names = [name for name in joined if name not in part.outputs and name != "clock"]
        return {name: self._value(joined[name], *self._kind(joined[name]), now) for name in names}

    def _assigned(self, name: str, value: Any, now: Mapping[str, int]) -> int:
        own = self._kind(value)
        width = max(own.width, self.kinds[name].width)
        return self._value(value, width, own.signed, now) & _ones(self.kinds[name].width)

    def number(self, bits: int, kind: Kind) -> int:
        return bits - (1 << kind.width) if kind.signed and bits >> (kind.width - 1) else bits

    def _kind(self, tree: Any) -> Kind:
        what, *parts = tree
        if what == "literal":
            return Kind(parts[0], parts[1])
        if what == "name":
            return self.kinds.get(parts[0], Kind(1, False))  # reset and enable of a module without registers
        if what == "bits":
            return Kind(parts[1] - parts[2] + 1, False)
        if what == "join":
            return Kind(sum(self._kind(part).width for part in parts[0]), False)
        if what == "$signed":
            return Kind(self._kind(parts[0]).width, True)
        if what in ("<", "<=", ">", ">=", "==", "!=", "!", "&&"):
            return Kind(1, False)
        if what in ("<<<", ">>>", "negate"):
            return self._kind(parts[0])
        a, b = map(self._kind, parts[-2:])
        return Kind(max(a.width, b.width), a.signed and b.signed)

    def _value(self, tree: Any, width: int, signed: bool, now: Mapping[str, int]) -> int:
        """The bits of an expression whose context has this width and sign."""
        what, *parts = tree
        own = self._kind(tree)
        if what in ("literal", "name", "bits", "join", "$signed"):
            bits = self._leaf(what, parts, now)
            negative = signed and bits >> (own.width - 1)
            return (bits - (1 << own.width) if negative else bits) & _ones(width)
        if what == "!":
            return int(self._value(parts[0], self._kind(parts[0]).width, False, now) == 0)
        if what == "&&":
            return int(all(self._value(part, self._kind(part).width, False, now) for part in parts))
        if what in ("<", "<=", ">", ">=", "==", "!="):
            kinds = [self._kind(part) for part in parts]
            inner = Kind(max(kind.width for kind in kinds), all(kind.signed for kind in kinds))
            a, b = (self.number(self._value(part, *inner, now), inner) for part in parts)
            return int({"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[what])
        if what == "?":
            test, chosen, otherwise = parts
            taken = chosen if self._value(test, self._kind(test).width, False, now) else otherwise
            return self._value(taken, width, signed, now)
        a = self._value(parts[0], width, signed, now)
        if what == "negate":
            return -a & _ones(width)
        if what in ("<<<", ">>>"):
            places = self._value(parts[1], self._kind(parts[1]).width, False, now)
            number = self.number(a, Kind(width, signed))
            return (number << places if what == "<<<" else number >> places) & _ones(width)
        b = self._value(parts[1], width, signed, now)
        return {"+": a + b, "-": a - b, "*": a * b, "&": a & b, "|": a | b, "^": a ^ b}[what] & _ones(width)

    def _leaf(self, what: str, parts: list[Any], now: Mapping[str, int]) -> int:
        if what == "literal":
            return int(parts[2])
        if what == "name":
            return now[parts[0]]
        if what == "bits":
            return (now[parts[0]] >> parts[2]) & _ones(parts[1] - parts[2] + 1)
        if what == "$signed":
            return self._value(parts[0], self._kind(parts[0]).width, False, now)
        bits = 0
        for part in parts[0]:
            width = self._kind(part).width
            bits = (bits << width) | self._value(part, width, False, now)
        return bits


def _ones(width: int) -> int:
    return (1 << width) - 1


def _parsed(text: str) -> Any:
    tokens = _TOKEN.findall(text)
    assert "".join(tokens) == re.sub(r"\s", "", text), f"no expression that is known here: {text}"
    tree = _ternary(tokens)
    assert not tokens, f"{tokens} left of {text}"
    return tree


def _ternary(tokens: list[str]) -> Any:
    test = _binary(tokens, 0)
    if tokens[:1] != ["?"]:
        return test
    tokens.pop(0)
    chosen = _ternary(tokens)
    assert tokens.pop(0) == ":"
    return ("?", test, chosen, _ternary(tokens))


def _binary(tokens: list[str], level: int) -> Any:
    if level == len(_LEVELS):
        return _unary(tokens)
    tree = _binary(tokens, level + 1)
    while tokens and tokens[0] in _LEVELS[level]:
        tree = (tokens.pop(0), tree, _binary(tokens, level + 1))
    return tree


def _unary(tokens: list[str]) -> Any:
    token = tokens.pop(0)
    if token in "-!":
        return ("negate" if token == "-" else "!", _unary(tokens))
    if token in ("(", "$signed"):
        if token == "$signed":
            tokens.pop(0)
        tree = _ternary(tokens)
        assert tokens.pop(0) == ")"
        return ("$signed", tree) if token == "$signed" else tree
    if token == "{":
        parts = [_ternary(tokens)]
        while tokens.pop(0) == ",":
            parts.append(_ternary(tokens))
        return ("join", parts)
    if "'" in token:
        width, sign, base, digits = re.fullmatch(r"(\d+)'(s?)([dhb])(\w+)", token).groups()  # type: ignore[union-attr]
        return ("literal", int(width), bool(sign), int(digits, {"d": 10, "h": 16, "b": 2}[base]))
    if token.isdigit():
        return ("literal", 32, True, int(token))
    if tokens[:1] == ["["]:
        tokens.pop(0)
        high = int(tokens.pop(0))
        low = high
        if tokens.pop(0) == ":":
            low = int(tokens.pop(0))
            tokens.pop(0)
        return ("bits", token, high, low)
    return ("name", token)
