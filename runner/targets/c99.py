"""A program as readable C99, with no library but libm; the lines of Python stand beside what comes from them.

Compiled without contraction (`-ffp-contract=off`, as `-std=c99` has it anyway) it computes the bits
of the reference.
"""

import math
from collections.abc import Iterator, Sequence

from proofmass.runner.program import form
from proofmass.runner.program.listing import COLUMN, ListedFunction
from proofmass.runner.program.names import ProgramNames
from proofmass.runner.program.walk import statements
from proofmass.runner.targets.c99_operations import CALLED, HELPERS, INFIX, RESERVED, TYPES

_ZEROS = {form.FLOAT: "0.0", form.INTEGER: "0", form.TRUTH: "false"}
_PLAIN = 2**31  # integers below need no suffix


def c99_text(program: form.Program, name: str = "") -> str:
    """The translation unit of a program; its entry has this `name`, or the program's."""
    names = _function_names(program, name)
    functions = [_FunctionOfC(function, names) for function in program.functions.values()]
    bodies = ["\n".join(function.lines()) for function in functions]
    helpers = {helper for function in functions for helper in function.helpers}
    externals = {external: None for function in functions for external in function.externals}
    head = ["#include <math.h>", "#include <stdbool.h>", "#include <stdint.h>", "#include <string.h>", ""]
    parts = [text for helper, text in HELPERS.items() if helper in helpers]
    return "\n".join([*head, *map(_declared, externals), *parts, *bodies])


def _function_names(program: form.Program, entry: str) -> dict[form.Function, str]:
    """A name in C for each function; the entry has its own."""
    entry = entry or program.entry.name
    taken = ProgramNames([*RESERVED, entry])
    return {f: entry if f is program.entry else taken.free(f.name) for f in program.functions.values()}


def _declared(external: form.External) -> str:
    """A function of another library: one that a compiler must call, not replace by what it takes for the same."""
    kinds = ", ".join(TYPES[kind] for kind in external.parameters) or "void"
    returned = "void" if external.result is None else TYPES[external.result]
    if external.address is None:
        return f"static {returned} (*const volatile c_{external.symbol})({kinds}) = {external.symbol};\n"
    return f"extern {returned} {external.symbol}({kinds});\n"


