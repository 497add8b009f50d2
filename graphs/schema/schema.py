"""JSON Schema of graph files, for completion and checks in an editor; derived from the blocks, never written twice."""

from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

from proofmass.blocks.declaration.catalog import Own, all_blocks, facts
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.number_files import PARTS
from proofmass.graphs.formulas.parser import LENGTH
from proofmass.graphs.model.integration import CHOICES, COARSEST, FINEST, INTEGRATION_KEYS, MOST_SUBSTEPS
from proofmass.graphs.model.keys import (
    BLOCK_KEYS,
    FORMULA,
    LOOP_KEYS,
    MEASURE_FORMULA_KEYS,
    PART_KEYS,
    PLAIN_KEYS,
    REQUIREMENT_KEYS,
    TOP_KEYS,
)
from proofmass.graphs.model.limits import BLOCKS, LARGEST_RUN, NAME, TEXT_LENGTH, WIRES
from proofmass.graphs.model.measures import MEASURE_KEYS
from proofmass.graphs.model.requirements import SPREAD
from proofmass.graphs.model.statistics import OPTIONS, STATISTICS, TIMES, Statistic
from proofmass.graphs.model.targets import CLOCK_OFFSET
from proofmass.graphs.model.values import MOST_VALUES
from proofmass.graphs.schema.study_schema import study_schema
from proofmass.graphs.schema.tables import Schema, by_name, needs_one, plain, table
from proofmass.graphs.schema.tune_schema import quantity_schema, tune_schema

FILE, STUDY_FILE = "graph file", "study file"  # names of their schemas
_NUMBER = r"[+-]?(\d[\d_]*\.?\d*|\.\d+)([eE][+-]?\d+)?(/\d+)?"
_QUANTITY = rf"^\s*{_NUMBER}\s*([A-Za-zµμΩ%°√1(][A-Za-zµμΩ%°√²³·⋅×0-9*/^()+. -]*)?$"
_NAME = NAME.pattern.partition(")")[2]  # without the limit of its length
_SIGNAL = rf"{_NAME}(\.{_NAME})+"
_PATH = rf"(?!.*[^.]{{65}}){_NAME}(\.{_NAME})*"
_EXPORTS_OF_SIGNALS: Schema = {  # without values there are none to export
    "if": {"not": {"required": ["values"]}},
    "then": {"properties": {"exports": {"additionalProperties": {"pattern": f"^{_SIGNAL}$"}}}},
}
_UNIT: Schema = {"type": "string", "maxLength": 200}
_GRAPH: Schema = {  # what a graph must have, as a file and as a table
    "required": ["blocks"],
    "not": {"required": ["samples", "duration"]},
    **_EXPORTS_OF_SIGNALS,
    "additionalProperties": False,
}
_FORMAT = r"^\s*\(\s*\d{1,4}\s*,\s*[+-]?\d{1,4}\s*\)(\s+unsigned)?\s*$"
_BOUNDS = {
    "above": "exclusiveMinimum",
    "at_least": "minimum",
    "below": "exclusiveMaximum",
    "at_most": "maximum",
}
_SIGNS = {"above": ">", "at_least": ">=", "below": "<", "at_most": "<="}
_JSON_TYPES = {"float": "number", "int": "integer", "bool": "boolean", "str": "string"}


