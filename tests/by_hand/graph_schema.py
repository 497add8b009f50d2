"""The schema of graph files, made once, and a validator that tries a block against its own kind alone."""

from collections.abc import Iterator
from typing import Any

from jsonschema import Draft202012Validator, ValidationError
from jsonschema.validators import extend

from proofmass.graphs.schema.schema import schema

SCHEMA = schema()
PLAIN = Draft202012Validator(SCHEMA)


def _one_of(validator: Any, branches: list[Any], instance: Any, whole: Any) -> Iterator[ValidationError]:
    """Check `oneOf` by the branches that may be valid: a branch whose constant `kind` is another is not."""
    kind = instance.get("kind") if isinstance(instance, dict) else None
    possible = [branch for branch in branches if kind is None or _kind(branch) in (None, kind)]
    return Draft202012Validator.VALIDATORS["oneOf"](validator, possible, instance, whole)  # type: ignore[no-any-return]


def _kind(branch: Any) -> Any:
    """Return the constant of `kind` in the definition that a branch refers to."""
    definition = SCHEMA["$defs"].get(branch.get("$ref", "").removeprefix("#/$defs/"), {})
    return definition.get("properties", {}).get("kind", {}).get("const")


VALIDATOR = extend(Draft202012Validator, {"oneOf": _one_of})(SCHEMA)
