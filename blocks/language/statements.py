"""Statements, typed and rewritten: assignments, branches, loops and returns."""

import ast
import types
from collections.abc import Callable
from typing import Any

from proofmass.blocks.language.expressions import Typed
from proofmass.blocks.language.loops import Loops
from proofmass.blocks.language.refusals import RefusedError, refuse
from proofmass.blocks.language.scope import Scope
from proofmass.blocks.language.values import (
    NOTHING,
    NUMBERS,
    Record,
    RefusedType,
    TupleOf,
    Type,
    Vector,
    described,
)


class RestartError(Exception):
    """Something new was learned that changes statements already written: start again."""


class Statements(Loops):
    """Reads the statements of a function; `refused` has those that cannot be compiled."""

    def __init__(self, scope: Scope, result: Type | None, called: Callable[..., Typed]) -> None:
        super().__init__(scope)
        self.result, self._called = result, called
        self._written: dict[str, bool] = {}  # whether they were assigned literal integers alone
        self.refused: list[RefusedError] = []
        self._unreached: list[tuple[ast.Raise, ast.Return]] = []

    def call(self, node: ast.Call, target: types.FunctionType) -> Typed:
        return self._called(self, node, target)

    def block(self, body: list[ast.stmt]) -> tuple[list[ast.stmt], bool]:
        """Rewrite statements, and return whether control never gets past them."""
        before, self.lines, ended = self.lines, [], False
        for node in body:
            try:
                method = getattr(self, f"_{type(node).__name__.lower()}", None)
                if method is None:
                    message, hint = RefusedError.CONSTRUCTS.get(
                        type(node).__name__, (type(node).__name__, "leave it out")
                    )
                    raise refuse(node, f"{message} is not compiled", hint)
                first = len(self.lines)
                ended = bool(method(node)) or ended
                for line in self.lines[first:]:
                    ast.copy_location(line, node)
            except RefusedError as refused:
                self.refused.append(refused)
                self._forget(node)
        lines, self.lines = self.lines, before
        return lines or [ast.Pass()], ended

    def _forget(self, node: ast.stmt) -> None:
        """Make the types of variables of a refused statement unknown."""
        names = [part.id for part in ast.walk(node) if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store)]
        names += [(part.asname or part.name) for part in ast.walk(node) if isinstance(part, ast.alias)]
        names += [part.name for part in ast.walk(node) if isinstance(part, ast.FunctionDef | ast.ClassDef)]
        for name in names:
            if name not in self.scope.types:
                self.scope.types[name] = RefusedType()
                self.scope.assigned.add(name)

    # -- assignments -------------------------------------------------------------------------------

    def _assign(self, node: ast.Assign) -> None:
        value = self.expression(node.value)
        if len(node.targets) > 1:
            value = self.named(value[0]), value[1]
        for target in node.targets:
            self.set(target, value)

    def _annassign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            made, kind = self.expression(node.value)
            words: dict[str, Type] = {"float": float, "int": int, "bool": bool}
            wanted = words.get(ast.unparse(node.annotation), kind)
            self.set(node.target, (self.converted(node, made, kind, wanted, "the variable"), wanted))

    def _augassign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Subscript):
            vector, kind = self._vector(node.target)
            place = self.named(self.index(node.target, vector, kind))
            entry: Typed = ast.Subscript(vector, place, ast.Load()), kind.entry
            value = self.operated(node, type(node.op), entry, self.number(node.value))
            self._store(node, vector, place, kind, value)
            return
        assert isinstance(node.target, ast.Name | ast.Attribute)
        if isinstance(node.target, ast.Attribute):
            raise refuse(node, "a field cannot be changed", "return a new State(...) from update")
        left = self.number(ast.copy_location(ast.Name(node.target.id, ast.Load()), node.target))
        self.set(node.target, self.operated(node, type(node.op), left, self.number(node.value)))

    def set(self, target: ast.expr, value: Typed) -> None:
        expression, kind = value
        if isinstance(target, ast.Name):
            self.lines.append(ast.Assign([ast.Name(target.id, ast.Store())], self._into(target, expression, kind)))
        elif isinstance(target, ast.Tuple):
            parts = kind.entries if isinstance(kind, TupleOf) else ()
            parts = tuple(kind.fields.values()) if isinstance(kind, Record) else parts
            if len(parts) != len(target.elts):
                raise refuse(target, f"{len(target.elts)} variables of {described(kind)}", known=kind)
            names = [self.scope.fresh() for _ in parts]
            fresh: list[ast.expr] = [ast.Name(name, ast.Store()) for name in names]
            self.lines.append(ast.Assign([ast.Tuple(fresh, ast.Store())], expression))
            for part, name, of in zip(target.elts, names, parts, strict=True):
                self.set(part, (ast.Name(name, ast.Load()), of))
        elif isinstance(target, ast.Subscript):
            vector, of = self._vector(target)
            self._store(target, vector, self.index(target, vector, of), of, (expression, kind))
        else:
            raise refuse(target, "a field cannot be changed", "return a new State(...) from update")

    def _vector(self, target: ast.Subscript) -> tuple[ast.expr, Vector]:
        vector, kind = self.expression(target.value)
        if not isinstance(kind, Vector):
            raise refuse(target, f"{described(kind)} cannot be changed", "declare a Buffer", known=kind)
        if not kind.writable:
            raise refuse(
                target, "it is only read here", "buffers are changed in `update`, entries of an output in `out`"
            )
        return vector, kind

    def _store(self, node: ast.AST, vector: ast.expr, place: ast.expr, kind: Vector, value: Typed) -> None:
        entry = self.converted(node, *value, kind.entry, "an entry")
        self.lines.append(ast.Assign([ast.Subscript(vector, place, ast.Store())], entry))

    def _into(self, node: ast.Name, expression: ast.expr, kind: Type) -> ast.expr:
        """Convert a value for a variable, which has one type in the whole function."""
        name, before = node.id, self.scope.types.get(node.id)
        if kind == NOTHING:
            raise refuse(node, "the function returns nothing", "return a value from it")
        written = kind is int and isinstance(expression, ast.Constant)
        if name in self.scope.promoted and written:
            expression, kind = self.as_number(expression, kind), float
        if before is None or isinstance(before, RefusedType) or before == kind:
            self.scope.types[name] = kind
            self._written.setdefault(name, True)
            self._written[name] &= written
        elif before is float and written:
            expression = self.as_number(expression, kind)
        elif before is int and kind is float and self._written.get(name):
            self.scope.promoted.add(name)
            raise RestartError
        else:
            words = {
                float: "write it with a point, as in 0.0, or float(...)",
                int: "write int(...)",
                bool: "write a comparison",
            }
            hint = words.get(float if float in (kind, before) else before, "take another name")  # type: ignore[arg-type]
            message = f"{name} is {described(before)} elsewhere, and {described(kind)} here"
            raise refuse(node, message, hint if kind in NUMBERS else "take another name")
        self.scope.assigned.add(name)
        return expression

    # -- decisions ---------------------------------------------------------------------------------

    def _if(self, node: ast.If) -> bool:
        test = self.test(node.test)
        before = set(self.scope.assigned)
        then, ended = self.block(node.body)
        after = self.scope.assigned
        self.scope.assigned = before
        other, other_ended = self.block(node.orelse) if node.orelse else ([], False)
        if ended and other_ended:
            self.scope.assigned = after | self.scope.assigned
        elif not ended:
            self.scope.assigned = after if other_ended else after & self.scope.assigned
        self.lines.append(ast.If(test, then, other))
        return ended and other_ended

    def _pass(self, node: ast.Pass) -> None:
        self.lines.append(node)

    def _expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return
        if (
            isinstance(node.value, ast.Call)
            and isinstance(node.value.func, ast.Name)
            and node.value.func.id == "breakpoint"
        ):
            self.lines.append(ast.Expr(self.applied(breakpoint)))
            return
        made, _ = self.expression(node.value)
        self.lines.append(ast.Expr(made))

    # -- the end -----------------------------------------------------------------------------------

    def _return(self, node: ast.Return) -> bool:
        made, kind = self.expression(node.value) if _is_value(node.value) else (ast.Constant(None), NOTHING)  # type: ignore[arg-type]
        self.lines.append(self.returned(node, made, kind))
        return True

    def returned(self, node: ast.AST, expression: ast.expr, kind: Type) -> ast.stmt:
        """Write a return of the declared type."""
        wanted = self.result
        if wanted is None:
            self.result = wanted = kind
        if wanted == NOTHING != kind or kind == NOTHING != wanted:
            message = f"{described(kind)} is returned, and {described(wanted)} elsewhere or in the declaration"
            raise refuse(node, message, "return a value on every path, or on none", known=kind)
        return ast.Return(self.converted(node, expression, kind, wanted, "what is returned"))

    def _raise(self, node: ast.Raise) -> bool:
        """Write the statement, and for programs, which note a fault and go on, a return that Python never meets."""
        for part in ast.walk(node):
            if isinstance(part, ast.Name) and part.id not in self.scope.types:
                self.scope.namespace.setdefault(part.id, self.scope.outside(part))
        self._unreached.append((node, ast.Return()))
        self.lines += self._unreached[-1]
        return True

    def end(self) -> None:
        """Write what is returned after each `raise`; only here is the type known."""
        if self.result is None:
            self.result = int if self._unreached else NOTHING
        for node, unreached in self._unreached:
            unreached.value = self.nothing(node, self.result)

    def _assert(self, node: ast.Assert) -> None:
        test = ast.UnaryOp(ast.Not(), self.test(node.test))
        error = ast.Call(ast.Name("AssertionError", ast.Load()), [node.msg] if node.msg else [], [])
        raised = ast.Raise(error, None)
        self.lines.append(ast.If(test, self.block([ast.copy_location(raised, node)])[0], []))

    def nothing(self, node: ast.AST, kind: Any) -> ast.expr:
        """A value of a type that is never used."""
        if kind is float:
            return ast.Constant(float("nan"))
        if kind in (int, bool):
            return ast.Constant(kind(0))
        if isinstance(kind, Record):
            return ast.Call(self.bound(kind.kind), [self.nothing(node, of) for of in kind.fields.values()], [])
        if isinstance(kind, TupleOf):
            return ast.Tuple([self.nothing(node, of) for of in kind.entries], ast.Load())
        if kind == NOTHING:
            return ast.Constant(None)
        raise refuse(node, f"raise in a function of {described(kind)}", "return a tuple")


def _is_value(node: ast.expr | None) -> bool:
    return node is not None and not (isinstance(node, ast.Constant) and node.value is None)
