"""A function of Python as machine code of ours, called with what the function itself is called with."""

import functools
from collections.abc import Callable, Hashable
from typing import Any

import numpy as np

from proofmass.runner.program.build import Builder, operand
from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, Kind, Storage, Value
from proofmass.runner.program.lower import call, outcome, program
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.program.structure import leaves, mapped, rebuilt, shape_of
from proofmass.runner.targets.machine_code import Settings, load
from tests.by_hand.verify_program import verify

KINDS: dict[Any, Kind] = {float: FLOAT, int: INTEGER, bool: TRUTH}


@functools.cache
def compiled(function: Any, settings: Settings = Settings(level=1)) -> Callable[..., Any]:  # noqa: B008
    """The function, compiled anew for each kind of arguments. NumPy arrays are worked on in place."""
    made: dict[Hashable, Any] = {}

    def called(*arguments: Any) -> Any:
        example = tuple(map(_example, arguments))
        shape = shape_of(example)
        if shape not in made:
            made[shape] = _made(function, example, settings)
        loop, result = made[shape]
        parts = list(_parts(arguments))
        floats = np.array([part for part in parts if isinstance(part, float)] or [0.0])
        integers = np.array([int(p) for p in parts if isinstance(p, int)] or [0], dtype=np.int64)
        arrays = [part for part in parts if isinstance(part, np.ndarray)]
        kinds = [leaf.kind for leaf in leaves(result)]
        given = [floats, integers, np.zeros(len(kinds) + 1), np.zeros(len(kinds) + 1, dtype=np.int64), *arrays]
        loop(*(array.ctypes.data for array in given))
        types = {FLOAT: float, INTEGER: int, TRUTH: bool}
        return rebuilt(result, (types[kind](given[2 if kind is FLOAT else 3][i]) for i, kind in enumerate(kinds)))

    return called


def _example(argument: Any) -> Any:
    """A value of a program of the same shape."""
    if isinstance(argument, np.ndarray):
        return Storage(FLOAT if argument.dtype == np.float64 else INTEGER, len(argument), True)
    if isinstance(argument, tuple):
        parts = map(_example, argument)
        return type(argument)._make(parts) if hasattr(argument, "_make") else tuple(parts)  # type: ignore[attr-defined]
    return Value(KINDS[type(argument)]) if type(argument) in KINDS else argument


def _parts(argument: Any) -> Any:
    if isinstance(argument, tuple):
        for part in argument:
            yield from _parts(part)
    elif isinstance(argument, float | int | np.ndarray):
        yield argument


def _made(function: Any, example: Any, settings: Settings) -> Any:
    """The loaded function, and the structure of its result."""
    builder = Builder("entry")
    floats, integers = builder.array(FLOAT, None, "floats"), builder.array(INTEGER, None, "integers")
    numbers = builder.array(FLOAT, None, "numbers", True), builder.array(INTEGER, None, "whole", True)
    counts = {FLOAT: 0, INTEGER: 0}

    def given(leaf: Any) -> Any:
        if isinstance(leaf, Storage):
            return builder.array(leaf.entry, leaf.length, "array", True)
        kind = FLOAT if leaf.kind is FLOAT else INTEGER
        counts[kind] += 1
        return as_kind(builder, builder.load(floats if kind is FLOAT else integers, counts[kind] - 1), leaf.kind)

    arguments = mapped(example, given)
    result = (
        function.written(builder, arguments) if hasattr(function, "written") else call(builder, function, arguments)
    )
    for place, leaf in enumerate(leaves(result)):
        into = numbers[0] if leaf.kind is FLOAT else numbers[1]
        builder.store(into, place, as_kind(builder, leaf, into.entry))
    written = program(builder.function())
    verify(written)
    return load(written, settings), result


def over_columns(function: Any, *columns: Any, before: tuple[Any, ...] = ()) -> list[np.ndarray]:
    """Columns of what a function gives for each row of columns of numbers; `before` are arguments of every row.

    For a function of a user the last column says whether it failed.
    """
    example, length = tuple(map(_example, before)), len(columns[0])
    builder = Builder("columns")
    count = builder.parameter(INTEGER, "count")
    floats, integers = builder.array(FLOAT, None, "floats"), builder.array(INTEGER, None, "integers")
    numbers = list(_parts(before))
    places = {FLOAT: iter(range(len(numbers))), INTEGER: iter(range(len(numbers)))}

    def given(leaf: Any) -> Any:
        kind = FLOAT if leaf.kind is FLOAT else INTEGER
        return as_kind(builder, builder.load(floats if kind is FLOAT else integers, next(places[kind])), leaf.kind)

    first = mapped(example, given)
    kinds = [FLOAT if column.dtype == np.float64 else INTEGER for column in columns]
    taken = [builder.array(kind, None, f"column_{i}") for i, kind in enumerate(kinds)]
    into: list[Storage] = []
    with builder.counted(0, count) as row:
        row_of = (*first, *(builder.load(column, row) for column in taken))
        if hasattr(function, "written"):
            result = function.written(builder, row_of)
        elif hasattr(function, "checked"):
            value, fault = outcome(builder, function, row_of)
            result = value, operand(False) if fault is None else fault
        else:
            result = call(builder, function, row_of)
        for i, leaf in enumerate(leaves(result)):
            kind = FLOAT if leaf.kind is FLOAT else INTEGER
            into.append(builder.array(kind, None, f"result_{i}", True))
            builder.store(into[-1], row, as_kind(builder, leaf, kind))
    written = program(builder.function())
    verify(written)
    made = [np.zeros(length, dtype=np.float64 if array.entry is FLOAT else np.int64) for array in into]
    every = (
        np.array([part for part in numbers if isinstance(part, float)] or [0.0]),
        np.array([int(part) for part in numbers if isinstance(part, int)] or [0], dtype=np.int64),
        *map(np.ascontiguousarray, columns),
        *made,
    )
    load(written)(length, *(array.ctypes.data for array in every))
    return made
