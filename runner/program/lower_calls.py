"""Calls of Python's own functions, of `math`, of NamedTuples, and of lowered functions."""

import ast
import inspect
import math
import operator
import types
from collections.abc import Callable, Sequence
from typing import Any

from proofmass.blocks.arithmetic.rounding import likely
from proofmass.blocks.language import arithmetic
from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.values import is_record
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.program import lower_numbers as numbers
from proofmass.runner.program.form import FLOAT, INTEGER, OPERATIONS, TRUTH, External, Function, Operand, Storage
from proofmass.runner.program.lower_expressions import LoweredExpressions
from proofmass.runner.program.structure import Lowered, is_scalar, leaves

# Functions of numbers of the machine or the C library, by their names in C.
_OPERATIONS: dict[Any, str] = {math.sqrt: "square_root", math.fabs: "absolute", math.copysign: "copy_sign"}
_OPERATIONS |= {getattr(arithmetic, name): operation for name, operation in arithmetic.OF_MACHINES.items()}
_WHOLE: dict[Any, str] = {math.floor: "floor", math.ceil: "ceiling", math.trunc: "truncate", round: "round_half_even"}
LIBRARY: dict[Any, External] = {
    getattr(math, name): External(name, (FLOAT,), FLOAT)
    for name in (
        *("exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "erf", "erfc", "cbrt"),
        *("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
    )
}
LIBRARY |= {function: External(name, (FLOAT, FLOAT), FLOAT) for function, name in (
    (math.atan2, "atan2"),
    (math.fmod, "fmod"),
    (math.pow, "pow"),
)}  # fmt: skip
LIBRARY |= {
    function: External(name, (FLOAT,) * len(inspect.signature(function).parameters), FLOAT)
    for function, name in ((getattr(arithmetic, ours), name) for ours, name in arithmetic.OF_C.items())
}
_OPERATORS = {operator.add: ast.Add, operator.sub: ast.Sub, operator.mul: ast.Mult, operator.truediv: ast.Div}
_SCALED = {math.degrees: 180.0 / math.pi, math.radians: math.pi / 180.0}


class LoweredCalls(LoweredExpressions):
    """Reads calls."""

    def called(self, node: ast.AST, function: types.FunctionType, arguments: Sequence[Lowered]) -> Lowered:
        """Call a function that is lowered too."""
        raise NotImplementedError

    def _call(self, node: ast.Call) -> Lowered:
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            owner = self.expression(node.func.value)
            return owner._replace(**{str(k.arg): self.expression(k.value) for k in node.keywords})
        target = self.expression(node.func)
        arguments = list(map(self.expression, node.args))
        named = {str(keyword.arg): self.expression(keyword.value) for keyword in node.keywords}
        if named or is_record(target):
            arguments = self._in_order(node, target, arguments, named)
        return self.call(node, target, arguments)

    def _in_order(
        self, node: ast.Call, target: Any, arguments: Sequence[Lowered], named: dict[str, Lowered]
    ) -> list[Lowered]:
        """Put arguments into the order of the function's parameters, and fill in defaults."""
        try:
            bound = inspect.signature(target).bind(*arguments, **named)
        except (TypeError, ValueError) as error:
            raise refuse(node, f"{ast.unparse(node.func)}: {error}") from None
        bound.apply_defaults()
        return list(map(self.known, bound.arguments.values()))

    def _declared(self, declared: Any, value: Lowered) -> Lowered:
        """Convert a value to the declared type of its field or result."""
        wanted = numbers.KINDS.get(held_as(declared))
        return numbers.as_kind(self.builder, value, wanted) if wanted and is_scalar(value) else value

    def call(self, node: ast.AST, function: Any, arguments: Sequence[Lowered]) -> Lowered:
        if isinstance(function, Function):
            return self._program(function, arguments)
        if isinstance(function, Checked):
            value = self.call(node, function.value, arguments)
            self.note(self.call(node, function.fails, (value, *arguments) if function.by_value else arguments))
            return value
        if function is breakpoint:
            return None
        if is_record(function):
            pairs = zip(function._fields, arguments, strict=True)
            return function._make(self._declared(function.__annotations__.get(name), value) for name, value in pairs)
        hashable = callable(function) and function.__hash__
        if hashable and function in LIBRARY:
            return self.builder.call(LIBRARY[function], *(self._float(node, value) for value in arguments))[0]
        if hashable and function in _OPERATORS:
            return self.operated(node, _OPERATORS[function], *(self._scalar(node, value) for value in arguments))
        if function is likely:
            return self.builder.compute("likely", numbers.as_kind(self.builder, self._scalar(node, *arguments), TRUTH))
        if isinstance(function, types.FunctionType) and function not in _OPERATIONS:
            return self.called(node, function, arguments)
        result = self._own(node, function, arguments) if callable(function) else None
        if result is None:
            name = getattr(function, "__name__", type(function).__name__)
            raise refuse(node, f"{name}() is not compiled", f"write {name} as a function of your own, of numbers")
        return result

    def _program(self, function: Function, arguments: Sequence[Lowered]) -> Lowered:
        """Call a function that belongs to the program already."""
        self.functions.append(function.name)
        results = self.builder.call(function, *leaves(tuple(arguments)))
        return results[0] if len(results) == 1 else results or None

    def _float(self, node: ast.AST, value: Lowered) -> Operand:
        return numbers.as_kind(self.builder, self._scalar(node, value), FLOAT)

    def _own(self, node: ast.AST, function: Any, arguments: Sequence[Lowered]) -> Lowered | None:
        """Call one of Python's own functions."""
        if function in (min, max) and len(arguments) == 1 and isinstance(arguments[0], tuple):
            arguments = arguments[0]
        if function in (min, max):
            return self._extreme(function is max, [self._scalar(node, value) for value in arguments])
        if function is len and isinstance(arguments[0], tuple):
            return self.known(len(arguments[0]))
        if function is len and isinstance(arguments[0], Storage) and arguments[0].length is not None:
            return self.known(arguments[0].length)
        if function in _OPERATIONS:
            operation = _OPERATIONS[function]
            pairs = zip(OPERATIONS[operation].operands, arguments, strict=True)
            values = [numbers.as_kind(self.builder, self._scalar(node, value), kind or FLOAT) for kind, value in pairs]
            return self.builder.compute(operation, *values)
        return self._of_one(function, self._scalar(node, arguments[0])) if len(arguments) == 1 else None

    def _of_one(self, function: Any, value: Operand) -> Operand | None:
        if function in numbers.KINDS:
            return numbers.as_kind(self.builder, value, numbers.KINDS[function])
        if function is abs:
            return numbers.absolute(self.builder, value)
        if function is operator.neg:
            return numbers.negated(self.builder, value)
        if function in _WHOLE:
            if value.kind is not FLOAT:
                return numbers.as_kind(self.builder, value, INTEGER)
            return numbers.rounded_to_integer(self.builder, _WHOLE[function], value)
        number = numbers.as_kind(self.builder, value, FLOAT)
        if function in _SCALED:
            return self.builder.compute("multiply", number, _SCALED[function])
        looked = _LOOKS.get(function)
        return looked(self.builder.compute, number) if looked else None

    def _extreme(self, largest: bool, values: Sequence[Operand]) -> Operand:
        """The first of the least or greatest values, compared as Python compares them."""
        best, *others = numbers.agreed(self.builder, *values)
        operation = "less" if best.kind is FLOAT else "less_integers"
        for other in others:
            pair = (best, other) if largest else (other, best)
            best = self.chosen(self.builder.compute(operation, *pair), other, best)
        return best


_LOOKS: dict[Any, Callable[[Any, Operand], Operand]] = {
    math.isnan: lambda compute, value: compute("not_equal", value, value),
    math.isinf: lambda compute, value: compute("equal", compute("absolute", value), math.inf),
    math.isfinite: lambda compute, value: compute("less", compute("absolute", value), math.inf),
}
