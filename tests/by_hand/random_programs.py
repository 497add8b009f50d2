"""Random programs of all statements, which end whatever numbers they are given."""

import random
from typing import Any

import numpy as np

from proofmass.runner.program.form import FLOAT, INTEGER, OPERATIONS, TRUTH, Function, Kind, Program, Storage, Value
from tests.by_hand.programs import Writer, program

ENTRIES = 6
_SOME = {
    FLOAT: ("add", "subtract", "multiply", "divide", "negate", "absolute", "square_root", "float_of_integer", "floor"),
    INTEGER: ("add_integers", "subtract_integers", "and", "xor", "modulo", "floor_divide", "integer_of_truth"),
    TRUTH: ("less", "less_equal_integers", "equal_integers", "both", "either", "not", "differ"),
}
_CONSTANTS: dict[Kind, tuple[Any, ...]] = {
    FLOAT: (0.0, -1.5, 2.0, 0.3), INTEGER: (0, 1, -3, 5, 2), TRUTH: (True, False)
}  # fmt: skip


class RandomProgram:
    """A program of an integer, arrays of floats, integers and truth values, and a table that is only read."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.functions: list[Function] = []
        for number in range(2):
            self.functions.append(self._function(f"helper_{number}"))
        self.table = Storage(FLOAT, ENTRIES, False, "table")
        self.number = Value(INTEGER, "run")
        arrays = [Storage(kind, ENTRIES, True, kind.value) for kind in Kind]
        self.w = Writer("entry", self.number, *arrays, self.table)
        self._begin(self.w, arrays, [self.number])
        self._region(3)
        self.program: Program = program(*self.functions, self.w.function)

    def _begin(self, w: Writer, arrays: list[Storage], values: list[Value]) -> None:
        self.w, self.arrays, self.values, self.loops, self.tabled = w, arrays, [*values], 0, w.function.name == "entry"
        self.variables = [w.variable(kind, "v") for kind in (FLOAT, FLOAT, INTEGER, TRUTH)]
        self.left = 40  # statements

    def _function(self, name: str) -> Function:
        parameters = [Value(FLOAT, "x"), Value(INTEGER, "n"), Value(TRUTH, "t")]
        array = Storage(FLOAT, 3, True, "part")
        results = (FLOAT, INTEGER) if self.random.random() < 0.7 else (FLOAT,)
        w = Writer(name, *parameters, array, results=results, inline=self.random.random() < 0.5)
        self._begin(w, [array], list(parameters))
        self._region(2)
        self._return()
        return w.function

    # -- numbers ---------------------------------------------------------------------------------------------------

    def _pick(self, kind: Kind) -> Any:
        """A number of a kind: one that is known here, a variable's, or a constant."""
        known = [value for value in self.values if value.kind is kind]
        choice = self.random.random()
        if known and choice < 0.6:
            return self.random.choice(known[-6:])
        variables = [variable for variable in self.variables if variable.kind is kind]
        if variables and choice < 0.85:
            return self.w.get(self.random.choice(variables))
        return self.random.choice(_CONSTANTS[kind])

    def _compute(self) -> None:
        kind = self.random.choice(list(Kind))
        if self.random.random() < 0.2:
            test = self._pick(TRUTH)
            test = self.w.do("likely", test) if self.random.random() < 0.5 else test
            made = self.w.do("select", test, self._pick(kind), self._pick(kind))
        else:
            name = self.random.choice(_SOME[kind])
            made = self.w.do(name, *(self._pick(k) for k in OPERATIONS[name].operands if k))
        self.values.append(made)

    def _index(self, length: int) -> Any:
        if self.random.random() < 0.5:
            return self.random.randrange(length)
        return self.w.do("modulo", self._pick(INTEGER), length)

    # -- statements ------------------------------------------------------------------------------------------------

    def _region(self, depth: int) -> None:
        known = len(self.values)
        for _ in range(self.random.randint(2, 6)):
            if self.left <= 0:
                break
            self.left -= 1
            self._statement(depth)
        del self.values[known:]

    def _statement(self, depth: int) -> None:
        choice = self.random.random()
        if choice < 0.4:
            self._compute()
        elif choice < 0.55:
            variable = self.random.choice(self.variables)
            self.w.set(variable, self._pick(variable.kind))
        elif choice < 0.63:
            arrays = [*self.arrays, self.table] if self.tabled and hasattr(self, "table") else self.arrays
            array = self.random.choice(arrays)
            self.values.append(self.w.load(array, self._index(array.length or 1)))
        elif choice < 0.72:
            array = self.random.choice(self.arrays)
            self.w.store(array, self._index(array.length or 1), self._pick(array.entry))
        elif choice < 0.78 and self.tabled:
            self._call()
        elif depth:
            self._nested(depth)

    def _call(self) -> None:
        function = self.random.choice(self.functions)
        part = self.w.view(self.arrays[0], self._index(4), 3)
        numbers = [self._pick(kind) for kind in (FLOAT, INTEGER, TRUTH)]
        self.values += self.w.call(function, *numbers, part)

    def _nested(self, depth: int) -> None:
        choice = self.random.random()
        if choice < 0.5:
            with self.w.when(self._pick(TRUTH)) as otherwise:
                self._region(depth - 1)
                self._jump()
            if self.random.random() < 0.6:
                with self.w.into(otherwise):
                    self._region(depth - 1)
                    self._jump()
            return
        self.loops += 1
        if choice < 0.8:
            last = self._pick(INTEGER)
            last = self.w.do("modulo", last, 5) if isinstance(last, Value) else 3
            with self.w.count(
                *((0, last) if self.random.random() < 0.5 else (last, -3)),
                self.random.choice((1, 2)) if self.random.random() < 0.5 else -2,
            ) as i:
                self.values.append(i)
                self._region(depth - 1)
                self.values.remove(i)
        else:
            self._while(depth)
        self.loops -= 1

    def _while(self, depth: int) -> None:
        turns = self.w.variable(INTEGER, "turns")
        self.w.set(turns, 0)
        test: list[Any] = []
        with self.w.into(test):
            turn = self.w.get(turns)
            self.w.set(turns, self.w.do("add_integers", turn, 1))
            more = self.w.do("both", self.w.do("less_integers", turn, 5), self._pick(TRUTH))
        with self.w.loop(test, more):
            self._region(depth - 1)

    def _jump(self) -> None:
        choice = self.random.random()
        if choice < 0.2 and self.loops:
            self.w.stop()
        elif choice < 0.35 and self.loops:
            self.w.skip()
        elif choice < 0.5:
            self._return()

    def _return(self) -> None:
        self.w.leave(*(self._pick(kind) for kind in self.w.function.results))


def random_arrays(seed: int) -> list[Any]:
    """Arrays for a random program."""
    numbers = np.random.default_rng(seed)
    return [
        np.round(numbers.normal(size=ENTRIES), 2),
        numbers.integers(-4, 5, ENTRIES),
        numbers.integers(0, 2, ENTRIES).astype(bool),
        np.round(numbers.normal(size=ENTRIES), 1),
    ]
