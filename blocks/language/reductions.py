"""Reductions of a tuple, list or buffer to one number: least, largest, sum, product."""

import ast
import math
from typing import Any

from proofmass.blocks.language import operations
from proofmass.blocks.language.expressions import Expressions
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.values import NUMBERS, Type, described
from proofmass.blocks.language.writing import Typed, assign

REDUCED: tuple[Any, ...] = (min, max, sum, math.prod)


class Reductions(Expressions):
    """Reads calls that reduce all entries to one number; they become loops."""

    def reduced(self, node: ast.Call, target: Any) -> Typed:
        """Return min, max, sum or math.prod of the entries of the one argument."""
        sequence, entry = self.sequence(node.args[0])
        if entry not in NUMBERS:
            raise refuse(node, f"{target.__name__}() of what is {described(entry)}", "its entries must be numbers")
        if target is sum and entry is float:
            raise refuse(node, "sum() of numbers is not compiled", operations.INSTEAD[sum])
        entries, total, entry_name = (self.scope.fresh() for _ in range(3))
        self.lines.append(assign(entries, sequence))
        if target in (min, max):
            kind, first, body = entry, self._first(entries), self._better(target, total, entry_name)
        else:
            kind = float if entry is float else int
            first = ast.Constant(kind(0 if target is sum else 1))
            body = self._more(node, ast.Add if target is sum else ast.Mult, (total, kind), (entry_name, entry))
        self.lines.append(assign(total, first))
        self.lines.append(ast.For(ast.Name(entry_name, ast.Store()), ast.Name(entries, ast.Load()), body, []))
        return ast.Name(total, ast.Load()), kind

    def _first(self, entries: str) -> ast.expr:
        """Write the first entry, which must exist."""
        held = ast.Name(entries, ast.Load())
        place = self.checked(operations.PLACE, ast.Constant(0), self.applied(len, held))
        return ast.Subscript(held, place, ast.Load())

    def _better(self, target: Any, best: str, one: str) -> list[ast.stmt]:
        """Write the step that keeps the entry if it is less or greater than the best so far, compared as in Python."""
        entry, before = ast.Name(one, ast.Load()), ast.Name(best, ast.Load())
        test = ast.Compare(entry, [ast.Lt() if target is min else ast.Gt()], [before])
        return [assign(best, ast.IfExp(test, entry, before))]

    def _more(
        self, node: ast.AST, operator: type[ast.operator], total: tuple[str, Type], one: tuple[str, Type]
    ) -> list[ast.stmt]:
        """Write the step that adds one entry to the total."""
        (name, kind), (entry, of) = total, one
        parts: list[Typed] = [(ast.Name(name, ast.Load()), kind), (ast.Name(entry, ast.Load()), of)]
        lines, (made, _) = self.apart(lambda: self.operated(node, operator, *parts))
        return [*lines, assign(name, made)]
