"""How much of a test runs: a sample always, all of it in `make test-all`."""

from collections.abc import Iterable
from typing import Any

import pytest


def amounts(sample: Any, whole: Any) -> list[Any]:
    """Parameters of a test: a sample of what it looks at, and all of it, marked as exhaustive."""
    return [
        pytest.param(sample, id=f"a sample of {sample}"),
        pytest.param(whole, id=f"all {whole}", marks=pytest.mark.exhaustive),
    ]


def chosen(sample: Iterable[Any], rest: Iterable[Any]) -> list[Any]:
    """Parameters of a test: some that always run, and the others, marked as exhaustive."""
    return [*sample, *(pytest.param(one, marks=pytest.mark.exhaustive) for one in rest)]
