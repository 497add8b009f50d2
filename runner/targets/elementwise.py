"""A function of numbers, compiled and applied to every entry of arrays; the bits are those of the function."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, INTEGER
from proofmass.runner.program.lower import call, program
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.targets.machine_code import Settings, load
from proofmass.runner.targets.native import dtype_of

_KINDS = {float: FLOAT, int: INTEGER, bool: INTEGER}


class Elementwise:
    """Calls as NumPy's own functions do: arguments of any shapes that suit each other."""

    def __init__(self, function: Callable[..., Any], arguments: Mapping[str, type], result: type) -> None:
        self._function, self._arguments, self._result = function, arguments, result

    def __call__(self, *arguments: Any) -> AnyArray:
        shape = np.broadcast_shapes(*map(np.shape, arguments))
        every = [np.empty(shape, dtype=dtype_of(kind)) for kind in self._arguments.values()]
        for column, given in zip(every, arguments, strict=True):
            column[...] = given
        result = np.empty(shape, dtype=dtype_of(self._result))
        self._loop(result.size, *(each.ctypes.data for each in every), result.ctypes.data)
        return result

    @cached_property
    def _loop(self) -> Any:
        builder = Builder("loop", self._function.__name__)
        count = builder.parameter(INTEGER, "count")
        given = [builder.array(_KINDS[kind], None, name) for name, kind in self._arguments.items()]
        result = builder.array(_KINDS[self._result], None, "result", writable=True)
        with builder.counted(0, count, 1, "entry") as entry:
            value = call(builder, self._function, [builder.load(array, entry) for array in given])
            builder.store(result, entry, as_kind(builder, value, result.entry))
        return load(program(builder.function()), Settings(wide=True))
