"""A cut is the identity wherever a simulation computes, and stays in the trace for hardware."""

from typing import Any

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.runner.fixed.trace import trace
from tests.by_hand.integer_code import compile_step

WORD, WIDE = Fixed(6, 2), Fixed(12, 2)


def plain(a: Any) -> Any:
    if a > 3:
        return (a * a).to(WIDE)
    return a


def cut(a: Any) -> Any:
    if pipe(a) > 3:
        return pipe(pipe(a) * a).to(WIDE)
    return pipe(a)


def test_what_is_no_signal_comes_back() -> None:
    value = FixedValue(5, 3)
    assert (pipe(value).mantissa, pipe(value).fraction) == (5, 3)
    assert pipe(-7) == -7
    assert pipe(True) is True
    assert pipe(0.5) == 0.5


def test_compiled_code_computes_the_same() -> None:
    steps = [compile_step(step, {"a": WORD, "return": WIDE}) for step in (plain, cut)]
    assert all(steps[0](m) == steps[1](m) == plain(FixedValue(m, 2)).mantissa for m in range(-32, 32))


def test_the_trace_keeps_cuts_and_intervals() -> None:
    found = trace(cut, {"a": WORD, "return": WIDE})
    cuts = [operation for operation in found.program.live(found.results.values()) if operation.kind == "pipe"]
    assert len(cuts) == 2  # that of `a` is one, whatever is known of it where it is written
    product = max(cuts, key=lambda operation: operation.high)
    assert (product.low, product.high) == (13 * 13, 31 * 31)  # what is known of the cut is known of both sides