class _FunctionOfC(ListedFunction):
    """One function; what is read once becomes a part of the expression that reads it."""

    bracketed = frozenset((*INFIX, "select", "negate"))
    nothing: Sequence[str] = ()
    opens, otherwise, closes, ends, always, leaves = " {", "} else {", "}", ";", "(true)", "if (!{}) break;"

    def __init__(self, function: form.Function, functions: dict[form.Function, str]) -> None:
        super().__init__(function, [*RESERVED, *functions.values()])
        self.functions = functions
        self.is_entry = function is list(functions)[-1]
        self.helpers: set[str] = set()
        self.externals = list(dict.fromkeys(_externals(function)))
        for external in self.externals:
            self.names.free(f"c_{external.symbol}")

    def lines(self) -> Iterator[str]:
        """Definition of the function."""
        function, name = self.function, self.functions[self.function]
        if len(function.results) > 1:
            yield from _structure(name, function)
        parameters = ", ".join(map(self._parameter, function.parameters)) or "void"
        if function.origin:
            yield f"/* {function.origin} */"
        how = "" if self.is_entry else "static inline " if function.inline else "static "
        yield f"{how}{_returned(name, function)} {name}({parameters})"
        yield "{"
        for variable in function.variables:
            yield f"    {TYPES[variable.kind]} {self.names[variable]} = {_ZEROS[variable.kind]};"
        yield from self._region(function.body)
        yield "}"
        yield ""

    def _parameter(self, parameter: form.Value | form.Storage) -> str:
        if isinstance(parameter, form.Value):
            return f"{TYPES[parameter.kind]} {self.names[parameter]}"
        restrict = "restrict " if self.is_entry else ""
        return f"{_pointer(parameter)}{restrict}{self.names[parameter]}"

    # -- statements --------------------------------------------------------------------------------

    def _defined(self, result: form.Value, text: str) -> str:
        return f"const {TYPES[result.kind]} {self.names[result]} = {text};"

    def _assigned(self, place: str, value: form.Operand) -> str:
        return f"{place} = {self._operand(value)};"

    def _view(self, statement: form.View) -> str:
        part, whole = statement.part, statement.whole
        return f"{_pointer(part)}{self.names[part]} = {self.names[whole]} + {self._operand(statement.first)};"

    def _counted(self, statement: form.For) -> str:
        i, first, last = self.names[statement.counter], self._operand(statement.first), self._operand(statement.last)
        sign = "<" if statement.step > 0 else ">"
        if statement.step in (1, -1):
            return f"(int64_t {i} = {first}; {i} {sign} {last}; {i}{'++' if statement.step > 0 else '--'})"
        if isinstance(statement.last, form.Immediate) and abs(statement.last.value + statement.step) < 2**63:
            return f"(int64_t {i} = {first}; {i} {sign} {last}; {i} += {self._number(statement.step)})"
        self.helpers |= {"add_integers", "subtract_integers"}
        more, (high, low) = self.names.free("more"), (last, i) if statement.step > 0 else (i, last)
        left = f"(uint64_t)subtract_integers({high}, {low}) > UINT64_C({abs(statement.step)})"
        step = f"{more} = {left}, {i} = add_integers({i}, {self._number(statement.step)})"
        return f"(int64_t {i} = {first}, {more} = {i} {sign} {last}; {more}; {step})"

    def _returned(self, values: Sequence[form.Operand]) -> str:
        if len(values) < 2:
            return f"{super()._returned(values)};"
        texts = ", ".join(map(self._alone, values))
        return f"return ({self.functions[self.function]}_results){{{texts}}};"

    def _call(self, statement: form.Call) -> Iterator[str]:
        function, results, read = statement.function, statement.results, self._arguments(statement)
        if isinstance(function, form.External):
            name = function.symbol if function.address is not None else f"c_{function.symbol}"
        else:
            name = self.functions[function]
        if not results:
            yield f"{name}({read});"
        elif len(results) == 1:
            yield self._defined(results[0], f"{name}({read})")
        else:
            several = self.names.free(f"of_{name}")
            yield f"const {name}_results {several} = {name}({read});"
            for place, result in enumerate(results):
                yield self._defined(result, f"{several}.result_{place}")

    # -- expressions -------------------------------------------------------------------------------

    def _operation(self, statement: form.Compute) -> str:
        operation, read = statement.operation, [self._operand(operand) for operand in statement.operands]
        if operation in INFIX:
            return f"{read[0]} {INFIX[operation]} {read[1]}"
        if operation == "select":
            return f"{read[0]} ? {read[1]} : {read[2]}"
        if operation == "likely":
            return read[0]
        if operation == "negate":
            return f"-({read[0]})" if read[0].startswith("-") else f"-{read[0]}"
        if operation in HELPERS:
            self.helpers.add(operation)
        return f"{CALLED.get(operation, operation)}({', '.join(map(_bare, read))})"

    def _alone(self, operand: form.Operand) -> str:
        return _bare(self._operand(operand))

    def _condition(self, operand: form.Operand) -> str:
        return f"({self._alone(operand)})"

    def _number(self, value: float | int | bool) -> str:
        """A number as C has it."""
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, float):
            if math.isfinite(value):
                return repr(value)
            return "NAN" if math.isnan(value) else "INFINITY" if value > 0.0 else "-INFINITY"
        if value == -(2**63):
            return "INT64_MIN"
        return str(value) if abs(value) < _PLAIN else f"INT64_C({value})"

    def _beside(self, line: str, remark: str) -> str:
        for mark, plain in (("*/", "* /"), ("/*", "/ *"), ("??", "? ?")):
            remark = remark.replace(mark, plain)
        return f"{line:{COLUMN - 4}}/* {remark} */"


def _bare(text: str) -> str:
    """An expression without the parentheses round all of it."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if not depth:
            return text[1:-1] if place == len(text) - 1 else text
    return text


def _pointer(array: form.Storage) -> str:
    return f"{'' if array.writable else 'const '}{TYPES[array.entry]} *"


def _returned(name: str, function: form.Function) -> str:
    if len(function.results) > 1:
        return f"{name}_results"
    return TYPES[function.results[0]] if function.results else "void"


def _structure(name: str, function: form.Function) -> Iterator[str]:
    yield "typedef struct {"
    yield from (f"    {TYPES[kind]} result_{place};" for place, kind in enumerate(function.results))
    yield f"}} {name}_results;"
    yield ""


def _externals(function: form.Function) -> Iterator[form.External]:
    for statement in statements(function.body):
        if isinstance(statement, form.Call) and isinstance(statement.function, form.External):
            yield statement.function
