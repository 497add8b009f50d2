"""Formulas in the tables of blocks, resolved to numbers before the blocks are made."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.parameter import fill
from proofmass.blocks.declaration.problem import Problem, Refusal
from proofmass.graphs.files.locate_keys import KeyPath
from proofmass.graphs.formulas.formula import Formula, is_formula
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.targets import Target, number_of, of_parameter, target_at
from proofmass.graphs.model.values import NamedValue


class TableFormulas:
    """The formulas of a file by their targets, and their `problems`; blocks in `waiting` need unread values.

    A formula that needs a value that could not be read is not reported: the problem is that of the
    value.
    """

    def __init__(self, values: Mapping[str, NamedValue], declared: object) -> None:
        self.values, self.formulas = values, dict[str, Formula]()
        self.problems: list[Problem] = []
        self.waiting: set[str] = set()  # blocks whose formulas need values that could not be read
        self._no_table = not isinstance(declared, Mapping | None)
        self._broken = set(declared if isinstance(declared, Mapping) else ()) - values.keys()

    def of_block(self, kind: type[Block], name: str, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return the table of a block with numbers in place of formulas; without wrong ones."""
        texts = {n: table.get(n, p.default) for n, p in kind.parameters.items() if p.kind is str}
        numbers = dict(table)
        for key, entry in table.items():
            parameter = kind.parameters.get(key)
            if parameter is None or parameter.kind is str:
                continue
            unit, path = fill(parameter.unit, texts), ("blocks", name, key)
            if is_formula(entry):
                self._put(numbers, key, f"{name}.{key}", path, partial(of_parameter, parameter, unit))
            elif parameter.kind is tuple and isinstance(entry, list) and any(map(is_formula, entry)):
                numbers[key] = self._entries(entry, f"{name}.{key}", path, unit)
                if None in numbers[key]:
                    del numbers[key]
        return numbers

    def of_part(self, names: Sequence[str], part: Graph, table: Mapping[str, object]) -> dict[str, object]:
        """Return the table of one or several subgraphs with numbers in place of formulas."""
        numbers = dict(table)
        for key, entry in table.items():
            if is_formula(entry):
                path = ("blocks", names[0], *key.split("."))
                inner = part.exports.get(key, key)
                self._put(numbers, key, f"{names[0]}.{key}", path, partial(target_at, part, inner))
                formula = self.formulas.get(f"{names[0]}.{key}")
                self.formulas |= {f"{name}.{key}": formula for name in names[1:]} if formula else {}
        return numbers

    def _put(self, numbers: dict[str, Any], key: str, of: str, path: KeyPath, find: Callable[[], Target]) -> None:
        """Put the number of a formula in its place, or take it out."""
        number = self._number(of, numbers[key], path, find)
        if number is None:
            del numbers[key]
        else:
            numbers[key] = number

    def _entries(self, entries: Sequence[object], of: str, path: KeyPath, unit: str) -> list[object]:
        """A list with numbers in place of formulas, None in place of wrong ones."""
        return [
            self._number(f"{of}[{place}]", entry, path, partial(Target, unit)) if is_formula(entry) else entry
            for place, entry in enumerate(entries)
        ]

    def _number(self, of: str, text: str, path: KeyPath, find: Callable[[], Target]) -> float | int | Fraction | None:
        """Note a formula and return its number; None, and a problem, if it has none."""
        try:
            formula = Formula(text)
            if self._no_table or formula.names & self._broken:
                self.waiting.add(path[1])
                return None
            number = number_of(formula, self.values, find())
        except Refusal as error:
            self.waiting.add(path[1])
            self.problems.append(error.problem(".".join(path), text, path=path))
            return None
        self.formulas[of] = formula
        return number
