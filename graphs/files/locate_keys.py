"""The line of every key in a TOML text, and the limits that a parser needs before it starts.

A TOML parser returns values without places, and takes seconds on a small text of hostile shape (a
dotted key of thousands of parts, deep nesting). One pass over the tokens cures both. It never
backtracks, and stops at the first token that exceeds a limit or cannot be TOML. It does not judge
the syntax; the parser does that.
"""

import re
import tomllib
from collections.abc import Iterator

from proofmass.graphs.model.limits import ESCAPES, KEY_LENGTH, KEY_PARTS, NESTING, NUMBER_LENGTH, WORDS

KeyPath = tuple[str, ...]
Token = tuple[str, str, int]  # kind, text and line; the kind of a mark is the mark itself

# Possessive quantifiers (*+) never backtrack: the time grows with the length of the text alone. Those of groups are
# plain, since Python up to 3.11.4 matches possessive ones wrongly: their alternatives begin with other characters.
_TOKEN = re.compile(
    r"[ \t\r]*+(?:#[^\n]*+)?"
    r"(?:(?P<newline>\n[ \t\r\n]*+)"
    r'|(?P<long>"""(?:[^\\"]++|\\.|"(?!""))*"{3,5}+|\'\'\'(?:[^\']++|\'(?!\'\'))*\'{3,5}+)'
    r'|(?P<text>"(?!"")(?:[^"\\\n]++|\\[^\n])*"|\'(?!\'\')[^\'\n]*+\')'
    r"|(?P<mark>[][{}=,.])"
    r"|(?P<bare>[^][{}=,.\s#\"']++))",
    re.DOTALL,
)


class LimitError(ValueError):
    """A text exceeds a limit; holds the line."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.line = line


def locate_keys(text: str) -> dict[KeyPath, int]:
    """Line of each table, key and array entry; entries are numbered from "0".

    Raises `LimitError` for nesting, keys, numbers or counts beyond `limits`.
    """
    if text.count("\\") > ESCAPES:
        raise LimitError(f"more than {ESCAPES} backslashes", 1 + text.count("\n", 0, text.index("\\")))
    return _Locator(list(_tokens(text))).lines


def repeated_key(text: str, line: int) -> tuple[KeyPath, int] | None:
    r"""Return the key or table that is declared in a line and was before, and where it was; None if none is.

    >>> repeated_key("[adc]\nbits = 16\nbits = 12", 3)
    (('adc', 'bits'), 2)
    """
    locator = _Locator(list(_tokens(text)))
    path = locator.again.get(line)
    return None if path is None else (path, locator.lines[path])


def _tokens(text: str) -> Iterator[Token]:
    at, line, depth, words = 0, 1, 0, 0
    match = _TOKEN.match
    while found := match(text, at):
        kind, piece, at = found.lastgroup or "", found[found.lastindex or 0], found.end()
        words += 1
        if words > WORDS:
            raise LimitError(f"more than {WORDS} words", line)
        if kind == "mark":
            yield piece, piece, line
            if piece in "[{":
                depth += 1
                if depth > NESTING:
                    raise LimitError(f"nested deeper than {NESTING} levels", line)
            elif piece in "]}":
                depth = max(depth - 1, 0)
            continue
        if kind == "bare" and len(piece) > NUMBER_LENGTH:
            raise LimitError(f"a word of {len(piece)} characters; at most {NUMBER_LENGTH} are read", line)
        yield kind, piece, line
        if kind in ("newline", "long"):
            line += piece.count("\n")


class _Locator:
    """A walk over the tokens; the nesting is limited before it begins."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens = [*tokens, ("end", "", tokens[-1][2] if tokens else 1)]
        self.at = 0
        self.lines: dict[KeyPath, int] = {}
        self.again: dict[int, KeyPath] = {}  # by line, keys and tables that were there before
        self.last: dict[KeyPath, int] = {}  # index of the last table of each array of tables
        table: KeyPath = ()
        while not self._is("end"):
            if self._is("newline"):
                self.at += 1
            elif self._is("["):
                table = self._header()
            else:
                self._pair(table)
                self._rest_of_line()

    def _is(self, *kinds: str) -> bool:
        return self.tokens[self.at][0] in kinds

    def _line(self) -> int:
        return self.tokens[self.at][2]

    def _note(self, path: KeyPath, line: int) -> None:
        """The line of a path, and of every table above it that is named here first."""
        if path in self.lines:
            self.again[line] = path
        while path and path not in self.lines:
            self.lines[path] = line
            path = path[:-1]

    def _header(self) -> KeyPath:
        line, brackets = self._line(), 0
        while self._is("["):
            self.at += 1
            brackets += 1
        table: KeyPath = ()
        parts = self._key()
        for part in parts[:-1]:
            table = (*table, part)
            if table in self.last:
                table = (*table, str(self.last[table]))
        table += parts[-1:]
        if brackets > 1:
            self.last[table] = self.last.get(table, -1) + 1
            table = (*table, str(self.last[table]))
        self._note(table, line)
        self._rest_of_line()
        return table

    def _key(self) -> KeyPath:
        parts: list[str] = []
        while self._is("bare", "text"):
            kind, text, line = self.tokens[self.at]
            if len(parts) == KEY_PARTS:
                raise LimitError(f"a key of more than {KEY_PARTS} parts", line)
            name = _unquoted(text) if kind == "text" else text
            if len(name) > KEY_LENGTH:
                raise LimitError(f"a name of more than {KEY_LENGTH} characters", line)
            parts.append(name)
            self.at += 1
            if not self._is("."):
                break
            self.at += 1
        return tuple(parts)

    def _pair(self, table: KeyPath) -> None:
        line = self._line()
        path = table + self._key()
        if path != table:
            self._note(path, line)
        if self._is("="):
            self.at += 1
            self._value(path)

    def _value(self, path: KeyPath) -> None:
        if self._is("["):
            self._entries(path, "]")
        elif self._is("{"):
            self._entries(path, "}")
        else:
            while self._is("bare", "text", "long", "."):
                self.at += 1

    def _entries(self, path: KeyPath, end: str) -> None:
        """An array, whose entries are numbered, or an inline table, whose entries have keys."""
        self.at += 1
        index = 0
        while not self._is(end, "end"):
            before = self.at
            if self._is("newline", ","):
                self.at += 1
            elif end == "}":
                self._pair(path)
            else:
                inner = (*path, str(index))
                index += 1
                self._note(inner, self._line())
                self._value(inner)
            self.at += self.at == before
        self.at += self._is(end)

    def _rest_of_line(self) -> None:
        while not self._is("newline", "end"):
            self.at += 1


def _unquoted(text: str) -> str:
    """The name that a quoted key stands for."""
    if "\\" in text:
        try:
            return str(tomllib.loads(f"key = {text}")["key"])
        except ValueError:
            pass
    return text[1:-1]
