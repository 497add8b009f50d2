"""A function of numbers, compiled and applied to every entry of arrays; the bits are those of the function."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.runner.program.generate import Generated
from proofmass.runner.program.pieces import Slots
from proofmass.runner.targets.compile import load
from proofmass.runner.targets.native import Array, dtype_of

_RESULT = "result"


class Elementwise:
    """Calls as NumPy's own functions do: arguments of any shapes that suit each other."""

    def __init__(self, function: Callable[..., Any], arguments: Mapping[str, type], result: type) -> None:
        self._function, self._arguments, self._result = function, arguments, result

    def __call__(self, *arguments: Any) -> Array:
        shape = np.broadcast_shapes(*map(np.shape, arguments))
        every = [np.empty(shape, dtype=dtype_of(kind)) for kind in self._arguments.values()]
        for column, given in zip(every, arguments, strict=True):
            column[...] = given
        result = np.empty(shape, dtype=dtype_of(self._result))
        self._loop(result.size, *(each.ctypes.data for each in every), result.ctypes.data)
        return result

    @cached_property
    def _loop(self) -> Any:
        names = [*self._arguments, _RESULT]
        call = f"apply({', '.join(f'{name}[entry]' for name in self._arguments)})"
        lines = [
            f"def loop(count, {', '.join(names)}):",
            *(f"    {name} = carray({name}, (count,))" for name in names),
            "    for entry in range(count):",
            f"        {_RESULT}[entry] = {call}",
        ]
        nothing, source = Slots[Any](""), "\n".join(lines) + "\n"
        called = {"apply": self._function}
        # As with lanes, in vectors as wide as the processor has them.
        generated = Generated(source, called, nothing, {}, nothing, (), (), 0, (), frozenset(), (), lanes=1)
        kinds = (*self._arguments.values(), self._result)
        return load(generated, ("int", *(f"{kind.__name__}*" for kind in kinds)))
