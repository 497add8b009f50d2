"""Plain forms: a function with arguments of known types, checked and rewritten so that all engines can run it."""

import ast
import inspect
import types
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import Any

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.source import SourceError, define, tree_of
from proofmass.blocks.language.calls import Calls
from proofmass.blocks.language.expressions import Typed
from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import RefusedError, problem_at, refuse
from proofmass.blocks.language.scope import Read, Scope, unchanged
from proofmass.blocks.language.statements import RestartError, Statements
from proofmass.blocks.language.values import NOTHING, RefusedType, Type, Vector, annotated, described, type_of

_OURS = "proofmass."
_ZEROS: dict[Type, str] = {float: "0.0", int: "0", bool: "False"}


@dataclass
class Form:
    """A rewritten function, from which programs are lowered; its attribute `checked` has operations that may fail."""

    function: Any  # None where there are problems
    result: Type
    problems: list[Problem]
    reads: list[Read] = field(default_factory=list)


_kept: dict[Any, Form] = {}


def plain_form(
    function: types.FunctionType,
    arguments: tuple[Type, ...],
    result: Type | None,
    within: tuple[types.FunctionType, ...] = (),
) -> Form:
    """Return the function for arguments of these types; its result is converted to the type `result` if given."""
    key = (function, arguments, result)
    before = _kept.get(key)
    if before is None or not unchanged(before.reads):  # numbers and functions of the file may have been changed
        before = _kept[key] = _plain_form(function, arguments, result, within)
    return before


def _plain_form(
    function: types.FunctionType,
    arguments: tuple[Type, ...],
    result: Type | None,
    within: tuple[types.FunctionType, ...],
) -> Form:
    if not isinstance(function, types.FunctionType):
        problem = Problem(message=f"a {type(function).__name__} is not a function", hint="write it with `def`")
        return Form(None, result or RefusedType(), [problem])
    try:
        tree = tree_of(function)
    except SourceError as error:
        hint = "write the block into a file, with `def`, and load it anew"
        return Form(None, result or RefusedType(), [problem_at(function, None, str(error), hint)])
    names = [argument.arg for argument in (*tree.args.posonlyargs, *tree.args.args, *tree.args.kwonlyargs)]
    if not within:
        tree = _cleared(tree, dict(zip(names, arguments, strict=True)))
    problems, reads, promoted = list[Problem](), list[Read](), set[str]()

    def called(reader: Calls, node: ast.Call, target: types.FunctionType) -> Typed:
        if target in (*within, function):
            raise refuse(node, f"{target.__name__} calls itself", "write a loop")
        given_types = reader.given(node, target)
        if target.__module__.startswith(_OURS):
            return _ours(reader, node, target, given_types)
        kinds = tuple(kind for _, kind in given_types)
        callee = plain_form(target, kinds, annotated(target), (*within, function))
        problems.extend(problem for problem in callee.problems if problem not in problems)
        reads.extend(callee.reads)
        if callee.problems:
            raise refuse(node, "", known=RefusedType())
        return reader.applied(callee.function, *(argument for argument, _ in given_types)), callee.result

    while True:  # until all variables that are numbers are known to be
        problems.clear()
        reads.clear()
        scope = Scope(function, tree, dict(zip(names, arguments, strict=True)), promoted)
        reader = Statements(scope, result, called)
        try:
            lines = _body(reader, tree)
            break
        except RestartError:
            continue
    problems += [problem_at(function, r.node, r.message, r.hint) for r in reader.refused if r.message]
    reads += reader.scope.reads
    made = None if reader.refused else _defined(function, tree, names, lines, reader.scope)
    return Form(made, reader.result or RefusedType(), problems, reads)


def _cleared(tree: ast.FunctionDef, kinds: Mapping[str, Type]) -> ast.FunctionDef:
    """Return a function that begins with zeros in its output: entries of the tick before would be a memory of it."""
    written = {name: kind.entry for name, kind in kinds.items() if isinstance(kind, Vector) and kind.cleared}
    lines = (f"for _entry in range(len({name})): {name}[_entry] = {_ZEROS[of]}" for name, of in written.items())
    begin = ast.parse("\n".join(lines))
    for node in ast.walk(begin):
        ast.copy_location(node, tree)
    cleared = copy(tree)
    cleared.body = [*begin.body, *tree.body]
    return cleared


def _body(reader: Statements, tree: ast.FunctionDef) -> list[ast.stmt]:
    """The statements, followed by a return if the function returns nothing."""
    lines, ended = reader.block(tree.body)
    if not ended:
        try:
            lines.append(reader.returned(tree, ast.Constant(None), NOTHING))
        except RefusedError as refused:
            if reader.refused:
                return lines  # the statement that returns was refused
            message = f"it does not always return {described(reader.result or NOTHING)}"
            reader.refused.append(RefusedError(refused.node, message, "return a value on every path"))
    try:
        reader.end()
    except RefusedError as refused:
        reader.refused.append(refused)
    return lines


def _ours(reader: Calls, node: ast.Call, target: types.FunctionType, arguments: list[Typed]) -> Typed:
    """Write a call of a function of this package, with declared types, the same everywhere."""
    hints, result = inspect.get_annotations(target, eval_str=True), annotated(target)
    if result is None:
        raise refuse(node, f"{target.__name__}() says no type of what it returns", "write a function of your own")
    converted = []
    for name, (argument, kind) in zip(inspect.signature(target).parameters, arguments, strict=True):
        wanted = type_of(hints.get(name))
        number = wanted in (float, int, bool)
        converted.append(reader.converted(node, argument, kind, wanted, f"the argument {name}") if number else argument)
    return reader.applied(target, *converted), result


def _defined(
    function: types.FunctionType, tree: ast.FunctionDef, names: list[str], lines: list[ast.stmt], scope: Scope
) -> types.FunctionType:
    """Compile statements into a function; each keeps the line of its source."""
    arguments = ast.arguments([], [ast.arg(name) for name in names], None, [], [], None, [])
    made = ast.copy_location(ast.FunctionDef(tree.name, arguments, lines, [], None), tree)
    if "type_params" in ast.FunctionDef._fields:
        made.type_params = []  # type: ignore[attr-defined, unused-ignore]
    checked = {name: value for name, value in scope.namespace.items() if isinstance(value, Checked)}
    references = {name: operation.reference for name, operation in checked.items()}
    namespace = {"__name__": function.__module__, **scope.namespace, **references}
    defined = define(made, function.__code__.co_filename, namespace)
    vars(defined)["checked"] = checked
    return defined
