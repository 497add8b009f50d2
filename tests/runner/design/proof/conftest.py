"""Proofs of these tests have one process."""

from tests.by_hand.one_process import one_process

__all__ = ["one_process"]
