"""Pieces of the JSON Schema: tables by keys, tables by names, lists and numbers with units."""

from collections.abc import Mapping
from typing import Any

from proofmass.graphs.model.keys import Integer, Text

Schema = dict[str, Any]

PARAMETERS = r"^[a-z][a-z0-9_.]*$"  # names of parameters and measures, paths among them: single keys in quotes
QUANTITY: Schema = {"$ref": "#/$defs/quantity"}
NUMBER: Schema = {"allOf": [{"$ref": "#/$defs/val"}]}
NO_KEY: Schema = {"not": {}}  # not false: of that, Taplo marks every key of the table instead of the wrong one
FLAG: Schema = {"type": "boolean"}


def table(values: Mapping[str, Schema], docs: Mapping[str, str], *required: str, **more: Any) -> Schema:
    """Return the schema of a table with these keys, each with its doc, and what else it has.

    What a whole table must keep is asked only where all of its keys are known: a misspelt key is
    one fault, not two.
    """
    whole = {**({"required": list(required)} if required else {}), **more}
    return {
        "type": "object",
        "properties": {key: {"description": docs[key], **value} for key, value in values.items()},
        "additionalProperties": NO_KEY,
        **({"if": {"propertyNames": {"enum": list(values)}}, "then": whole} if whole else {}),
    }


def by_name(entry: Schema, names: str = "", **more: Any) -> Schema:
    """Return the schema of a table whose names match a pattern, with entries of one form."""
    if not names:
        return {"type": "object", **more, "additionalProperties": entry}
    return {"type": "object", **more, "patternProperties": {names: entry}, "additionalProperties": NO_KEY}


def by_type(form: Schema, of_tables: Schema) -> Schema:
    """Return the schema of a value that is a table of one form or another value; faults are told of the fitting one."""
    return {"if": {"type": "object"}, "then": of_tables, "else": form}


def several(entry: Schema, least: int = 1) -> Schema:
    """Return the schema of a list."""
    return {"type": "array", "minItems": least, "items": entry}


def pair(entry: Schema) -> Schema:
    """Return the schema of a list of two."""
    return {"type": "array", "minItems": 2, "maxItems": 2, "items": entry}


def either(*ways: Schema) -> Schema:
    """Return the schema of what has one of some forms; those of a choice count one by one."""
    return {"anyOf": [form for way in ways for form in (way["anyOf"] if set(way) == {"anyOf"} else [way])]}


def plain(form: Text | Integer) -> Schema:
    """Return the schema of a plain value by its row."""
    if isinstance(form, Text):
        return {"type": "string", "maxLength": form.longest}
    value = {"type": "integer", "minimum": form.lowest, "maximum": form.highest}
    return value if form.default is None else value | {"default": form.default}


def needs_one(*keys: str) -> list[Schema]:
    """Return the alternatives of which each has one of these keys."""
    return [{"required": [key]} for key in keys]
