"""Names of a function: those that stand for one value each, and variables that are set again."""

import ast
from collections.abc import Iterator

ScopePlace = tuple[int, ...]  # of a list of statements within those that it lies in


def changing(tree: ast.FunctionDef) -> frozenset[str]:
    """Names that need a variable: set more than once, or read where they may not have been set.

    >>> tree = ast.parse("def f(a):\\n b = a\\n if a:\\n  c = b\\n  a = c\\n return a").body[0]
    >>> sorted(changing(tree))
    ['a']
    """
    arguments = (*tree.args.posonlyargs, *tree.args.args, *tree.args.kwonlyargs)
    stored: dict[str, list[ScopePlace]] = {argument.arg: [()] for argument in arguments}
    read: dict[str, list[ScopePlace]] = {}
    for name, place, stores in _uses(tree.body, (), iter(range(1, 1 << 30))):
        (stored if stores else read).setdefault(name, []).append(place)
    return frozenset(
        name
        for name, places in stored.items()
        if len(places) > 1 or any(reader[: len(places[0])] != places[0] for reader in read.get(name, ()))
    )


def _uses(body: list[ast.stmt], place: ScopePlace, numbers: Iterator[int]) -> Iterator[tuple[str, ScopePlace, bool]]:
    """Names that statements use, where, and whether they are set there."""
    for statement in body:
        inner = {name: value for name, value in ast.iter_fields(statement) if _is_body(value)}
        for name, value in ast.iter_fields(statement):
            if name in inner:
                own = (*place, next(numbers))
                if name == "body" and isinstance(statement, ast.For):
                    yield from _names(statement.target, own)
                yield from _uses(value, own, numbers)
            elif not (isinstance(statement, ast.For) and name == "target"):
                for part in value if isinstance(value, list) else [value]:
                    if isinstance(part, ast.AST):
                        yield from _names(part, place)
        if isinstance(statement, ast.AugAssign) and isinstance(statement.target, ast.Name):
            yield statement.target.id, place, False


def _is_body(value: object) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], ast.stmt)


def _names(node: ast.AST, place: ScopePlace) -> Iterator[tuple[str, ScopePlace, bool]]:
    for part in ast.walk(node):
        if isinstance(part, ast.Name):
            yield part.id, place, isinstance(part.ctx, ast.Store)