def schema(own: Own | None = None) -> Schema:
    """Return the JSON Schema, draft 2020-12, of graphs and studies; `own` are the caller's own blocks by name."""
    kinds = all_blocks(own)
    rate = _formulated({"type": "number", "exclusiveMinimum": 0})
    values: dict[str, Schema] = {
        **{key: plain(form) for key, form in PLAIN_KEYS.items()},
        "rate": rate,
        "duration": _formulated({"type": "number", "minimum": 0}),
        "values": by_name(_formulated({"type": "number"}), f"^{NAME.pattern}$", maxProperties=MOST_VALUES),
        "formulas": by_name({"$ref": "#/$defs/formula"}, f"^{_PATH}$"),
        "wires": {
            "type": "array",
            "maxItems": WIRES,
            "items": {"type": "string", "pattern": rf"^\s*{_SIGNAL}\s*->\s*{_SIGNAL}\s*$"},
        },
        "probes": {"type": "array", "items": _probe()},
        "measures": _measures(),
        "requirements": by_name(_requirement()),
        "study": {"$ref": "#/$defs/study", "not": {"required": ["graph"]}},
        "tune": {"$ref": "#/$defs/tune"},
        "exports": {
            "type": "object",
            "propertyNames": {"pattern": f"^{NAME.pattern}$", "not": {"enum": sorted({*PART_KEYS, *BLOCK_KEYS})}},
            "additionalProperties": {"type": "string", "pattern": rf"^{_NAME}(\.{_NAME})*$"},
        },
        "integration": _integration(),
        "loops": by_name(_loop(), f"^{_PATH}$"),
        "blocks": by_name(
            {"oneOf": [{"$ref": f"#/$defs/{quote(name)}"} for name in (*kinds, *_parts(rate))]},
            f"^{_PATH}$",
            minProperties=1,
            maxProperties=BLOCKS,
        ),
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "proofmass graph or study",
        "type": "object",
        "anyOf": [{"$ref": f"#/$defs/{quote(FILE)}"}, {"$ref": f"#/$defs/{quote(STUDY_FILE)}"}],
        "$defs": {
            FILE: {
                "title": "proofmass graph",
                "type": "object",
                "properties": {key: {"description": doc, **values[key]} for key, doc in TOP_KEYS.items()},
                **_GRAPH,
            },
            # keys beside a reference add to it: all others are those of the study
            STUDY_FILE: {"title": "proofmass study", "$ref": "#/$defs/study", "required": ["graph"]},
            "quantity": {"type": "string", "pattern": _QUANTITY, "maxLength": TEXT_LENGTH},
            "formula": {"type": "string", "pattern": r"^\s*=", "maxLength": LENGTH + 2},
            "numbers": _numbers(),
            **{name: _block(kind, rate) for name, kind in kinds.items()},
            **_parts(rate),
            "study": study_schema(),
            "tune": tune_schema(),
        },
    }


def _block(kind: type[Block], rate: Schema) -> Schema:
    about = facts(kind)
    properties: dict[str, Schema] = {"kind": {"const": about["kind"], "description": about["doc"]}}
    if not about["continuous"]:
        properties["rate"] = {"description": BLOCK_KEYS["rate"], **rate}
        properties[CLOCK_OFFSET] = {
            "description": BLOCK_KEYS[CLOCK_OFFSET],
            **_formulated({"type": "number", "minimum": 0}),
        }
    properties |= {name: _parameter(parameter) for name, parameter in about["parameters"].items()}
    return {
        "title": about["kind"],
        "description": about["doc"],
        "type": "object",
        "properties": properties,
        "required": ["kind"],
        "additionalProperties": False,
    }


def _integration() -> Schema:
    values: dict[str, Schema] = {name: {"enum": list(choices)} for name, choices in CHOICES.items()}
    values["accuracy"] = {"type": "number", "minimum": FINEST, "maximum": COARSEST}
    values["substeps"] = {"type": "integer", "minimum": 1, "maximum": MOST_SUBSTEPS}
    values["event_tolerance"] = _quantity({"type": "number", "exclusiveMinimum": 0})
    return table(values, INTEGRATION_KEYS)


def _measures() -> Schema:
    values: dict[str, Schema] = {
        "signal": {"type": "string", "pattern": f"^{_SIGNAL}$"},
        "statistic": {"enum": list(STATISTICS)},
        "from": _quantity({"type": "number", "minimum": 0}),
        "until": _quantity({"type": "number", "exclusiveMinimum": 0}),
        "unit": _UNIT,
        **{key: _option(row, key) for row in STATISTICS.values() for key in row.options},
    }
    suited = [
        {
            "if": {"properties": {"statistic": {"const": statistic}}, "required": ["statistic"]},
            "then": {
                "required": list(row.options),
                "properties": dict.fromkeys(sorted(OPTIONS.keys() - row.options.keys()), False),
            },
        }
        for statistic, row in STATISTICS.items()
    ]
    measure = table(values, MEASURE_KEYS, "signal", "statistic", allOf=suited)
    formula: Schema = {"$ref": "#/$defs/formula"}
    of_others = table({FORMULA: formula, "unit": _UNIT}, MEASURE_FORMULA_KEYS, FORMULA)
    return by_name({"anyOf": [measure, formula, of_others]}, f"^{NAME.pattern}$")


def _option(statistic: Statistic, key: str) -> Schema:
    """Return the schema of an option: a time, or a number within the bounds of the block's parameter."""
    if key in TIMES or statistic.block is None:
        return _quantity({"type": "number", "minimum": 0})
    parameter = facts(statistic.block)["parameters"][key]
    return _quantity({"type": _JSON_TYPES[parameter["type"]]} | _bounds(parameter))


