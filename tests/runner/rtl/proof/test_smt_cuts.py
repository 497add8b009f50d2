"""Ranges of words that both sides of a proof have, from guesses of which most are wrong, against all values."""

import pytest

from proofmass.blocks.arithmetic.fixed_point import where
from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.rtl.machine.words import Word
from proofmass.runner.rtl.proof.smt_cuts import Cuts
from proofmass.runner.rtl.proof.smt_integer import SmtInteger, Specification
from proofmass.runner.rtl.proof.smt_solver import SmtSolver

pytest.importorskip("bitwuzla")

INPUT = Word(-100, 100)
VALUES = [x + 50 if x < 0 else x - 50 for x in range(INPUT.low, INPUT.high + 1)]
BY_INTERVALS = (-150, 150)  # without the condition
IMPLEMENTED = "(bvadd ((_ sign_extend 1) x) (ite (bvslt x #x00) (_ bv50 9) (bvneg (_ bv50 9))))"


def known_range(guesses: set[Interval]) -> Interval:
    """The narrowest range that is proved of the unknown word, from nothing but what the cuts say of it."""
    specification = Specification()
    x = SmtInteger(specification, "x", INPUT.low, INPUT.high)
    value = where(x < 0, x + 50, x - 50)
    assert (value.low, value.high) == BY_INTERVALS
    lines = ["(declare-const x (_ BitVec 8))", f"(define-fun impl () (_ BitVec 9) {IMPLEMENTED})"]
    solver = SmtSolver([*lines, *specification.lines])
    assumed = [solver.read("(bvsle (bvneg #x64) x)"), solver.read("(bvsle x #x64)")]
    cuts = Cuts(solver, assumed, {solver.read("x"): INPUT}, specification.cuts, [solver.read("impl")], guesses)
    unknown = cuts.replaced[solver.read(value.text)]
    assert solver.replaced(solver.read("impl"), cuts.replaced) == solver.resized(unknown, 9, signed=True)

    def holds(kind: str, end: int) -> bool:
        condition = solver.make(kind, unknown, solver.number(end, unknown))
        return solver.prove(condition, cuts.known(condition), 5.0, {}).verdict == "proved"

    span = range(-160, 161)
    return max(end for end in span if holds("BV_SGE", end)), min(end for end in span if holds("BV_SLE", end))


def test_the_narrowest_ends_that_hold_are_found_among_many_that_do_not() -> None:
    assert known_range({(-end, end) for end in range(10, 140)}) == (min(VALUES), max(VALUES))


@pytest.mark.exhaustive
def test_wrong_guesses_are_not_believed() -> None:
    assert known_range({(min(VALUES) + 1, max(VALUES) - 1), (0, 0)}) == BY_INTERVALS


@pytest.mark.exhaustive
def test_each_end_is_taken_by_itself() -> None:
    assert known_range({(min(VALUES) - 5, max(VALUES) - 1), (0, max(VALUES) + 7)}) == (min(VALUES) - 5, max(VALUES) + 7)
