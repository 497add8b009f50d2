"""Modules of the digital blocks of a planned graph; equal blocks share one."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NoReturn

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.machine.modules import Module, entries, make_module
from proofmass.runner.rtl.machine.words import VerilogNames, Word

_UNDER_WAY = object()


class BlockModules:
    """Makes the modules in order: a block comes after those whose plain integers, without a format, it reads."""

    def __init__(self, planned: Plan, paths: Sequence[str]) -> None:
        self.planned, self.paths = planned, paths
        self._made: dict[str, Any] = {}
        self._shared: dict[tuple[Any, ...], Module] = {}

    def named(self) -> dict[str, Module]:
        """The modules by the paths of their blocks; raises `ModelError` with every problem."""
        problems = []
        for path in self.paths:
            try:
                self._module(path)
            except ModelError as error:
                problems += [problem for problem in error.problems if problem not in problems]
        if problems:
            raise ModelError([self.planned.graph.placed(problem) for problem in problems])
        names, named = VerilogNames(), dict[int, Module]()
        for path in self.paths:
            module = self._made[path]
            if id(module) not in named:
                kind = _snake(type(module.block).__name__)
                alike = sum(type(other.block) is type(module.block) for other in self._shared.values())
                named[id(module)] = replace(module, name=names.add(kind if alike == 1 else f"{kind}_{path}"))
        return {path: named[id(self._made[path])] for path in self.paths}

    def _module(self, path: str) -> Module:
        module = self._made.get(path)
        if module is _UNDER_WAY:
            message = "integers go round in a loop, and their range cannot be told"
            self._refuse(path, message, "let a FixedValue go round: its format is the range")
        if module is None:
            self._made[path] = _UNDER_WAY
            try:
                module = self._made[path] = self._new(path)
            finally:
                if self._made[path] is _UNDER_WAY:
                    del self._made[path]
        return module

    def _new(self, path: str) -> Module:
        planned, block = self.planned, self.planned.blocks[path]
        kind, period = type(block), planned.block_period(path)
        constants: Any = block
        if "constants" in kind.functions:
            behaviour = kind.functions["constants"]
            constants = behaviour.function(block, *behaviour.named({"period": period}))
        ranges = self._ranges(path)
        key = (block, period if constants is not block else 0, tuple(sorted(ranges.items())))
        if key not in self._shared:
            buffers = {name: list(map(int, planned.buffers[path, name])) for name in kind.buffers}
            try:
                module = make_module(path, block, constants, planned.starts[path], buffers, ranges)
            except ModelError as error:
                at = ("blocks", path)
                raise ModelError([replace(p, key=f"blocks.{path}.{p.key}", path=at) for p in error.problems]) from error
            self._shared[key] = module
        return self._shared[key]

    def _ranges(self, path: str) -> dict[str, Word]:
        """Ranges of the plain integer inputs of a block."""
        ranges = {}
        for name, port in type(self.planned.blocks[path]).inputs.items():
            if port.dtype is int:
                source = self.planned.schedule.drivers.get((path, name))
                default = int(port.default or 0)
                ranges[name] = Word(default, default) if source is None else self._range(source)
        return ranges

    def _range(self, source: Endpoint) -> Word:
        """Range of a plain integer output: from its operations, or from a format."""
        block = self.planned.blocks[source[0]]
        if source[0] in self.paths:
            words = [port.word for port in entries(self._module(source[0]).outputs, source[1])]
            return Word(min(word.low for word in words), max(word.high for word in words))
        formats = type(block).functions["formats"].function(block) if "formats" in type(block).functions else {}
        if source[1] not in formats:
            self._refuse(
                source[0],
                f"how many bits {'.'.join(source)} has is not said",
                f'formats of the block may say it: return {{"{source[1]}": Fixed(12)}}',
            )
        return Word(formats[source[1]].lowest, formats[source[1]].highest)

    def _refuse(self, path: str, message: str, hint: str) -> NoReturn:
        raise Problem(message=message, hint=hint, path=("blocks", path)).error


def _snake(kind: str) -> str:
    """`"FixedPID"` is `"fixed_pid"`."""
    return "".join(
        f"_{c}" if c.isupper() and i and not kind[i - 1].isupper() else c for i, c in enumerate(kind)
    ).lower()
