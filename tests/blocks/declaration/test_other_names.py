"""Names that other tools have for kinds lead to kinds that there are."""

import re

import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.other_names import _KINDS, _squashed, kind_hint, other_names


def test_every_kind_that_is_named_exists_and_no_word_is_a_kind_itself() -> None:
    kinds = all_blocks(None)
    named = {word for text in _KINDS.values() for word in re.findall(r"\b[A-Z]\w+", text)}
    assert named <= kinds.keys()
    words = [_squashed(word) for words in _KINDS for word in words]
    assert not {kind.lower() for kind in kinds} & set(words)
    assert len(words) == len(set(words))


def test_a_kind_knows_its_other_names() -> None:
    assert "summing junction" in other_names("Sum")
    assert "summing junction" not in other_names("Difference")
    assert other_names("Gai") == []


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("Scope", 'signals are recorded by probes: probes = ["block.output"]'),
        ("Zero_Order-Hold", "here that is SampleAndHold"),
        ("Gian", "did you mean Gain?"),
        ("PLL", 'write graph = "library:phase_locked_loop.toml"'),
        ("CostasLoop", 'write graph = "library:costas_loop.toml"'),
        ("PeakDetector", "Blocks of your own need --blocks FILE."),
    ],
)
def test_hints(word: str, hint: str) -> None:
    assert hint in kind_hint(word, all_blocks(None), own=False)
    assert ("--blocks" in kind_hint(word, all_blocks(None), own=False)) == (word == "PeakDetector")
    assert "--blocks" not in kind_hint(word, all_blocks(None), own=True)


@pytest.mark.parametrize(
    ("statement", "cure"),
    [
        ("from proofmass.blocks import Block", "it is one floor up: from proofmass import Block"),
        ("from proofmass import Output", "it is a decorator of a kind of block, as @KIND.output"),
        ("from proofmass import Gain", "a block comes from proofmass.blocks: from proofmass.blocks import Gain"),
    ],
)
def test_a_name_that_is_imported_from_another_place(statement: str, cure: str) -> None:
    with pytest.raises(ImportError, match=re.escape(cure)):
        exec(statement)
