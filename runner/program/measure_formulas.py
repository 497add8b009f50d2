"""The formulas of measures as a program, for those who have no Python: the bits are those of `derived_values`."""

from proofmass.graphs.formulas.operations import OPERATIONS
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.build import Builder, WrittenNumber, operand
from proofmass.runner.program.form import FLOAT, Program
from proofmass.runner.program.lower import call, program

_WRITTEN = {"+": "add", "-": "subtract", "*": "multiply", "/": "divide", "negative": "negate"}


def measure_formulas(plan: Plan) -> Program:
    """Return a program with one array: the measures of signals in their order, behind them those that it fills in."""
    builder = Builder("measure_formulas")
    values = builder.array(FLOAT, len(plan.measures) + len(plan.derived), "values", writable=True)

    def apply(operation: str, arguments: list[WrittenNumber | float]) -> WrittenNumber:
        given = [operand(each.value if isinstance(each, WrittenNumber) else each) for each in arguments]
        if operation in _WRITTEN:
            return WrittenNumber(builder, builder.compute(_WRITTEN[operation], *given))
        return WrittenNumber(builder, call(builder, OPERATIONS[operation].function, given))

    known = {m.name: WrittenNumber(builder, builder.load(values, at, m.name)) for at, m in enumerate(plan.measures)}
    for place, derived in enumerate(plan.derived, len(plan.measures)):
        known[derived.name] = derived.value(known, apply)
        value = known[derived.name]
        builder.store(values, place, value.value if isinstance(value, WrittenNumber) else value)
    return program(builder.function())
