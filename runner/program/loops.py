"""Algebraic loops in a program: a function of their equations, and the call of the solver."""

from collections.abc import Callable
from functools import partial
from typing import Any

from proofmass.graphs.checks.schedule import AlgebraicLoop
from proofmass.runner.continuous.algebraic import scratch, solve
from proofmass.runner.program.build import operand, parameters_like
from proofmass.runner.program.form import FLOAT, Function, Operand, Storage
from proofmass.runner.program.frame import Frame
from proofmass.runner.program.lower import call
from proofmass.runner.program.structure import Lowered


class LoopWriter:
    """Writes one loop, which is solved once a tick or at the instants within it."""

    def __init__(self, loop: AlgebraicLoop, name: str, work: Callable[[str, int], Storage]) -> None:
        self.tears, self.others, self.name = loop.tears, loop.others, name
        n = len(loop.tears)
        self.arrays: tuple[Storage, ...] = (work(f"{name}_unknown", n),)
        self.arrays += tuple(work(f"{name}_work_{i}", length) for i, length in enumerate(scratch(n)))

    def solve(self, frame: Frame, arrays: tuple[Storage, ...] = ()) -> None:
        """Solve for the tears, starting from their present values; `arrays` are scratch."""
        builder = frame.builder
        unknown, *work = arrays or self.arrays
        for i, tear in enumerate(self.tears):
            builder.store(unknown, i, frame.wire(tear))
        inner = _Within(frame, self.name)
        equations = self._equations(inner)
        call(builder, solve, (equations, tuple(inner.context), unknown, tuple(work)))
        for i, tear in enumerate(self.tears):
            frame.put(tear, builder.load(unknown, i))

    def _equations(self, frame: "_Within") -> Function:
        """Compute the tears from assumed ones; not finite if a value in between is not."""
        builder, n = frame.builder, len(self.tears)
        unknown = Storage(FLOAT, n, True, "unknown")
        values = Storage(FLOAT, n, True, "found")
        total: Operand = operand(0.0)
        for i, tear in enumerate(self.tears):
            frame.put(tear, builder.load(unknown, i))
        for node in self.others:
            value = frame.number(frame.call(*node))
            frame.put(node, value)
            total = builder.compute("add", total, builder.compute("multiply", 0.0, value))
        for i, tear in enumerate(self.tears):
            value = frame.number(frame.call(*tear))
            known = builder.compute("equal", total, 0.0)
            builder.store(values, i, builder.compute("select", known, value, total))
        builder.parameters += [unknown, values]
        return builder.function()


class _Within(Frame):
    """The equations of a loop; all that they read from outside it becomes parameters and is passed as context."""

    def __init__(self, outer: Frame, name: str) -> None:
        super().__init__(outer.plan, outer.builder.beside(f"{name}_equations"))
        self.context: list[Lowered] = []
        self.outer = outer
        self.time, self.tick = self._taken("time", outer.time), self._taken("tick", outer.tick)
        for name in ("wires", "states", "constants", "parameters", "periods", "deviates"):
            setattr(self, name, _Taken(partial(self._read, name)))

    def _read(self, name: str, key: Any) -> Lowered:
        return self._taken(
            "_".join(key) if isinstance(key, tuple) else key, self.outer.now(getattr(self.outer, name)[key])
        )

    def _taken(self, name: str, value: Lowered) -> Lowered:
        if value is None or (isinstance(value, tuple) and not value):
            return value
        self.context.append(value)
        return parameters_like(self.builder, name, value)


class _Taken(dict[Any, Lowered]):
    """A mapping that takes an entry from outside when it is first asked for."""

    def __init__(self, take: Callable[[Any], Lowered]) -> None:
        super().__init__()
        self._take = take

    def __missing__(self, key: Any) -> Lowered:
        self[key] = self._take(key)
        return self[key]
