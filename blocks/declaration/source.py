"""The syntax tree of a function, from the file that it was loaded from and no other text."""

import __future__

import ast
import inspect
import types
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache, reduce
from operator import or_
from typing import Any
from weakref import WeakKeyDictionary

_FUTURES = reduce(or_, (getattr(__future__, name).compiler_flag for name in __future__.all_feature_names))
_loaded: dict[str, str] = {}
_made: "WeakKeyDictionary[types.FunctionType, ast.FunctionDef]" = WeakKeyDictionary()


class SourceError(ValueError):
    """The source of a function is not available; says why."""


def tree_of(function: types.FunctionType) -> ast.FunctionDef:
    """The definition of a function; raises `SourceError` where its file is not there, or is no
    longer the one that was loaded."""
    if function in _made:
        return _made[function]
    code = function.__code__
    try:
        text = _loaded.get(code.co_filename) or "".join(inspect.findsource(function)[0])
        definition = _alone(text, code) or _definitions(text, code.co_filename).get((code.co_firstlineno, code.co_name))
    except (OSError, TypeError, SyntaxError):
        raise SourceError("its source cannot be read") from None
    if definition is None and code.co_name == "<lambda>":
        raise SourceError("its line has several lambdas, or its file has changed since it was loaded")
    if definition is None or not _same(definition[1], code):
        raise SourceError("its file has changed since it was loaded")
    return definition[0]


def define(tree: ast.FunctionDef, file: str, namespace: dict[str, Any]) -> types.FunctionType:
    """The function of a tree that was made at run time; its source is that tree."""
    module = ast.fix_missing_locations(ast.Module([tree], []))
    exec(compile(module, file, "exec"), namespace)
    function: types.FunctionType = namespace[tree.name]
    _made[function] = tree
    return function


def remember(file: str, text: str) -> None:
    """Keep the text from which a file was loaded, even if the file changes."""
    _loaded[file] = text


Definition = tuple[ast.FunctionDef, types.CodeType]


def _alone(text: str, code: types.CodeType) -> Definition | None:
    """The definition of a function from its own lines, which takes a tenth of reading the file that it is in.

    None where these lines alone do not make the same code, as those of a function within a function
    may.
    """
    lines = _lines(text)
    first, last = code.co_firstlineno, max(_last_line(code), code.co_firstlineno)
    if last > len(lines):
        return None
    indent = _indent(lines[first - 1])
    while last < len(lines) and (not lines[last].strip() or _indent(lines[last]) > indent):
        last += 1
    above = ["\n"] * (first - 1) if not indent else ["\n"] * (first - 2) + ["if True:\n"]
    own = "".join([*above, *lines[first - 1 : last]])
    try:
        top = ast.parse(own, code.co_filename).body
        module_code = compile(own, code.co_filename, "exec", code.co_flags & _FUTURES, dont_inherit=True)
    except SyntaxError:
        return None
    own_code = next((each for each in _codes(module_code) if each.co_name == code.co_name), None)
    match top:
        case [ast.FunctionDef() as function] | [ast.If(body=[ast.FunctionDef() as function])]:
            return (function, own_code) if own_code is not None and _same(own_code, code) else None
    return None


@lru_cache(maxsize=64)
def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _last_line(code: types.CodeType) -> int:
    """The last line that any instruction of a function comes from."""
    own = max((end or 0 for _, end, _, _ in code.co_positions()), default=0)
    return max([own, *(_last_line(each) for each in code.co_consts if isinstance(each, types.CodeType))])


@lru_cache(maxsize=64)
def _definitions(text: str, file: str) -> dict[tuple[int, str], Definition]:
    """Every function of a file by its first line and name."""
    tree = ast.parse(text, file)
    codes = {(code.co_firstlineno, code.co_name): code for code in _codes(compile(text, file, "exec"))}
    definitions = dict[tuple[int, str], Definition]()
    lambdas = [node for node in ast.walk(tree) if isinstance(node, ast.Lambda)]
    alone = Counter(node.lineno for node in lambdas)
    for each in lambdas:
        if alone[each.lineno] == 1 and (each.lineno, "<lambda>") in codes:
            definitions[each.lineno, "<lambda>"] = _as_definition(each), codes[each.lineno, "<lambda>"]
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            if (first, node.name) in codes:
                definitions[first, node.name] = node, codes[first, node.name]
    return definitions


def _as_definition(node: ast.Lambda) -> ast.FunctionDef:
    returned = ast.copy_location(ast.Return(node.body), node.body)
    return ast.copy_location(ast.FunctionDef("function", node.args, [returned], [], None), node)


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield constant
            yield from _codes(constant)


def _same(first: types.CodeType, second: types.CodeType) -> bool:
    return bool(_content(first) == _content(second))


def _content(code: types.CodeType) -> Any:
    """Return what a code object does; without texts of assertions, which test tools rewrite."""
    constants = [
        sorted(map(repr, each))
        if isinstance(each, frozenset)
        else _content(each)
        if isinstance(each, types.CodeType)
        else repr(each)
        for each in code.co_consts
    ]
    return code.co_code, code.co_names, code.co_varnames, code.co_freevars, constants
