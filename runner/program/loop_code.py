"""Source of an algebraic loop: its equations as a function, and the lines that have them solved."""

import ast
from collections.abc import Iterator

from proofmass.graphs.checks.schedule import AlgebraicLoop, Node
from proofmass.runner.continuous.algebraic import scratch, solve
from proofmass.runner.plan.keys import variable
from proofmass.runner.program.pieces import Pieces


class LoopCode:
    """Writes the source of one loop, to be solved in the tick or at the instants within one."""

    def __init__(self, pieces: Pieces, loop: AlgebraicLoop, name: str) -> None:
        self.loop, self.name = loop, name
        pieces.names["solve"] = solve
        self._values = {node: pieces.number(pieces.call(*node, node[1])) for node in loop.nodes}
        called = {variable(node) for node in loop.nodes} | pieces.names.keys()
        read = {word for value in self._values.values() for word in _words(value)}
        self._given = ["time", *sorted(read - called - {"time"})]
        n = len(loop.tears)
        self.scratch = {"unknown": n} | {f"work_{i}": length for i, length in enumerate(scratch(n))}

    def functions(self) -> Iterator[str]:
        """The equations: what is found for the tears from what is assumed for them."""
        yield f"def {self.name}_equations(context, unknown, found):"
        yield f"    ({', '.join(self._given)},) = context"
        yield from (f"    {variable(tear)} = unknown[{i}]" for i, tear in enumerate(self.loop.tears))
        yield "    total = 0.0"
        for node in self.loop.others:
            yield f"    {variable(node)} = {self._values[node]}"
            yield f"    total += 0.0 * {variable(node)}"
        for i, tear in enumerate(self.loop.tears):
            yield f"    found[{i}] = {self._values[tear]} if total == 0.0 else total"
        yield ""
        yield ""

    def at(self, node: Node) -> Iterator[str]:
        """What stands in the place of a tear: the solution, when it is the first, from the values before."""
        if node == self.loop.tears[0]:
            names = [variable(tear) for tear in self.loop.tears]
            work = ", ".join(f"{self.name}_{key}" for key in self.scratch if key != "unknown")
            yield from (f"{self.name}_unknown[{i}] = {name}" for i, name in enumerate(names))
            context = f"({', '.join(self._given)},)"
            yield f"solve({self.name}_equations, {context}, {self.name}_unknown, ({work}))"
            yield from (f"{name} = {self.name}_unknown[{i}]" for i, name in enumerate(names))


def _words(value: str) -> Iterator[str]:
    return (part.id for part in ast.walk(ast.parse(value)) if isinstance(part, ast.Name))