def _parts(rate: Schema) -> dict[str, Schema]:
    """Return the schema of blocks that are graphs: from a file, or as a table with the keys of a file."""
    values: dict[str, Schema] = {
        "graph": {"type": "string", "minLength": 1, "maxLength": TEXT_LENGTH},
        "rate": rate,
        CLOCK_OFFSET: _formulated({"type": "number", "minimum": 0}),
        "count": {"type": "integer", "minimum": 1, "maximum": BLOCKS},
    }
    inside = {"description": "A parameter that the graph exports, or one inside it by its path."}
    return {
        "graph from a file": table(
            values,
            PART_KEYS,
            "graph",
            patternProperties={f"^{_PATH}$": inside},
            **{"not": {"anyOf": needs_one("kind", "blocks")}},
        ),
        "graph": {
            "type": "object",
            "properties": {key: {"$ref": f"#/$defs/{quote(FILE)}/properties/{key}"} for key in TOP_KEYS}
            | {CLOCK_OFFSET: {"description": PART_KEYS[CLOCK_OFFSET], **values[CLOCK_OFFSET]}},
            **_GRAPH,
        },
    }


def _loop() -> Schema:
    least = _quantity({"type": "number", "minimum": 0})
    values = {key: {"type": "string", "pattern": f"^{_SIGNAL}$"} if key == "open_at" else least for key in LOOP_KEYS}
    return table(values, LOOP_KEYS, "open_at")


def _parameter(parameter: Mapping[str, Any]) -> Schema:
    about = {"description": _description(parameter), "default": parameter["default"]}
    bounds = _bounds(parameter)
    if "choices" in parameter:
        return about | {"enum": parameter["choices"]}
    if parameter["type"] == "list":
        entry = _formulated({"type": "number"} | bounds)
        return about | {"anyOf": [{"type": "array", "minItems": 1, "items": entry}, {"$ref": "#/$defs/numbers"}]}
    if parameter["type"] == "format":
        return about | {"type": "string", "pattern": _FORMAT}
    value = {"type": _JSON_TYPES[parameter["type"]]} | bounds
    if parameter["type"] == "str":
        return about | value | {"maxLength": TEXT_LENGTH}
    return about | (value if parameter["type"] == "bool" else _formulated(value))


def _numbers() -> Schema:
    """Return the schema of a list of numbers that a file holds."""
    name = {"type": "string", "maxLength": TEXT_LENGTH}
    return {
        "type": "object",
        "properties": {"file": name, "column": name, "part": {"enum": list(PARTS)}},
        "required": ["file"],
        "additionalProperties": False,
    }


def _bounds(parameter: Mapping[str, Any]) -> Schema:
    return {word: parameter[fact] for fact, word in _BOUNDS.items() if fact in parameter}


def _description(parameter: Mapping[str, Any]) -> str:
    """Return doc, unit and bounds, which an editor shows beside the key."""
    unit = parameter["unit"].replace("{", "").replace("}", "")
    bounds = [f"{sign} {parameter[fact]:g}" for fact, sign in _SIGNS.items() if fact in parameter]
    more = [f"in {unit}" if unit not in ("", "1") else "", " and ".join(bounds)]
    about = ", ".join(part for part in more if part)
    doc = str(parameter["doc"])
    return f"{doc.rstrip('.')} ({about})." if about else doc


def _quantity(number: Schema) -> Schema:
    """Return the schema of a number in the declared unit, or a string of a number and a unit."""
    return {"anyOf": [number, {"$ref": "#/$defs/quantity"}]}


def _requirement() -> Schema:
    values: dict[str, Schema] = {
        key: {"type": ["number", "string"]} if key in ("at_least", "at_most") else {"type": "string"}
        for key in REQUIREMENT_KEYS
    }
    values["quantity"] = {"anyOf": [{"type": "string"}, quantity_schema({}, {})]}
    tolerances = by_name({"type": ["number", "string", "array"]}, minProperties=1)
    values["tolerances"] = {"anyOf": [{"const": SPREAD}, tolerances]}
    return table(values, REQUIREMENT_KEYS, "quantity", anyOf=needs_one("at_least", "at_most"))


def _formulated(number: Schema) -> Schema:
    """Return the schema of what may be a formula too."""
    return {"anyOf": [number, {"$ref": "#/$defs/quantity"}, {"$ref": "#/$defs/formula"}]}


def _probe() -> Schema:
    signal = {"type": "string", "pattern": f"^{_SIGNAL}$"}
    table = {
        "type": "object",
        "properties": {
            "signal": signal,
            "every": {"type": "integer", "minimum": 1, "maximum": LARGEST_RUN},
            "unit": _UNIT,
        },
        "required": ["signal"],
        "additionalProperties": False,
    }
    return {"anyOf": [signal, table]}
