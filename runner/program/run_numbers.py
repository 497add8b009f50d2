"""The numbers of a run in a program: those given to the loop, those that last from call to call, and its scratch."""

from typing import Any

from proofmass.runner.plan.keys import Given, Moving
from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, INTEGER, Function, Kind, Storage, Variable
from proofmass.runner.program.lower_numbers import KINDS
from proofmass.runner.program.parts import in_parts, keep, kept
from proofmass.runner.program.slots import FLOATS, INTEGERS, Slots, parts
from proofmass.runner.program.structure import Lowered

_LONG = 8  # entries from which on a tuple of constants stays in memory
_KINDS = {FLOATS: FLOAT, INTEGERS: INTEGER}
_MOVING = {FLOATS: "state_numbers", INTEGERS: "state_integers"}


class RunNumbers:
    """Places of the numbers in the loop's arrays, and the statements that read and write them.

    With `lanes`, each constant has its own place, as each lane has its own value.
    """

    def __init__(self, builder: Builder, lanes: bool) -> None:
        self.builder, self.lanes = builder, lanes
        self.constants, self.memory = Slots[Given](), Slots[Moving]()
        self.values: dict[Given, Any] = {}  # of the constants
        self.scratch_used = 0
        self.given = {name: self._array(kind, name) for name, kind in _KINDS.items()}
        self.moving = {name: self._array(kind, _MOVING[name], True) for name, kind in _KINDS.items()}
        self.scratch_array = self._array(FLOAT, "scratch", True)
        self._places: dict[Variable, tuple[Storage, int]] = {}  # of variables read before the ticks, and written back
        self.not_finite = builder.variable(FLOAT, "not_finite")
        self.refused = builder.variable(INTEGER, "refused")

    def _array(self, kind: Kind, name: str, writable: bool = False) -> Storage:
        return self.builder.array(kind, None, name, writable)

    def constant(self, key: Given, kind: Any, value: Any) -> Lowered:
        """A number given to the loop, or a tuple of them."""
        if isinstance(value, tuple):
            return self._constant_tuple(key, kind, value)
        self.values[key] = value
        name, place = self.constants.add(key, kind)
        return kept(self.builder, self.given[name], place, KINDS[kind])

    def _constant_tuple(self, key: Given, kind: Any, value: tuple[Any, ...]) -> Lowered:
        """A tuple of constants; a long one stays in memory."""
        among = parts(key, kind, value)
        kinds = {of for _, of, _ in among}
        if self.lanes or len(value) < _LONG or kinds not in ({float}, {int}):
            return tuple(self.constant(of, entry, number) for of, entry, number in among)
        places = []
        for of, entry, number in among:
            self.values[of] = number
            places.append(self.constants.add(of, entry))
        name, first = places[0]
        return self.builder.view(self.given[name], first, len(value))

    def variable(self, key: Moving, kind: type, name: str) -> Variable:
        """A variable that keeps its value from call to call of the loop."""
        array, place = self.memory.add(key, kind)
        variable = self.builder.variable(KINDS[kind], name)
        self._places[variable] = self.moving[array], place
        return variable

    def scratch(self, name: str, length: int) -> Storage:
        """Numbers to work on."""
        self.scratch_used += length
        return self.builder.view(self.scratch_array, self.scratch_used - length, length, name)

    def complete(self, entry: Function) -> Function:
        """Complete the function of all ticks: split if it is long; otherwise all that moves is in local variables."""
        for name, flag in ((FLOATS, self.not_finite), (INTEGERS, self.refused)):  # in scratch
            self._places[flag] = self.moving[name], self.memory.counts[name]
        used = None if self.lanes else in_parts(entry, self._places, self.scratch_array, self.scratch_used)
        if used is None:
            self._read_and_write_back(entry)
        self.scratch_used += used or 0
        return entry

    def _read_and_write_back(self, entry: Function) -> None:
        builder = self.builder
        with builder.within([]) as before:
            for variable, (array, place) in self._places.items():
                builder.set(variable, kept(builder, array, place, variable.kind))
        with builder.within([]) as behind:
            for variable, (array, place) in self._places.items():
                keep(builder, array, place, builder.get(variable))
        entry.body = [*before, *entry.body, *behind]
