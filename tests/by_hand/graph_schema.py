"""The schemas of graph and study files, made once, and their validators."""

from typing import Any

from jsonschema import Draft202012Validator

from proofmass.graphs.schema.schema import graph_schema, study_file_schema

SCHEMA, STUDY_SCHEMA = graph_schema(), study_file_schema()
VALIDATOR, STUDY_VALIDATOR = Draft202012Validator(SCHEMA), Draft202012Validator(STUDY_SCHEMA)


def validator_of(table: dict[str, Any]) -> Draft202012Validator:
    """Return the validator of a graph, or of a study that names its graph."""
    return STUDY_VALIDATOR if isinstance(table.get("graph"), str) else VALIDATOR


def of_kind(schema: dict[str, Any], kind: str) -> dict[str, Any]:
    """Return what a graph schema says of a kind of block, with its references to definitions followed."""
    rules = schema["$defs"]["block"]["then"]["allOf"]
    (rule,) = (rule["then"] for rule in rules if kind in rule["if"]["properties"]["kind"]["enum"])
    return {name: _followed(schema, form) for name, form in rule["properties"].items()}


def _followed(schema: dict[str, Any], form: Any) -> Any:
    return schema["$defs"][form["$ref"].removeprefix("#/$defs/")] if isinstance(form, dict) and "$ref" in form else form
