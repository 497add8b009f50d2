"""Declarations of functions for LLVM: their names, attributes and results."""

from collections.abc import Collection

from proofmass.runner.program.form import Call, External, Function, Kind, Program
from proofmass.runner.program.walk import statements
from proofmass.runner.targets.llvm_operations import TYPES

ATTRIBUTES = (
    "attributes #0 = { nounwind }",
    "attributes #1 = { alwaysinline nounwind }",
    "attributes #2 = { nounwind willreturn memory(none) }",
    "attributes #3 = { nounwind }",
    "attributes #4 = { nounwind willreturn memory(inaccessiblemem: readwrite) }",
    "attributes #5 = { noinline nounwind }",
    "attributes #6 = { noinline nounwind noimplicitfloat }",  # no short vectors of numbers
)


def attributes_of(function: Function, shared: Collection[Function]) -> str:
    """Return the attributes of a function that another calls."""
    if function in shared:
        return "#6"
    return "#1" if function.inline else "#5"


def symbol_of(external: External) -> str:
    """The name that LLVM calls a function by; a library's is unknown to LLVM."""
    return external.symbol if external.address is not None else f"proofmass_{external.symbol}"


def externals(program: Program) -> dict[str, External]:
    """Functions of other libraries by the name that LLVM calls them by."""
    calls = (s.function for f in program.functions.values() for s in statements(f.body) if isinstance(s, Call))
    return {symbol_of(function): function for function in calls if isinstance(function, External)}


def result_type(results: tuple[Kind, ...]) -> str:
    """The type of what a function returns."""
    if not results:
        return "void"
    kinds = [TYPES[kind] for kind in results]
    return kinds[0] if len(kinds) == 1 else f"{{ {', '.join(kinds)} }}"


def declared(external: External) -> str:
    returned = "void" if external.result is None else TYPES[external.result]
    kinds = ", ".join(TYPES[kind] for kind in external.parameters)
    return f"declare {returned} @{symbol_of(external)}({kinds}) {'#2' if external.pure else '#3'}"
