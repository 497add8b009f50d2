"""Forms of tables in the schema, by a validator."""

import jsonschema
import pytest

from proofmass.graphs.schema.tables import pair, several


@pytest.mark.parametrize(("entries", "valid"), [([1], False), ([1, 2], True), ([1, 2, 3], False), ([1, "a"], False)])
def test_a_pair_has_two_entries_of_its_form(entries: list[object], valid: bool) -> None:
    assert jsonschema.Draft202012Validator(pair({"type": "number"})).is_valid(entries) == valid


@pytest.mark.parametrize(("entries", "valid"), [([], False), ([1], True), ([1, 2, 3], True), (["a"], False)])
def test_several_are_one_at_least(entries: list[object], valid: bool) -> None:
    assert jsonschema.Draft202012Validator(several({"type": "number"})).is_valid(entries) == valid
