"""Threads share the precision of balls: each counts with its own, alone."""

import threading
from concurrent.futures import ThreadPoolExecutor

import flint
import pytest

from proofmass.runner.analysis.linearisation.rational import positive_roots
from proofmass.runner.host.precision import BITS, precision

WAIT = 0.2  # seconds in which another thread would have changed it


@pytest.mark.defect(
    "S950",
    before="last digits of margins in a study follow its threads",
    after="a thread waits for another one's balls",
)
def test_no_thread_changes_the_precision_of_another() -> None:
    inside, leave = threading.Event(), threading.Event()

    def in_few_bits() -> int:
        with precision(64):
            inside.set()
            leave.wait(WAIT)
            return int(flint.ctx.prec)

    with ThreadPoolExecutor(2) as pool:
        few = pool.submit(in_few_bits)
        inside.wait()
        found = pool.submit(positive_roots, flint.fmpz_poly([-2, 0, 1]))
        assert few.result() == 64
        (root,) = found.result()
    assert float(root.rad()) < 2.0 ** (2 - BITS)


def test_a_block_within_another_leaves_the_precision_as_it_was() -> None:
    with precision(100):
        with precision(64):
            assert flint.ctx.prec == 64
        assert flint.ctx.prec == 100
