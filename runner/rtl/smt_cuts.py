"""Goals made shallow: words that both sides of a proof have in common are proved equal and made unknown.

A tower of products is beyond any solver as it stands. But the two sides compute it in like steps: words with equal
values in random samples are proved equal, operands first, and each such pair is then replaced by one unknown word of the
same range. What holds for all values of the unknown words holds for those that they stand for; what fails for some of
them may hold nevertheless. Ranges of the unknown words are guessed, from those that the tracer gave to its values, and
each is proved before it is used.
"""

import random
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence

from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.rtl.smt_integer import SmtInteger
from proofmass.runner.rtl.smt_solver import Solver, Term, is_word, width_of
from proofmass.runner.rtl.words import Word

Row = tuple[int, ...]  # values of a word in the samples

_SAMPLES = 24
_TRIED = 12  # guesses for a word
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
        guesses: Collection[Interval],
    ) -> None:
        self.solver, self.known = solver, list(assumptions)
        self.replaced: dict[Term, Term] = {}
        self._guesses = sorted(guesses, key=lambda guess: guess[1] - guess[0])
        words = [(word, solver.read(word.text)) for word in specified]
        terms = list(dict.fromkeys(term for name in implemented if is_word(term := solver.read(name))))
        for word, term, row, others in self._alike(inputs, words, terms):
            for other, signed in others:
                if other != term and other not in self.replaced and self._are_equal(word, term, other, signed):
                    self._cut(word, term, row, other)

    def _alike(
        self, inputs: Mapping[Term, Word], words: Sequence[tuple[SmtInteger, Term]], terms: Sequence[Term]
    ) -> Iterator[tuple[SmtInteger, Term, Row, list[tuple[Term, bool]]]]:
        """Words of the specification, their values in samples, and words of the implementation that look equal.

        The latter are read with or without a sign.
        """
        wanted = [*(term for _, term in words), *terms]
        samples = [self.solver.values(sample, wanted) for sample in _samples(inputs)]
        found: dict[Row, list[tuple[Term, bool]]] = defaultdict(list)
        rows: list[Row] = list(zip(*samples, strict=True))
        for term, row in zip(terms, rows[len(words) :], strict=True):
            found[_signed(row, width_of(term))].append((term, True))
            if row != _signed(row, width_of(term)):
                found[row].append((term, False))
        for (word, term), row in zip(words, rows, strict=False):
            values = _signed(row, word.width)
            yield word, term, values, found.get(values, [])

    def _are_equal(self, word: SmtInteger, term: Term, other: Term, signed: bool) -> bool:
        width = max(word.width, width_of(other) + (not signed))
        both = [self.solver.resized(term, width, signed=True), self.solver.resized(other, width, signed=signed)]
        return self._holds(self.solver.make("EQUAL", *both))

    def _holds(self, condition: Term) -> bool:
        shallow = self.solver.replaced(condition, self.replaced)
        return self.solver.prove(shallow, self.known, _SECONDS, {}).verdict == "proved"

    def _cut(self, word: SmtInteger, term: Term, row: Row, other: Term) -> None:
        if term not in self.replaced:
            low, high = self._range(word, term, row)
            unknown = self.replaced[term] = self.solver.unknown(word.width)
            self.known.append(self._within(unknown, low, high))
        self.replaced[other] = self.solver.resized(self.replaced[term], width_of(other), signed=True)

    def _range(self, word: SmtInteger, term: Term, row: Row) -> Interval:
        """The narrowest guess that can be proved, or else what the word itself says."""
        tried = 0
        for low, high in self._guesses:
            inside = word.low <= low <= min(row) and max(row) <= high <= word.high
            if inside and (low, high) != (word.low, word.high) and tried < _TRIED:
                tried += 1
                if self._holds(self._within(term, low, high)):
                    return low, high
        return word.low, word.high

    def _within(self, term: Term, low: int, high: int) -> Term:
        least, greatest = (self.solver.number(end, term) for end in (low, high))
        return self.solver.make(
            "AND", self.solver.make("BV_SLE", least, term), self.solver.make("BV_SLE", term, greatest)
        )


def _samples(inputs: Mapping[Term, Word]) -> Iterator[dict[Term, int]]:
    """Values of the inputs within their ranges, the ends among them."""
    draw = random.Random(1)
    for _ in range(_SAMPLES):
        yield {
            term: draw.choice((word.low, word.high, *[draw.randint(word.low, word.high)] * 6))
            for term, word in inputs.items()
        }


def _signed(row: Row, width: int) -> Row:
    """Words read as two's complement."""
    return tuple(value - (1 << width) if value >> (width - 1) else value for value in row)
