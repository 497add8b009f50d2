"""What all tests of hostile files have in common."""

import gc

import pytest


@pytest.fixture(scope="module", autouse=True)
def _only_new_garbage_is_collected() -> None:
    """What other tests left in the process would be looked through again and again while these are timed."""
    gc.collect()
    gc.freeze()
