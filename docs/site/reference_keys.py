"""The page of the keys of graph files and studies, from the JSON Schema that editors use."""

from collections.abc import Iterator, Mapping
from typing import Any

from docs.site.markdown import code, plain, table
from proofmass.graphs.schema.schema import FILE, schema

_TYPES = {
    "string": "text", "number": "number", "integer": "whole number", "boolean": "true or false",
    "array": "list", "object": "table",
}  # fmt: skip


def keys_page() -> str:
    """Return the page of all keys."""
    whole = schema()
    lines = ["# Keys of graph files and studies", ""]
    lines += ["[Graph files](../graph-files.md) and [studies](../studies.md) explain them with examples.", ""]
    lines += ['A quantity is a text with a number and a unit, such as `"10 kHz"`.', ""]
    for title, keys in _tables("Graph", whole["$defs"][FILE]["properties"], whole["$defs"]):
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
    if "$ref" in value:
        value = {**definitions[value["$ref"].rpartition("/")[2]], **value}
    if "properties" in value:
        yield value["properties"], ""
    named = value.get("additionalProperties")
    if isinstance(named, Mapping):
        for choice in named.get("oneOf", named.get("anyOf", [named])):
            if "properties" in choice:
                yield choice["properties"], ".NAME"


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
    if "$ref" in value:
        return "quantity" if value["$ref"].endswith("/quantity") else "table"
    for several in ("anyOf", "oneOf"):
        if several in value:
            return " or ".join(dict.fromkeys(_value(choice) for choice in value[several]))
    return _TYPES.get(value.get("type", ""), "")
