"""Proofs in one process unless a test asks for more: other tests have the other processors."""

from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True, scope="module")
def one_process() -> Iterator[None]:
    """Before fixtures of modules, which prove too."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("proofmass.runner.design.proof.prove.processors", lambda: 1)
        yield
