"""Paths through a function: from which of its arguments each part of its result follows, by its text.

An expression follows from all that it names. A condition chooses, and passes nothing on; nor does a
comparison. So what does not follow has no slope wherever the function is called, and what follows
may have one.

So noise has paths through a graph, wherever it is linearised: which outputs and states may have a
slope by it. Truth values have no slopes, but for those that a model of one bit stands for.
"""

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, TypeAlias

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.source import SourceError, tree_of
from proofmass.graphs.model.digraph import with_following
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_functions import LEVELS, reaches
from proofmass.runner.plan.bindings import Binding, BufferBinding, Out, StateBinding, WireBinding
from proofmass.runner.plan.planned import Plan

ArgumentNames = frozenset[str]  # names of arguments, "x.field" for a field of one
RESULT = "result"  # instead of a field, of a function with another result
_HIDING = ast.FunctionDef | ast.Lambda | ast.Match | ast.Starred | ast.List | ast.ListComp | ast.Dict | ast.DictComp
_Number: TypeAlias = tuple[str, str, str]  # what it is, its block, and its port, field or buffer
_WIRE, _STATE, _BUFFER, _CONSTANTS = "wire", "state", "buffer", "constants"
_LOOPED = ("update", "derivative", "fold")


@cache
def passed_on(
    function: Callable[..., Any], fields: tuple[str, ...], lists: tuple[str, ...]
) -> Mapping[str, ArgumentNames] | None:
    """Return from what each field of the result follows, and each list among the arguments; None if
    that is not known.

    Without fields it is the whole of the result, `RESULT`. A record that is an argument has the
    same fields.
    """
    try:
        tree = tree_of(function)  # type: ignore[arg-type]
    except (SourceError, AttributeError):
        return None
    if any(_hides(node) for statement in tree.body for node in ast.walk(statement)):
        return None
    return _Text(tree, fields, lists).read()


def _hides(node: ast.AST) -> bool:
    """Return whether a function's part may pass on what it does not name, as its own lists do."""
    if isinstance(node, ast.Name):
        return node.id in ("list", "dict", "set", "bytearray")
    return isinstance(node, _HIDING) and not isinstance(getattr(node, "ctx", None), ast.Store)


class _Text:
    """Reads one function, again and again until nothing more follows."""

    def __init__(self, tree: ast.FunctionDef, fields: Sequence[str], lists: Sequence[str]) -> None:
        self._tree, self._fields, self._lists = tree, fields, lists
        arguments = [argument.arg for argument in tree.args.args]
        self._names = {name: frozenset([name]) for name in arguments}
        self._found = dict.fromkeys([*(fields or [RESULT]), *lists], ArgumentNames())
        set_again = {
            node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        self._whole = {*arguments} - set_again  # what is the argument itself wherever it is named

    def read(self) -> Mapping[str, ArgumentNames]:
        """Return what follows from what."""
        before = None
        while before != (before := (dict(self._names), dict(self._found))):
            for statement in self._tree.body:
                self._statement(statement)
        return self._found

    def _statement(self, node: ast.stmt) -> None:
        for part in ast.walk(node):
            match part:
                case ast.Assign(targets, value):
                    for target in targets:
                        self._set(target, self._of(value))
                case ast.AnnAssign(target, _, value) | ast.AugAssign(target, _, value) | ast.NamedExpr(target, value):
                    self._set(target, self._of(value))
                case ast.For(target, reach) | ast.comprehension(target, reach):
                    self._set(target, self._of(reach))
                case ast.Return(value):
                    self._returned(value)
                case ast.Call(_, arguments, keywords):  # may write to a list
                    for each in (*arguments, *(keyword.value for keyword in keywords)):
                        self._set(each, self._of(part), lists=True)

    def _set(self, target: ast.expr, follows: ArgumentNames, lists: bool = False) -> None:
        match target:
            case ast.Name(name) if lists:
                for known in self._names.get(name, ArgumentNames()).intersection(self._lists):
                    self._found[known] |= follows
            case ast.Name(name):
                self._names[name] = self._names.get(name, ArgumentNames()) | follows
            case ast.Subscript(value, index):
                self._set(value, follows | self._of(index), lists=True)
            case ast.Tuple(parts) | ast.List(parts):
                for part in parts:
                    self._set(part, follows, lists)

    def _returned(self, value: ast.expr | None) -> None:
        """Count a result: its fields one by one where they are written down."""
        match value:
            case ast.IfExp(_, one, other):
                self._returned(one)
                self._returned(other)
            case ast.Name(name) if self._fields and name in self._whole:
                self._add({field: frozenset([f"{name}.{field}"]) for field in self._fields})
            case ast.Call(ast.Attribute(ast.Name(name), "_replace"), [], keywords) if name in self._whole:
                changed = {each.arg: self._of(each.value) for each in keywords}
                self._add({field: changed.get(field, frozenset([f"{name}.{field}"])) for field in self._fields})
            case ast.Call(ast.Name(name), arguments, keywords) if self._fields and name[:1].isupper():
                parts = dict(zip(self._fields, arguments, strict=False))
                parts |= {each.arg: each.value for each in keywords if each.arg}
                if {*parts} == {*self._fields}:
                    self._add({field: self._of(part) for field, part in parts.items()})
                else:
                    self._add(dict.fromkeys(self._fields, self._of(value)))
            case None:
                pass
            case _:
                self._add(dict.fromkeys(self._fields or [RESULT], self._of(value)))

    def _add(self, more: Mapping[str, ArgumentNames]) -> None:
        for part, follows in more.items():
            self._found[part] |= follows

    def _of(self, node: ast.expr | None) -> ArgumentNames:
        """Return what an expression follows from."""
        match node:
            case ast.Name(name):
                known = self._names.get(name, ArgumentNames())
                return known.union(*(self._found[of] for of in known.intersection(self._lists)))
            case ast.Attribute(ast.Name(name), field) if name in self._whole:
                return frozenset([f"{name}.{field}"])
            case ast.Compare() | ast.UnaryOp(ast.Not()) | None:
                return ArgumentNames()
            case ast.IfExp(_, one, other):
                return self._of(one) | self._of(other)
            case _:
                return ArgumentNames().union(*map(self._of, _expressions(node)))


def _expressions(node: ast.AST) -> Iterator[ast.expr]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.expr):
            yield child
        elif isinstance(child, ast.keyword | ast.comprehension):
            yield from _expressions(child)


