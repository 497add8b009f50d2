"""Goals made shallow: words that both sides of a proof have in common are proved equal and made unknown.

A tower of products is beyond any solver as it stands. But the two sides compute it in like steps: words with equal
values in random samples are proved equal, operands first, and each such pair is then replaced by one unknown word of the
same range. What holds for all values of the unknown words holds for those that they stand for; what fails for some of
them may hold nevertheless.
"""

import random
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

from proofmass.runner.rtl.smt_integer import SmtInteger
from proofmass.runner.rtl.smt_solver import Solver, Term, is_word, width_of
from proofmass.runner.rtl.words import Word

_SAMPLES = 24
_SECONDS = 5.0  # for a pair


class Cuts:
    """The replacements, and what is known of the unknown words beside the assumptions."""

    def __init__(
        self,
        solver: Solver,
        assumptions: Sequence[Term],
        inputs: Mapping[Term, Word],
        specified: Sequence[SmtInteger],
        implemented: Sequence[str],
    ) -> None:
        self.solver, self.known = solver, list(assumptions)
        self.replaced: dict[Term, Term] = {}
        words = [(word, solver.read(word.text)) for word in specified]
        terms = [term for name in implemented if is_word(term := solver.read(name))]
        for word, term, others in self._alike(inputs, words, terms):
            for other, signed in others:
                if other != term and other not in self.replaced and self._are_equal(word, term, other, signed):
                    self._cut(word, term, other)

    def _alike(
        self, inputs: Mapping[Term, Word], words: Sequence[tuple[SmtInteger, Term]], terms: Sequence[Term]
    ) -> Iterator[tuple[SmtInteger, Term, list[tuple[Term, bool]]]]:
        """Words of the specification with those of the implementation, read with or without a sign, that look equal."""
        wanted = [*(term for _, term in words), *terms]
        samples = [self.solver.values(sample, wanted) for sample in _samples(inputs)]
        found: dict[tuple[int, ...], list[tuple[Term, bool]]] = defaultdict(list)
        rows = list(zip(*samples, strict=True))
        for term, row in zip(terms, rows[len(words) :], strict=True):
            found[_signed(row, width_of(term))].append((term, True))
            if row != _signed(row, width_of(term)):
                found[row].append((term, False))
        for (word, term), row in zip(words, rows, strict=False):
            yield word, term, found.get(_signed(row, word.width), [])

    def _are_equal(self, word: SmtInteger, term: Term, other: Term, signed: bool) -> bool:
        width = max(word.width, width_of(other) + (not signed))
        both = [self.solver.resized(term, width, signed=True), self.solver.resized(other, width, signed=signed)]
        condition = self.solver.replaced(self.solver.make("EQUAL", *both), self.replaced)
        return self.solver.prove(condition, self.known, _SECONDS, {}).verdict == "proved"

    def _cut(self, word: SmtInteger, term: Term, other: Term) -> None:
        if term not in self.replaced:
            unknown = self.replaced[term] = self.solver.unknown(word.width)
            least, greatest = (self.solver.number(end, unknown) for end in (word.low, word.high))
            self.known.append(self.solver.make("BV_SLE", least, unknown))
            self.known.append(self.solver.make("BV_SLE", unknown, greatest))
        self.replaced[other] = self.solver.resized(self.replaced[term], width_of(other), signed=True)


def _samples(inputs: Mapping[Term, Word]) -> Iterator[dict[Term, int]]:
    """Values of the inputs within their ranges, the ends among them."""
    draw = random.Random(1)
    for _ in range(_SAMPLES):
        yield {
            term: draw.choice((word.low, word.high, *[draw.randint(word.low, word.high)] * 6))
            for term, word in inputs.items()
        }


def _signed(row: tuple[int, ...], width: int) -> tuple[int, ...]:
    """Words read as two's complement."""
    return tuple(value - (1 << width) if value >> (width - 1) else value for value in row)
