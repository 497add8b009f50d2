"""Goals made shallow: words common to both sides of a proof are proved equal and replaced by unknown words.

No solver can decide a tower of products as it stands. But the two sides compute it in similar
steps: words with equal values in random samples are proved equal, operands first, and each such
pair is replaced by one unknown word of the same range. A goal that holds for all values of the
unknown words holds for their actual values; a goal that fails for some may still hold. Ranges of
the unknown words are guessed: their ends come from the tracer. Each end is proved from the ranges
of the words before it, and only then used.
"""

import random
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import chain

from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.rtl.machine.words import Word
from proofmass.runner.rtl.proof.smt_integer import SmtInteger
from proofmass.runner.rtl.proof.smt_solver import Answer, SmtSolver, Term, constants_of, is_word, width_of

_Row = tuple[int, ...]  # values of a word in the samples

_SAMPLES = 24
_LEFT_OUT = 2
_SECONDS = 5.0  # for a pair
_SECONDS_AGAIN = 0.5


class Cuts:
    """The replacements, and the known bounds of the unknown words."""

    def __init__(
        self,
        solver: SmtSolver,
        assumptions: Sequence[Term],
        inputs: Mapping[Term, Word],
        specified: Sequence[SmtInteger],
        implemented: Sequence[Term],
        guesses: Collection[Interval],
    ) -> None:
        self.solver, self._assumptions = solver, assumptions
        self._bounds: dict[Term, tuple[Term, Term]] = {}  # of unknown words
        self._cut_words: list[dict[Term, Term]] = []  # by word: the unknown of it and its equals
        self._guesses = sorted({low for low, _ in guesses}), sorted({high for _, high in guesses})
        words = [(word, solver.read(word.text)) for word in specified]
        terms = list(dict.fromkeys(term for term in implemented if is_word(term)))
        for word, term, row, others in self._alike(inputs, words, terms):
            for other, signed in others:
                if other != term and not self._is_cut(other) and self._are_equal(word, term, other, signed):
                    self._cut(word, term, row, other)

    @property
    def replaced(self) -> dict[Term, Term]:
        """Replacements: each term with the one that takes its place."""
        return {term: unknown for each in self._cut_words for term, unknown in each.items()}

    def known(self, condition: Term) -> list[Term]:
        """The assumptions, and bounds of the unknown words in a condition."""
        bounds = (self._bounds.get(each, ()) for each in constants_of(condition))
        return [*self._assumptions, *chain.from_iterable(bounds)]

    def _is_cut(self, term: Term) -> bool:
        return any(term in each for each in self._cut_words)

    def _alike(
        self, inputs: Mapping[Term, Word], words: Sequence[tuple[SmtInteger, Term]], terms: Sequence[Term]
    ) -> Iterator[tuple[SmtInteger, Term, _Row, list[tuple[Term, bool]]]]:
        """Words of the specification, their values in samples, and words of the implementation that look equal.

        The latter are read with or without a sign.
        """
        wanted = [*(term for _, term in words), *terms]
        samples = [self.solver.values(sample, wanted) for sample in _samples(inputs)]
        alike: dict[_Row, list[tuple[Term, bool]]] = defaultdict(list)
        rows: list[_Row] = list(zip(*samples, strict=True))
        for term, row in zip(terms, rows[len(words) :], strict=True):
            alike[_signed(row, width_of(term))].append((term, True))
            if row != _signed(row, width_of(term)):
                alike[row].append((term, False))
        for (word, term), row in zip(words, rows, strict=False):
            values = _signed(row, word.width)
            yield word, term, values, alike.get(values, [])

    def _are_equal(self, word: SmtInteger, term: Term, other: Term, signed: bool) -> bool:
        width = max(word.width, width_of(other) + (not signed))
        both = [self.solver.resized(term, width, signed=True), self.solver.resized(other, width, signed=signed)]
        equal = self.solver.make("EQUAL", *both)
        return self._answer(equal, range(_LEFT_OUT + 1), {}).verdict == "proved"

    def _answer(self, condition: Term, left_out: Sequence[int], shown: Mapping[str, Term]) -> Answer:
        """Answer with all cuts, or without the last ones: the branches of a choice are related to its condition."""
        answer = Answer("undecided", {})
        for number in left_out:
            cuts = self._cut_words[: len(self._cut_words) - number]
            by = {term: unknown for each in cuts for term, unknown in each.items()}
            seconds = _SECONDS_AGAIN if number else _SECONDS
            shallow, *seen = (self.solver.replaced(term, by) for term in (condition, *shown.values()))
            answer = self.solver.prove(shallow, self.known(shallow), seconds, dict(zip(shown, seen, strict=True)))
            if answer.verdict != "refuted" or not cuts:
                break
        return answer

    def _cut(self, word: SmtInteger, term: Term, row: _Row, other: Term) -> None:
        if not self._cut_words or term not in self._cut_words[-1]:
            low = self._end(word, term, word.low, min(row))
            high = self._end(word, term, word.high, max(row))
            unknown = self.solver.unknown(word.width)
            self._cut_words.append({term: unknown})
            self._bounds[unknown] = (
                self._bounded(unknown, low, lower=True),
                self._bounded(unknown, high, lower=False),
            )
        same = self._cut_words[-1]
        same[other] = self.solver.resized(same[term], width_of(other), signed=True)

    def _end(self, word: SmtInteger, term: Term, proved: int, value: int) -> int:
        """Return the provable end that is nearest to an observed value, from the guesses or the end known before.

        By bisection: beyond an end that holds all others hold too, and an end that fails yields
        another value.
        """
        lower = proved < value
        guesses = self._guesses[0 if lower else 1]
        while nearer := [end for end in guesses if (proved < end <= value if lower else value <= end < proved)]:
            end = nearer[len(nearer) // 2]
            answer = self._answer(self._bounded(term, end, lower=lower), (0, 1), {"": term})
            if answer.verdict == "proved":
                proved = end
            elif answer.verdict == "refuted":
                (value,) = _signed((answer.values[""],), word.width)
            else:
                value = end - 1 if lower else end + 1
        return proved

    def _bounded(self, term: Term, end: int, *, lower: bool) -> Term:
        number = self.solver.number(end, term)
        return self.solver.make("BV_SLE", *((number, term) if lower else (term, number)))


def _samples(inputs: Mapping[Term, Word]) -> Iterator[dict[Term, int]]:
    """Values of the inputs within their ranges, the ends among them."""
    draw = random.Random(1)
    for _ in range(_SAMPLES):
        yield {
            term: draw.choice((word.low, word.high, *[draw.randint(word.low, word.high)] * 6))
            for term, word in inputs.items()
        }


def _signed(row: _Row, width: int) -> _Row:
    """Words read as two's complement."""
    return tuple(value - (1 << width) if value >> (width - 1) else value for value in row)