def reached_by_noise(plan: Plan, noise: Collection[str]) -> set[Endpoint]:
    """Return the outputs that may have slopes by the noise of some blocks, at one operating point or another."""
    edges = dict[_Number, set[_Number]]()
    for name in plan.blocks:
        for made, of in _edges(plan, name):
            for number in of:
                edges.setdefault(number, set()).add(made)
    begin = (made for name in noise for made, _ in _edges(plan, name))
    moving = with_following(begin, lambda number: edges.get(number, ()))
    return {(name, part) for what, name, part in moving if what == _WIRE}


def _edges(plan: Plan, name: str) -> Iterator[tuple[_Number, set[_Number]]]:
    """Yield what a block makes, and from which numbers that follows."""
    kind, drivers = type(plan.blocks[name]), plan.schedule.drivers
    functions = {**kind.output_functions, **{role: kind.functions[role] for role in _LOOPED if role in kind.functions}}
    whole = name in plan.digital or any(reaches(each.function, LEVELS) for each in functions.values())
    whole |= bool(kind.events or kind.corners)
    driven = {(_WIRE, *drivers[name, p]) for p in kind.parameters if (name, p) in drivers}
    if driven:
        yield (_CONSTANTS, name, ""), driven
    for port, behaviour in functions.items():
        yield from _of_function(plan, name, port, behaviour, whole)


def _of_function(
    plan: Plan, name: str, port: str, behaviour: Behaviour, whole: bool
) -> Iterator[tuple[_Number, set[_Number]]]:
    kind = type(plan.blocks[name])
    state = kind.state_class()
    fields: tuple[str, ...] = state._fields if state else ()  # type: ignore[attr-defined]
    given = dict(zip(behaviour.arguments, plan.bindings(name, port), strict=True))
    lists = tuple(n for n, of in given.items() if isinstance(of, BufferBinding | Out))
    is_output = port in kind.output_functions
    found = None if whole else passed_on(behaviour.function, () if is_output else fields, lists)
    every = {number for of in given.values() for number in _numbers(of, fields)} | {(_CONSTANTS, name, "")}

    def numbers(follows: ArgumentNames) -> set[_Number]:
        own = set[_Number]()
        for each in follows:
            argument, _, field = each.partition(".")
            if argument in given:
                own |= {*_numbers(given[argument], (field,) if field else fields)}
            else:  # the first one
                own.add((_CONSTANTS, name, ""))
        return own

    if not is_output:
        for field in fields:
            yield (_STATE, name, field), every if found is None else numbers(found[field])
    elif whole or kind.outputs[port].dtype is not bool:
        written = [RESULT, *(argument for argument, of in given.items() if isinstance(of, Out))]
        follows = every if found is None else numbers(ArgumentNames().union(*(found[each] for each in written)))
        yield (_WIRE, name, port), follows
    for argument in lists:
        of = given[argument]
        if isinstance(of, BufferBinding):
            yield (_BUFFER, *of.node), every if found is None else numbers(found[argument])


def _numbers(of: Binding, fields: tuple[str, ...]) -> Iterator[_Number]:
    match of:
        case StateBinding(name):
            yield from ((_STATE, name, field) for field in fields)
        case WireBinding((name, port)):
            yield _WIRE, name, port
        case BufferBinding((name, buffer)):
            yield _BUFFER, name, buffer
