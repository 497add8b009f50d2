"""Blocks whose functions compare moving numbers, as `if input > 0.0`, and may have corners that they do not declare."""

from functools import cache
from typing import Any

from proofmass.blocks import arithmetic
from proofmass.blocks.arithmetic import rounding
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.plan.constants import constants_of


@cache
def looks_at_numbers(block: Block) -> bool:
    """Return whether an output or derivative of the block compares a signal, a state or the time with something.

    A block that declares corners or events is trusted, and so is an output that ends a run (`no_value`).
    """
    kind = type(block)
    if kind.corners or kind.events:
        return False
    behaviours = [b for port, b in kind.output_functions.items() if not kind.outputs[port].no_value]
    behaviours += [kind.functions["derivative"]] if "derivative" in kind.functions else []
    known = constants_of(block, block, 1.0)
    return any(_looks(block, known, behaviour) for behaviour in behaviours)


def _looks(block: Block, constants: Any, behaviour: Behaviour) -> bool:
    state = type(block).state_class()
    x = state and state(*(_Number() for _ in state.__annotations__))
    try:
        behaviour.function(constants, *(x if meaning is Meaning.STATE else _Number() for meaning in behaviour.meanings))
    except _LookedAtError as looked:
        frame = looked.__traceback__
        while frame is not None and frame.tb_next is not None and frame.tb_next.tb_frame.f_globals is not globals():
            frame = frame.tb_next
        if frame is None:
            return True
        home = frame.tb_frame.f_globals[
            "__name__"
        ]  # in arithmetic, roundings have corners, elementary functions have none
        return home == rounding.__name__ or not home.startswith(arithmetic.__name__)
    except (ArithmeticError, ValueError, TypeError, AttributeError):
        return False  # unknown: the functions of `math` are smooth
    return False


class _LookedAtError(Exception):
    """A number was compared."""


class _Number:
    """A number of which nothing is known."""

    def _computed(self, *others: object) -> "_Number":
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _computed
    __neg__ = __pos__ = _computed

    def __float__(self) -> float:
        return 0.5

    def _looked_at(self, *others: object) -> bool:
        raise _LookedAtError

    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = __bool__ = __abs__ = _looked_at
    __floordiv__ = __mod__ = __round__ = __floor__ = __ceil__ = __trunc__ = __int__ = _looked_at
    __hash__ = None  # type: ignore[assignment]
