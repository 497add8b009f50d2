"""The page of the keys of graph files and studies, from the JSON Schema that editors use."""

from collections.abc import Iterator, Mapping
from typing import Any

from docs.site.markdown import code, plain, table
from proofmass.graphs.schema.schema import graph_schema

_TYPES = {
    "string": "text", "number": "number", "integer": "whole number", "boolean": "true or false",
    "array": "list", "object": "table",
}  # fmt: skip

_DEFINED = dict.fromkeys(("num", "pos", "min0", "part", "val", "wid", "quantity"), "quantity")
_DEFINED |= {"int": "whole number", "count": "whole number", "formula": "text", "list": "list", "fix": "text"}


def keys_page() -> str:
    """Return the page of all keys."""
    whole = graph_schema()
    lines = ["# Keys of graph files and studies", ""]
    lines += ["[Graph files](../graph-files.md) and [studies](../studies.md) explain them with examples.", ""]
    lines += ['A quantity is a text with a number and a unit, such as `"10 kHz"`.', ""]
    for title, keys in _tables("Graph", whole["properties"], whole["$defs"]):
        lines += [f"## {title}", "", *table(("key", "value", "meaning"), [_row(*key) for key in keys.items()])]
    return "\n".join(lines) + "\n"


def _tables(
    title: str, properties: Mapping[str, Any], definitions: Mapping[str, Any]
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield a table of keys, then those of the tables within it."""
    yield title, properties
    for key, value in properties.items():
        for inner, name in _inner(value, definitions):
            yield from _tables(f"{title}: {key}{name}" if title != "Graph" else f"{key}{name}", inner, definitions)


def _inner(value: Mapping[str, Any], definitions: Mapping[str, Any]) -> Iterator[tuple[Mapping[str, Any], str]]:
    """Yield the keys of the tables that a value may be, with the part of the path that stands for a name."""
    for form in _forms(value, definitions):
        if "properties" in form:
            yield form["properties"], ""
        named = [*form.get("patternProperties", {}).values(), form.get("additionalProperties")]
        for choice in (entry for entry in named if isinstance(entry, Mapping)):
            for entry in _forms(choice, definitions):
                if "properties" in entry:
                    yield entry["properties"], ".NAME"


def _forms(value: Mapping[str, Any], definitions: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield a value itself, what it refers to, and the forms that depend on its type; not those of a kind of block."""
    reference = value.get("$ref", "").rpartition("/")[2]
    if reference == "block":
        return
    if reference in definitions:
        value = {**definitions[reference], **value}
    yield value
    for branch in ("then", "else"):
        if "if" in value and "properties" not in value and isinstance(value.get(branch), Mapping):
            yield from _forms(value[branch], definitions)


def _row(key: str, value: Mapping[str, Any]) -> tuple[str, str, str]:
    return code(key), _value(value), plain(value.get("description", ""))


def _value(value: Any) -> str:
    """Return the values that a key takes, in words."""
    if not isinstance(value, Mapping):
        return ""
    if "const" in value:
        return code(value["const"])
    if "enum" in value:
        return ", ".join(code(choice) for choice in value["enum"])
    referred = value.get("$ref") or next((part["$ref"] for part in value.get("allOf", []) if "$ref" in part), "")
    if referred:
        return _DEFINED.get(referred.rpartition("/")[2], "table")
    if "if" in value and "type" not in value:
        return " or ".join(dict.fromkeys(_value(value[branch]) for branch in ("else", "then")))
    for several in ("anyOf", "oneOf"):
        if several in value:
            return " or ".join(dict.fromkeys(_value(choice) for choice in value[several]))
    types = value.get("type", "")
    return " or ".join(_TYPES.get(one, "") for one in ([types] if isinstance(types, str) else types))
