"""Checks of a block's functions: what compiled code cannot take, and what they remember outside their state."""

import random
from collections.abc import Iterator
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.language.forms import driven_problems, problems_of
from proofmass.runner.contract.declared import PERIOD, made
from proofmass.runner.contract.drawn import random_value
from proofmass.runner.contract.places import problem
from proofmass.runner.contract.verdict import ContractVerdict, verdict
from proofmass.runner.output.counts import count

_TIMES = 8  # that a function which runs before the first tick is called anew


def compiled(kind: type[Block]) -> ContractVerdict:
    """Everything in its functions is part of what compiled code can take."""
    count_of = len(kind.output_functions) + len(kind.functions) + len(kind.events) + len(kind.corners)
    detail = f"{count(count_of, 'function')} within what compiled code takes"
    if not problems_of(kind) and driven_problems(kind):
        first = driven_problems(kind)[0]
        detail += f"; no wire can drive its parameters: {first.key}, line {first.line}: {first.message}"
    return verdict("functions", problems_of(kind), detail)


def repeatable(kind: type[Block]) -> ContractVerdict:
    """The functions that run before the first tick give the same for the same parameters, whatever ran before."""
    named = {name: behaviour for name, behaviour in kind.functions.items() if name in ("constants", "formats")}

    def problems() -> Iterator[Problem]:
        for name, behaviour in named.items():
            difference = _differs(kind, behaviour.function, ("period",) if "period" in behaviour.arguments else ())
            if difference:
                message = f"{name} gives another result when it is called again"
                hint = "let it follow from its arguments alone; what a block remembers is its state"
                yield problem(kind, behaviour.function.__name__, message, got=difference, hint=hint)

    return verdict("purity", problems(), _said(len(named)))


def _said(functions: int) -> str:
    return f"{count(functions, 'function')} give the same again" if functions else "nothing runs before the first tick"


def _differs(kind: type[Block], function: Any, more: tuple[str, ...]) -> str:
    """Return two results for the same parameters, or ""."""
    dice, first = random.Random(kind.__name__), dict[int, str]()
    drawn = [{name: random_value(p, dice) for name, p in kind.parameters.items()} for _ in range(_TIMES)]
    blocks = [block for block in (made(kind, values) for values in drawn) if block is not None]
    for _ in range(2):
        for number, block in enumerate(blocks):
            try:
                value = repr(function(block, *(PERIOD for _ in more)))
            except (ArithmeticError, ValueError) as error:  # a plan reports it, with parameters
                value = repr(error)
            if first.setdefault(number, value) != value:
                return f"{first[number]}, then {value}"
    return ""
