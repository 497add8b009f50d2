"""The stubs of the lazy packages are those that the tables make."""

import pytest

from tests.documents.stubs import ROOT, STUBS, stub_text


@pytest.mark.parametrize("stub", STUBS)
def test_a_stub_says_what_the_table_says(stub: str) -> None:
    assert (ROOT / stub).read_text(encoding="utf-8") == stub_text(stub), "write it: python -m tests.documents.stubs"
