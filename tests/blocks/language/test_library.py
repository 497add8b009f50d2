"""The library is written in the part of Python that is told to users: nothing in its functions is refused."""

import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.language import forms

KINDS = {name: kind for name, kind in all_blocks().items() if not kind.has_formats()}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_nothing_is_refused_of_a_block_of_the_library(kind: type[Block], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forms, "is_own", lambda kind: True)
    assert forms.problems_of(kind) == []
    for behaviour in kind.output_functions.values():
        form = forms.form_of(kind, behaviour)
        assert form
        assert form.function
