"""Python functions lowered from their syntax trees into functions of a program; types follow from the arguments.

A function is lowered once for each kind of arguments, and again if a number or function that it
reads from outside has changed. What cannot be lowered is refused with its line.
"""

import ast
import hashlib
import inspect
import types
from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any, NamedTuple

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.source import SourceError, tree_of
from proofmass.blocks.language.refusals import RefusedError, problem_at, refuse
from proofmass.blocks.language.scope import unchanged
from proofmass.blocks.language.values import annotated
from proofmass.runner.program.build import Builder, parameters_like
from proofmass.runner.program.form import TRUTH, Function, Kind, Operand, Program
from proofmass.runner.program.lower_expressions import FAULT, WiderError
from proofmass.runner.program.lower_statements import LoweredStatements
from proofmass.runner.program.shared import outline
from proofmass.runner.program.structure import Lowered, described, has_functions, leaves, rebuilt, shape_of

_LARGE = "proofmass.runner.continuous."  # solvers are called often and stay functions
ScopePlace = tuple[int, ...]  # of a list of statements within those that it lies in


class LoweredFunction(NamedTuple):
    """A function of a program, its result's structure by kinds, and all it read outside."""

    function: Function
    result: Lowered
    fails: bool  # whether the last of the function's results is a fault
    read: tuple[tuple[Any, str, Any], ...]


class Called(NamedTuple):
    """Result of a function, and whether anything failed in it; None if nothing can fail."""

    value: Lowered
    fault: Operand | None


_kept: dict[Hashable, LoweredFunction] = {}


def lower(function: Callable[..., Any], arguments: Sequence[Lowered]) -> LoweredFunction:
    """The function for arguments like these; raises `ModelError` for what cannot be lowered."""
    return _lowered(function, tuple(arguments), (), {})


def call(builder: Builder, function: Callable[..., Any], arguments: Sequence[Lowered]) -> Lowered:
    """Call a Python function that cannot fail from a function that is being written."""
    value, fault = outcome(builder, function, arguments)
    assert fault is None, "a function that may fail"
    return value


def outcome(builder: Builder, function: Callable[..., Any], arguments: Sequence[Lowered]) -> Called:
    """Call a Python function that may fail from a function that is being written."""
    return _called(builder, _lowered(function, tuple(arguments), (), builder.lowered), arguments)


def _called(builder: Builder, lowered: LoweredFunction, arguments: Sequence[Lowered]) -> Called:
    results = builder.call(lowered.function, *leaves(tuple(arguments)))
    return Called(rebuilt(lowered.result, results), results[-1] if lowered.fails else None)


def _lowered(
    callable_: Callable[..., Any],
    arguments: tuple[Lowered, ...],
    within: tuple[types.FunctionType, ...],
    own: dict[Hashable, LoweredFunction],
) -> LoweredFunction:
    """Return the function for such arguments; `own` keeps those that take functions."""
    function = inspect.unwrap(callable_)
    if not isinstance(function, types.FunctionType):
        raise Problem(message=f"a {type(function).__name__} is not a function", hint="write it with `def`").error
    key = (function, shape_of(arguments))
    functions = own if has_functions(arguments) else _kept
    before = functions.get(key)
    if before is None or not unchanged(list(before.read)):
        before = _read(function, arguments, described(key[1]), within, own)
        before = functions[key] = functions.setdefault(
            before.function.name, before
        )  # the same code may be of two functions
    return before


def _read(
    function: types.FunctionType,
    arguments: tuple[Lowered, ...],
    shape: str,
    within: tuple[types.FunctionType, ...],
    own: dict[Hashable, LoweredFunction],
) -> LoweredFunction:
    try:
        tree = tree_of(function)
        wider: dict[str, Kind] = {}
        while True:
            reader = _Reader(function, tree, wider, within, own)
            try:
                return reader.lowered(arguments, shape)
            except WiderError as error:
                wider[error.name] = error.kind
    except SourceError as error:
        raise problem_at(function, None, str(error), "write it into a file").error from None
    except RefusedError as refused:
        hint = refused.hint or "rewrite it, or run in plain Python: --engine python"
        raise problem_at(function, refused.node, refused.message, hint).error from None


class _Reader(LoweredStatements):
    """Reads one function."""

    def __init__(
        self,
        function: types.FunctionType,
        tree: ast.FunctionDef,
        wider: dict[str, Kind],
        within: tuple[types.FunctionType, ...],
        own: dict[Hashable, LoweredFunction],
    ) -> None:
        code = function.__code__
        origin = f"{function.__module__}.{function.__qualname__}"
        builder = Builder(function.__name__, origin, not function.__module__.startswith(_LARGE))
        super().__init__(builder, function, frozenset({*code.co_varnames, *code.co_cellvars}))
        self.tree, self.wider, self.within = tree, wider, (*within, function)
        self.checked = vars(function).get("checked", {})
        self.fault = self.builder.variable(TRUTH, "fault") if FAULT in wider else None
        self.changing, self.declared = changing(tree), annotated(function)
        self.builder.lowered = own

    def lowered(self, arguments: tuple[Lowered, ...], shape: str) -> LoweredFunction:
        """The function for arguments like these."""
        names = [argument.arg for argument in (*self.tree.args.posonlyargs, *self.tree.args.args)]
        defaults = self.function.__defaults__ or ()
        if self.tree.args.vararg or self.tree.args.kwarg or self.tree.args.kwonlyargs:
            raise refuse(self.tree, "* among the arguments", "name them one by one")
        if not len(names) - len(defaults) <= len(arguments) <= len(names):
            raise refuse(self.tree, f"{self.function.__name__} has {len(names)} arguments, not {len(arguments)}")
        given = [parameters_like(self.builder, name, value) for name, value in zip(names, arguments, strict=False)]
        given += [self.known(value) for value in defaults[len(defaults) - (len(names) - len(given)) :]]
        for name, value in zip(names, given, strict=True):
            self.set(ast.copy_location(ast.Name(name, ast.Store()), self.tree), value)
        self.block(self.tree.body)
        content = [self.builder.origin, shape, ast.dump(self.tree), repr(self._constants()), *self.functions]
        digest = hashlib.sha256("\0".join(content).encode("utf-8", "surrogatepass")).hexdigest()[:12]
        plain = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in self.function.__name__)
        self.builder.name = f"{plain}_{digest}"
        return LoweredFunction(self.builder.function(), self.result, self.fault is not None, tuple(self.read))

    def _constants(self) -> list[tuple[str, Any]]:
        """Numbers that were read from outside, on which the lowered function depends."""
        return [(name, value) for _, name, value in self.read if isinstance(value, int | float | tuple)]

    def called(self, node: ast.AST, function: types.FunctionType, arguments: Sequence[Lowered]) -> Lowered:
        if function in self.within:
            raise refuse(node, f"{function.__name__} calls itself", "write a loop")
        lowered = _lowered(function, tuple(arguments), self.within, self.builder.lowered)
        self.read += lowered.read
        self.functions.append(lowered.function.name)
        value, fault = _called(self.builder, lowered, arguments)
        if fault is not None:
            self.note(fault)
        return value


def program(entry: Function) -> Program:
    """The program of a function with all that it calls."""
    functions: dict[str, Function] = {}
    _collect(entry, functions)
    return Program(functions)


def _collect(function: Function, functions: dict[str, Function]) -> None:
    if functions.get(function.name) is function:
        return
    for called in dict.fromkeys(called for called, _ in outline(function).calls):
        _collect(called, functions)
    assert function.name not in functions, f"two functions are called {function.name}"
    functions[function.name] = function


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
