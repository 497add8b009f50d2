"""The integer code of a step function, called with raw values: interpreted, or compiled by `tests.by_hand.compiled`."""

from collections.abc import Callable, Mapping
from typing import Any

from proofmass.runner.fixed.integer_code import integer_code
from proofmass.runner.fixed.step_formats import Formats
from proofmass.runner.fixed.trace import trace
from proofmass.runner.program.build import Builder, parameters_like
from proofmass.runner.program.form import Function, Program
from proofmass.runner.program.integer_step import call_step
from proofmass.runner.program.listing import listing
from proofmass.runner.program.lower import program
from proofmass.runner.program.structure import Lowered, leaves, rebuilt, shape_of
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.lowered import example, flat
from tests.by_hand.verify_program import verify


class Code:
    """The integer code of a step; `code` is that of the product."""

    def __init__(self, code: Any) -> None:
        self.code = code
        self._written: dict[Any, tuple[Program, Lowered]] = {}

    def written(self, builder: Builder, arguments: Any) -> Lowered:
        """Its call in a program, and what that gives."""
        result, beside = call_step(builder, self.code, arguments)
        return (result, *beside) if beside else result

    def function(self, *arguments: Any) -> tuple[Program, Lowered]:
        """The program that calls it, and the structure of what that gives."""
        given = tuple(map(example, arguments))
        if shape_of(given) not in self._written:
            builder = Builder("entry")
            result = self.written(builder, parameters_like(builder, "given", given))
            builder.give(*leaves((result,)))  # type: ignore[arg-type]
            made = program(builder.function())
            verify(Program({**made.functions, "outside": Function("outside", (), ())}))
            self._written[shape_of(given)] = made, result
        return self._written[shape_of(given)]

    def step(self, *arguments: Any) -> Function:
        """Its function in a program, which functions that are lowered may call."""
        return next(iter(self.function(*arguments)[0].functions.values()))

    def text(self, *arguments: Any) -> str:
        """The listing of its function for arguments like these, without lines of Python."""
        lines = listing(self.function(*arguments)[0]).partition("\n\n")[0].splitlines()
        return "\n".join(line.partition("  #")[0].rstrip() for line in lines)

    def __call__(self, *arguments: Any) -> Any:
        made, result = self.function(*arguments)
        return rebuilt((result,), evaluate(made.entry, *flat(arguments)))[0]


def compile_step(
    function: Callable[..., Any], formats: Mapping[str, Formats], *, count_overflows: bool = False
) -> Code:
    """The integer code of a step function; with `count_overflows` it gives how many casts saturated or wrapped, too."""
    traced = trace(function, formats)
    return Code(integer_code(traced, [traced.overflows] if count_overflows else []))
