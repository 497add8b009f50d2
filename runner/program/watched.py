"""Wires that the compiled loop checks for numbers that are not finite: those that would not pass them on.

An infinite number or NaN stays so through sums, products and numerators of quotients. A wire that a
block of the same rate uses only in such arithmetic needs no check, since the output of that block
is checked.
"""

from typing import Any

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.language.forms import form_of
from proofmass.graphs.checks.schedule import outputs_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Driven, Plan
from proofmass.runner.program.slots import fields


def watched(plan: Plan) -> frozenset[Endpoint]:
    """Outputs to check in every tick: if they are finite, so are those left out."""
    order = outputs_of(plan.schedule.order)
    solved = {node for loop in plan.schedule.loops for node in (*loop.tears, *loop.others)}
    # A number that is not finite there stays in the state of its group.
    of_groups = {node for solver in plan.solvers for node in solver.group.inputs}
    floats = {node for node in order if type(plan.blocks[node[0]]).outputs[node[1]].dtype is float}
    passed, plain = set[Endpoint](), floats - solved
    for node in plain:
        block, beat = plan.blocks[node[0]], plan.beat(node)
        if type(block).outputs[node[1]].shape or type(block).has_formats():
            continue
        behaviour = type(block).output_functions[node[1]]
        for argument, meaning in zip(behaviour.arguments, behaviour.meanings, strict=True):
            driver = plan.schedule.drivers.get((node[0], argument))
            if (
                meaning is Meaning.INPUT
                and driver in plain
                and plan.beat(driver) == beat
                and passes_on(block, node[1], argument, plan.constants[node[0]])
            ):
                passed.add(driver)
    return frozenset(floats - passed - of_groups)


def passes_on(block: Block, port: str, argument: str, constants: Any) -> bool:
    """Return whether an output is not finite whenever that argument is not, for any values of the other floats."""
    output, constants_class = type(block).output_functions[port], type(block).constants_class()
    constant_values = {
        f: _Number() if kind is float or isinstance(constants, Driven) else getattr(constants, f)
        for f, kind in fields(constants_class)
    }
    state = type(block).state_class()
    x = state and state(*(_Number() for _ in fields(state)))
    numbers: dict[str, Any] = {
        name: x if meaning is Meaning.STATE else _NotFinite() if name == argument else _Number()
        for name, meaning in zip(output.arguments, output.meanings, strict=True)
    }
    form = form_of(type(block), output)
    function: Any = output.function if form is None else form.function
    if any(value is breakpoint for value in function.__globals__.values()):
        return False  # the user wants to stop in a run, not here
    try:
        return isinstance(function(constants_class(**constant_values), *numbers.values()), _NotFinite)
    except Exception:  # the function compares a number, passes it to a library, or raises
        return False


class _Number:
    """A number of which nothing is known: arithmetic works, comparisons do not."""

    def _sum(self, other: object) -> "_Number":
        return other if isinstance(other, _NotFinite) else self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _sum

    def __truediv__(self, other: object) -> "_Number":
        return self

    def __rtruediv__(self, other: object) -> "_Number":
        return _Number()

    def __neg__(self) -> "_Number":
        return self

    def __eq__(self, other: object) -> bool:
        raise TypeError

    def __bool__(self) -> bool:
        raise TypeError

    __hash__ = None  # type: ignore[assignment]


class _NotFinite(_Number):
    """A number that is infinite or NaN: so are sums and products with it, and quotients of it."""

    def _sum(self, other: object) -> _Number:
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _sum
