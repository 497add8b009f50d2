"""Loops: their sequences, their ends, and the limit of their turns."""

import ast
from dataclasses import dataclass

from proofmass.blocks.language import operations
from proofmass.blocks.language.calls import Calls
from proofmass.blocks.language.expressions import Typed, assign
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.scope import Scope
from proofmass.blocks.language.values import TupleOf


@dataclass
class _Loop:
    """A loop that is being read."""

    flag: str  # which says whether it ended without `break`; "" for a loop without `else`
    left: set[str] | None = None  # variables with a value at every `break`; None without a `break`


class Loops(Calls):
    """Reads loops."""

    def __init__(self, scope: Scope) -> None:
        super().__init__(scope)
        self.lines: list[ast.stmt] = []  # of the block that is being read
        self._loops: list[_Loop] = []  # loops that are being read, the innermost last

    def block(self, body: list[ast.stmt]) -> tuple[list[ast.stmt], bool]:
        """Rewrite statements, and return whether control never gets past them."""
        raise NotImplementedError

    def set(self, target: ast.expr, value: Typed) -> None:
        """Write an assignment to a variable, an entry, or several of them."""
        raise NotImplementedError

    def named(self, value: ast.expr) -> ast.expr:
        """Store a value in a variable, unless it is a literal, and return the variable."""
        if isinstance(value, ast.Constant):
            return value
        self.lines.append(assign(name := self.scope.fresh(), value))
        return ast.Name(name, ast.Load())

    def _for(self, node: ast.For) -> bool:
        sequence, kind = self._gone_through(node.iter)
        offset = self._offset(node.iter)
        before = set(self.scope.assigned)
        name = self.scope.fresh()
        self._begin_loop(node)
        loop = ast.For(ast.Name(name, ast.Store()), sequence, [], [])
        self.lines.append(loop)
        turn: Typed = ast.Name(name, ast.Load()), kind
        before_loop, self.lines = self.lines, loop.body
        self.set(node.target, self._numbered(node, turn, offset) if offset else turn)
        self.lines = before_loop
        loop.body += self.block(node.body)[0]
        self.scope.assigned = before
        return self._end_loop(node)

    def _begin_loop(self, node: ast.For | ast.While) -> None:
        flag = self.scope.fresh() if node.orelse else ""
        if flag:
            self.lines.append(assign(flag, ast.Constant(True)))
        self._loops.append(_Loop(flag))

    def _end_loop(self, node: ast.For | ast.While) -> bool:
        """Write the statements of `else`; return whether control never gets past the loop."""
        loop, before = self._loops.pop(), set(self.scope.assigned)
        if not loop.flag:
            return False
        lines, ended = self.block(node.orelse)
        self.lines.append(ast.If(ast.Name(loop.flag, ast.Load()), lines, []))
        self.scope.assigned = before if loop.left is None or not ended else loop.left
        return ended and loop.left is None

    def _offset(self, node: ast.expr) -> ast.expr | None:
        """The second argument of enumerate."""
        if not (isinstance(node, ast.Call) and len(node.args) == 2 and isinstance(node.func, ast.Name)):
            return None
        if getattr(self.expression(node.func)[1], "value", None) is not enumerate:
            return None
        made, kind = self.number(node.args[1])
        if kind is float:
            raise refuse(node, "enumerate from a number", "it counts in integers: write int(...)")
        return self.named(self.as_integer(made, kind))

    def _numbered(self, node: ast.For, turn: Typed, offset: ast.expr) -> Typed:
        """Write the pair of an `enumerate` that does not begin at zero."""
        pair, kind = turn
        assert isinstance(kind, TupleOf)
        place: Typed = ast.Subscript(pair, ast.Constant(0), ast.Load()), int
        number, _ = self.operated(node, ast.Add, place, (offset, int))
        return ast.Tuple([number, ast.Subscript(pair, ast.Constant(1), ast.Load())], ast.Load()), kind

    def _gone_through(self, node: ast.expr) -> Typed:
        """Rewrite the sequence of a loop and return it with the type of its variable."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            target = self.expression(node.func)[1]
            value = getattr(target, "value", None)
            if value is range and 1 <= len(node.args) <= 3:
                read = [self.number(part) for part in node.args]
                if any(kind is float for _, kind in read):
                    raise refuse(node, "a range of numbers", "range is of integers: write int(...)")
                bounds = [self.as_integer(*part) for part in read]
                bounds = [ast.Constant(0), *bounds] if len(bounds) == 1 else bounds
                bounds = [*bounds, ast.Constant(1)][:3]
                if not (isinstance(bounds[2], ast.Constant) and bounds[2].value):
                    bounds[2] = self.named(self.applied(operations.STRIDE, bounds[2]))
                if not all(isinstance(part, ast.Constant) and abs(int(str(part.value))) < 1000 for part in bounds):
                    bounds = [self.named(part) for part in bounds]
                    bounds[1] = self.applied(operations.RANGE_END, *bounds)
                return self.applied(range, *bounds), int
            if value is enumerate and len(node.args) in (1, 2):
                sequence, entry = self.sequence(node.args[0])
                return self.applied(enumerate, sequence), TupleOf((int, entry))
            if value is zip and node.args:
                parts = [self.sequence(part) for part in node.args]
                return self.applied(zip, *(sequence for sequence, _ in parts)), TupleOf(
                    tuple(kind for _, kind in parts)
                )
        return self.sequence(node)

    def _while(self, node: ast.While) -> bool:
        before, turns = set(self.scope.assigned), self.scope.fresh()
        self._begin_loop(node)
        test = self.test(node.test)
        body, _ = self.block(node.body)
        more = self.applied(operations.TURN, ast.Name(turns, ast.Load()))
        self.lines += [assign(turns, ast.Constant(0)), ast.While(test, [assign(turns, more), *body], [])]
        self.scope.assigned = before
        return self._end_loop(node)

    def _break(self, node: ast.Break) -> bool:
        loop = self._loops[-1]
        if loop.flag:
            self.lines.append(assign(loop.flag, ast.Constant(False)))
        loop.left = set(self.scope.assigned) if loop.left is None else loop.left & self.scope.assigned
        self.lines.append(node)
        return True

    def _continue(self, node: ast.Continue) -> bool:
        self.lines.append(node)
        return True
