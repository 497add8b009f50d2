"""The line of every key in a TOML text, and the limits that a parser needs before it starts.

A parser of TOML gives values without places, and takes seconds on a small text of hostile shape (a dotted key of
thousands of parts, deep nesting). One pass over the tokens cures both: it never backtracks and stops at the first
thing beyond a limit. It does not judge the syntax; the parser does that.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.graphs.limits import DIGITS, ENTRIES, KEY_LENGTH, KEY_PARTS, NESTING

Path = tuple[str, ...]

_TOKEN = re.compile(
    r"(?P<space>[ \t\r]+)|(?P<newline>\n)|(?P<comment>#[^\n]*)"
    r'|(?P<long>"""(?:[^\\"]|\\.|"(?!""))*"{3,5}|\'\'\'(?:[^\']|\'(?!\'\'))*\'{3,5})'
    r'|(?P<text>"(?:[^"\\\n]|\\[^\n])*"|\'[^\'\n]*\')'
    r"|(?P<mark>[][{}=,.])"
    r"|(?P<bare>[^][{}=,.\s#\"']+)",
    re.DOTALL,
)


class Token(NamedTuple):
    kind: str
    text: str
    line: int


class LimitError(ValueError):
    """A text beyond a limit, with the line where it goes beyond."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.line = line


def locate_keys(text: str) -> dict[Path, int]:
    """Line of each table, key and array entry; entries are numbered from "0".

    Raises `LimitError` for nesting, keys, numbers or counts beyond `limits`.
    """
    return _Locator(list(_tokens(text))).lines


def _tokens(text: str) -> Iterator[Token]:
    at, line, depth = 0, 1, 0
    while at < len(text):
        found = _TOKEN.match(text, at)
        if found is None:
            return
        kind, piece = str(found.lastgroup), found[0]
        if kind == "bare" and len(piece) > DIGITS:
            raise LimitError(f"a word of {len(piece)} characters; at most {DIGITS} are read", line)
        if piece in ("[", "{"):
            depth += 1
            if depth > NESTING:
                raise LimitError(f"nested deeper than {NESTING} levels", line)
        elif piece in ("]", "}"):
            depth = max(depth - 1, 0)
        if kind not in ("space", "comment"):
            yield Token(kind, piece, line)
        line += piece.count("\n")
        at = found.end()


class _Locator:
    """A walk over the tokens; the nesting is limited before it begins."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens, self.at = tokens, 0
        self.lines: dict[Path, int] = {}
        self.counts: dict[Path, int] = {}
        table: Path = ()
        while self.at < len(self.tokens):
            if self._is("newline"):
                self.at += 1
            elif self._is("mark", "["):
                table = self._header()
            else:
                self._entry(table)

    def _is(self, kind: str, text: str = "") -> bool:
        return self.at < len(self.tokens) and self.tokens[self.at].kind == kind and text in ("", self.tokens[self.at].text)

    def _note(self, path: Path, line: int) -> None:
        self.lines.setdefault(path, line)
        if len(self.lines) > ENTRIES:
            raise LimitError(f"more than {ENTRIES} keys and entries", line)

    def _header(self) -> Path:
        line, brackets = self.tokens[self.at].line, 0
        while self._is("mark", "["):
            self.at += 1
            brackets += 1
        table = self._key()
        while self._is("mark", "]"):
            self.at += 1
        self._rest_of_line()
        if brackets > 1:
            index = self.counts[table] = self.counts.get(table, -1) + 1
            table = (*table, str(index))
        self._note(table, line)
        return table

    def _key(self) -> Path:
        parts: list[str] = []
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            if token.kind in ("bare", "text"):
                if len(parts) == KEY_PARTS:
                    raise LimitError(f"a key of more than {KEY_PARTS} parts", token.line)
                if len(token.text) > KEY_LENGTH + 2 and (token.kind == "bare" or self._is_key()):
                    raise LimitError(f"a name of more than {KEY_LENGTH} characters", token.line)
                parts.append(token.text.strip("\"'") if token.kind == "text" else token.text)
            elif not (token.kind == "mark" and token.text == "."):
                break
            self.at += 1
        return tuple(parts)

    def _is_key(self) -> bool:
        after = self.at + 1
        return after < len(self.tokens) and self.tokens[after].text in ("=", ".", "]")

    def _entry(self, table: Path) -> None:
        line, before = self.tokens[self.at].line, self.at
        path = table + self._key()
        if path != table:
            self._note(path, line)
        if self._is("mark", "="):
            self.at += 1
            self._value(path)
        self._rest_of_line()
        self.at += self.at == before

    def _value(self, path: Path) -> None:
        if self._is("mark", "["):
            self._entries(path, "]", keyed=False)
        elif self._is("mark", "{"):
            self._entries(path, "}", keyed=True)
        else:
            while self._is("bare") or self._is("text") or self._is("long") or self._is("mark", "."):
                self.at += 1

    def _entries(self, path: Path, end: str, keyed: bool) -> None:
        self.at += 1
        index = 0
        while self.at < len(self.tokens) and not self._is("mark", end):
            before = self.at
            if self._is("newline") or self._is("mark", ","):
                self.at += 1
                continue
            if keyed:
                inner = path + self._key()
                self._note(inner, self.tokens[min(before, len(self.tokens) - 1)].line)
                if self._is("mark", "="):
                    self.at += 1
                    self._value(inner)
            else:
                inner = (*path, str(index))
                index += 1
                self._note(inner, self.tokens[self.at].line)
                self._value(inner)
            self.at += self.at == before
        self.at += 1

    def _rest_of_line(self) -> None:
        while self.at < len(self.tokens) and not self._is("newline"):
            self.at += 1
