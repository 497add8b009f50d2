"""The solver of proofs: bitwuzla, on terms over one list of SMT-LIB definitions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from proofmass.blocks.declaration.libraries import need

ProofVerdict = Literal["proved", "refuted", "undecided"]
Term = Any  # of bitwuzla

SOLVER = "bitwuzla"


@dataclass(frozen=True)
class Answer:
    """Answer whether a condition always holds; if not, values of terms for which it fails."""

    verdict: ProofVerdict
    values: Mapping[str, int]


class SmtSolver:
    """Makes terms, and proves them for all values of the constants among them."""

    def __init__(self, definitions: Sequence[str]) -> None:
        need(SOLVER)
        # optional: only proofs need it
        import bitwuzla

        self._library: Any = bitwuzla
        self._terms = bitwuzla.TermManager()
        self._parser = bitwuzla.Parser(self._terms, bitwuzla.Options())
        self._rewriter = bitwuzla.Bitwuzla(self._terms, bitwuzla.Options())
        self._parser.parse("\n".join(("(set-logic QF_BV)", *definitions)), True, False)

    def read(self, text: str) -> Term:
        """The term of a text."""
        return self._parser.parse_term(text)

    def prove(self, condition: Term, assumptions: Sequence[Term], seconds: float, shown: Mapping[str, Term]) -> Answer:
        """Prove that a condition holds if the assumptions do; if it fails, answer with values of the terms `shown`."""
        solver = self._solver([*assumptions, self.make("NOT", condition)], seconds)
        result = solver.check_sat()
        if result == self._library.Result.UNSAT:
            return Answer("proved", {})
        if result != self._library.Result.SAT:
            return Answer("undecided", {})
        return Answer("refuted", {name: _number(solver.get_value(term)) for name, term in shown.items()})

    def values(self, given: Mapping[Term, int], wanted: Sequence[Term]) -> list[int]:
        """Values of words, without a sign, for given values of others; the rest is arbitrary."""
        solver = self._solver([self.make("EQUAL", term, self.number(value, term)) for term, value in given.items()])
        solver.check_sat()
        return [_number(solver.get_value(term)) for term in wanted]

    def replaced(self, term: Term, by: Mapping[Term, Term]) -> Term:
        """Return a term with some of its parts replaced."""
        return self._terms.substitute_term(term, by) if by else term

    def simplified(self, term: Term) -> Term:
        """Return a term of the same value; a number if the solver finds that it is one."""
        return self._rewriter.simplify_term(term)

    def chosen(self, term: Term) -> Term:
        """Follow choices with known conditions to the term that they choose; return any other term unchanged."""
        while term.kind() == self._library.Kind.ITE:
            condition, *choices = term.children()
            known = self.simplified(condition)
            if not known.is_value():
                break
            term = choices[0] if known.is_true() else choices[1]
        return term

    def unknown(self, width: int) -> Term:
        """A new word of any value."""
        return self._terms.mk_const(self._terms.mk_bv_sort(width))

    def number(self, value: int, like: Term) -> Term:
        """Return a number as a word of another's width."""
        return self._terms.mk_bv_value(like.sort(), value % (1 << width_of(like)))

    def truth(self, value: bool, like: Term) -> Term:
        """Return a truth value, as a word of one bit if the other term is one."""
        if is_word(like):
            return self.number(int(value), like)
        return self._terms.mk_true() if value else self._terms.mk_false()

    def resized(self, term: Term, width: int, *, signed: bool) -> Term:
        """A word at another width."""
        if width < width_of(term):
            return self.make("BV_EXTRACT", term, indices=(width - 1, 0))
        kind = "BV_SIGN_EXTEND" if signed else "BV_ZERO_EXTEND"
        return self.make(kind, term, indices=(width - width_of(term),))

    def make(self, kind: str, *terms: Term, indices: Sequence[int] = ()) -> Term:
        """A term of one of bitwuzla's kinds."""
        return self._terms.mk_term(self._library.Kind[kind], list(terms), list(indices))

    def _solver(self, conditions: Sequence[Term], seconds: float | None = None) -> Any:
        options = self._library.Options()
        options.set(self._library.Option.PRODUCE_MODELS, True)
        if seconds is not None:
            options.set(self._library.Option.TIME_LIMIT_PER, max(int(seconds * 1000), 1))
        solver = self._library.Bitwuzla(self._terms, options)
        for each in conditions:
            solver.assert_formula(each)
        return solver


def width_of(term: Term) -> int:
    """Bits of a word."""
    return term.sort().bv_size()  # type: ignore[no-any-return]


def constants_of(term: Term) -> list[Term]:
    """Constants in a term."""
    reached, waiting = {term}, [term]
    while waiting:
        others = [each for each in waiting.pop().children() if each not in reached]
        reached.update(others)
        waiting += others
    return [each for each in reached if each.is_const()]


def is_word(term: Term) -> bool:
    """Return whether a term is a word, not a truth value."""
    return term.sort().is_bv()  # type: ignore[no-any-return]


def _number(value: Term) -> int:
    return int(value.value(10))
