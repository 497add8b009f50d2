"""Generated source taken apart into statements, with the variables that each reads and writes."""

import ast
import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache

_RATE = re.compile(r"tick % \d+ == 0")


@dataclass(frozen=True)
class Statement:
    """A statement of a block of source, in its order."""

    lines: tuple[str, ...]
    guard: str  # condition on the tick alone, under which it is executed
    reads: frozenset[str]
    writes: frozenset[str]  # arrays that it may change among them
    surely: bool  # whether it writes them whenever it is executed
    straight: bool  # whether it is an assignment of numbers: neither loop nor branch nor array

    @property
    def names(self) -> frozenset[str]:
        """Every variable in it."""
        return self.reads | self.writes


def statements(lines: Iterable[str], arrays: Collection[str] = ()) -> list[Statement]:
    """The statements of some lines; what a rate guards is taken apart too.

    A function may change every array that it is given.

    >>> [(s.guard, sorted(s.reads), sorted(s.writes)) for s in statements(["if tick % 2 == 0:", "    y = f(x)"])]
    [('tick % 2 == 0', ['f', 'x'], ['y'])]
    """
    return list(_statements("\n".join(lines), frozenset(arrays)))


@lru_cache(maxsize=16)  # studies that differ in numbers have the same source
def _statements(source: str, arrays: frozenset[str]) -> tuple[Statement, ...]:
    return tuple(_taken_apart(source, arrays))


def _taken_apart(source: str, arrays: frozenset[str]) -> Iterator[Statement]:
    texts = source.split("\n")

    def made(node: ast.stmt, guard: str, indent: int) -> Statement:
        assert node.end_lineno is not None
        lines = tuple(text[indent:] for text in texts[node.lineno - 1 : node.end_lineno])
        return _statement(node, lines, guard, arrays)

    for node in ast.parse(source).body:
        if isinstance(node, ast.If) and not node.orelse and _RATE.fullmatch(ast.unparse(node.test)):
            yield from (made(inner, ast.unparse(node.test), 4) for inner in node.body)
        else:
            yield made(node, "", 0)


def _statement(node: ast.stmt, lines: tuple[str, ...], guard: str, arrays: frozenset[str]) -> Statement:
    reads, writes, looked_at = set[str](), set[str](), set[ast.AST]()
    todo: list[ast.AST] = [node]
    while todo:  # `ast.walk` takes several times as long, most of what a study would need to start
        part = todo.pop()
        if isinstance(part, ast.Name):
            name = part.id
            (writes if isinstance(part.ctx, ast.Store) else reads).add(name)
            if name in arrays and part not in looked_at:
                writes.add(name)
            continue
        if isinstance(part, ast.AugAssign) and isinstance(part.target, ast.Name):
            reads.add(part.target.id)
        elif isinstance(part, ast.Subscript) and isinstance(part.value, ast.Name):
            looked_at.add(part.value)
            if isinstance(part.ctx, ast.Store):
                writes.add(part.value.id)
        for field in part._fields:
            value = getattr(part, field)
            if isinstance(value, list):
                todo += value
            elif isinstance(value, ast.expr | ast.stmt):
                todo.append(value)
    plain = isinstance(node, ast.Assign | ast.AugAssign)
    straight = plain and arrays.isdisjoint(reads | writes)
    return Statement(lines, guard, frozenset(reads), frozenset(writes), plain, straight)
