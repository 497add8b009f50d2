"""JSON Schemas of graph and study files, for completion and checks in an editor; derived from the blocks.

Editors mark the place of each fault, so every fault is told once: keys are at the root, a block is
judged by the definition of its kind alone, and what one value may be is one form, not a choice of
several.
"""

import json
from collections import Counter
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
    REQUIREMENT_KEYS,
)
from proofmass.graphs.model.limits import BLOCKS, LARGEST_RUN, NAME, TEXT_LENGTH, WIRES
from proofmass.graphs.model.measures import MEASURE_KEYS
from proofmass.graphs.model.requirements import SPREAD
from proofmass.graphs.model.statistics import OPTIONS, STATISTICS, TIMES, Statistic
from proofmass.graphs.model.targets import CLOCK_OFFSET
from proofmass.graphs.model.top_keys import PLAIN_KEYS, TOP_KEYS
from proofmass.graphs.model.values import MOST_VALUES
from proofmass.graphs.schema.study_schema import study_parts, study_schema
from proofmass.graphs.schema.tables import NO_KEY, Schema, by_name, by_type, needs_one, plain, table
from proofmass.graphs.schema.tune_schema import quantity_schema, tune_schema

_NUMBER = r"[+-]?(\d[\d_]*\.?\d*|\.\d+)([eE][+-]?\d+)?(/\d+)?"
_QUANTITY = rf"^\s*{_NUMBER}\s*([A-Za-zµμΩ%°√1(][A-Za-zμΩ%√°-¹⁰-⁻⋅×0-9*/^()+. -]*)?$"
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
    "additionalProperties": NO_KEY,
}
_PART, _INSIDE = "graph from a file", "graph"  # definitions of blocks that are graphs
_A_TEXT: Schema = {"$ref": "#/$defs/text"}
_USUAL: dict[str, Schema] = {  # short names: they stand in the file 500 times
    "num": {"type": "number"},
    "pos": {"type": "number", "exclusiveMinimum": 0.0},
    "min0": {"type": "number", "minimum": 0.0},
    "part": {"type": "number", "minimum": 0.0, "maximum": 1.0},
    "count": {"type": "integer", "minimum": 1},
    "int": {"type": "integer"},
}
_FORMAT = r"^\s*\(\s*\d{1,4}\s*,\s*[+-]?\d{1,4}\s*\)(\s+unsigned)?\s*$"
_BOUNDS = {
    "above": "exclusiveMinimum",
    "at_least": "minimum",
    "below": "exclusiveMaximum",
    "at_most": "maximum",
}
_JSON_TYPES = {"float": "number", "int": "integer", "bool": "boolean", "str": "string"}


def graph_schema(own: Own | None = None) -> Schema:
    """Return the JSON Schema, draft 2020-12, of graph files; `own` are own blocks by name."""
    kinds = all_blocks(own)
    rate = _formulated({"type": "number", "exclusiveMinimum": 0})
    values: dict[str, Schema] = {
        **{key: plain(form) for key, form in PLAIN_KEYS.items()},
        "rate": rate | {"examples": ["50 kHz", "20 us"]},
        "duration": _formulated({"type": "number", "minimum": 0}) | {"examples": ["20 s"]},
        "values": by_name(_formulated({"type": "number"}), f"^{NAME.pattern}$", maxProperties=MOST_VALUES),
        "formulas": by_name({"$ref": "#/$defs/formula"}, f"^{_PATH}$"),
        "wires": {
            "type": "array",
            "maxItems": WIRES,
            "items": {"type": "string", "pattern": rf"^\s*{_SIGNAL}\s*->\s*{_SIGNAL}\s*$"},
            "examples": [["sensor.displacement -> readout.input"]],
        },
        "probes": {"type": "array", "items": _probe(), "examples": [["adc.code"]]},
        "measures": _measures(),
        "requirements": by_name(_requirement()),
        "study": study_schema(),
        "tune": tune_schema(),
        "exports": {
            "type": "object",
            "properties": dict.fromkeys(sorted({*PART_KEYS, *BLOCK_KEYS}), NO_KEY),
            "patternProperties": {f"^{NAME.pattern}$": {"type": "string", "pattern": rf"^{_NAME}(\.{_NAME})*$"}},
            "additionalProperties": NO_KEY,
        },
        "integration": _integration(),
        "loops": by_name(_loop(), f"^{_PATH}$"),
        "blocks": by_name({"$ref": "#/$defs/block"}, f"^{_PATH}$", minProperties=1, maxProperties=BLOCKS),
    }
    blocks, repeated = _once({name: _block(kind) for name, kind in kinds.items()})
    return {
        **_head("proofmass graph"),
        "properties": {key: {"description": doc, **values[key]} for key, doc in TOP_KEYS.items()},
        **_GRAPH,
        "$defs": {
            **_shared(),
            **{name: {**form, "type": [form["type"], "string"], "allOf": [_A_TEXT]} for name, form in _USUAL.items()},
            "numbers": _numbers(),
            "list": _list({}),
            "fix": {"type": "string", "pattern": _FORMAT},
            "block": _any_block(blocks, rate),
            **repeated,
            **_parts(rate),
            **study_parts(),
        },
    }


def study_file_schema() -> Schema:
    """Return the JSON Schema of study files, which name their graph."""
    return {**_head("proofmass study"), **study_schema("graph"), "$defs": {**_shared(), **study_parts()}}


def _head(title: str) -> Schema:
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, "type": "object"}


def _shared() -> Schema:
    """Return the definitions of texts that stand for numbers."""
    formula = r"^\s*="
    longest = max(TEXT_LENGTH, LENGTH + 2)
    return {
        "quantity": {"type": "string", "pattern": _QUANTITY, "maxLength": TEXT_LENGTH},
        "val": {"type": ["number", "string"], "pattern": _QUANTITY, "maxLength": TEXT_LENGTH},
        "wid": {"type": ["number", "string"], "minimum": 0, "pattern": _QUANTITY, "maxLength": TEXT_LENGTH},
        "formula": {"type": "string", "pattern": formula, "maxLength": LENGTH + 2},
        "text": {"pattern": f"{_QUANTITY}|{formula}", "maxLength": longest},  # of a number with a unit, or a formula
    }


def _once(blocks: dict[str, Schema]) -> tuple[dict[str, Schema], dict[str, Schema]]:
    """Return definitions of blocks, and those of the parameters several have in the same words.

    That takes a third off the file.
    """
    said = Counter(json.dumps(form) for block in blocks.values() for form in block["properties"].values())
    names: dict[str, str] = {}
    repeated: dict[str, Schema] = {}
    for block in blocks.values():
        for name, form in block["properties"].items():
            text = json.dumps(form)
            if said[text] > 1 and form is not True:
                if text not in names:
                    names[text] = f"p{len(repeated)}"
                    repeated[names[text]] = form
                block["properties"][name] = {"$ref": f"#/$defs/{names[text]}"}
    return blocks, repeated


def _any_block(blocks: Mapping[str, Schema], rate: Schema) -> Schema:
    """Return the schema of a block: that of its kind, of a part from a file, or of a graph within the graph."""
    alike: dict[str, list[str]] = {}  # kinds by what they take
    for name, block in blocks.items():
        alike.setdefault(json.dumps(block), []).append(name)
    of_kind = [{"if": {"properties": {"kind": {"enum": names}}}, "then": blocks[names[0]]} for names in alike.values()]
    clock = {"rate": rate, CLOCK_OFFSET: _formulated({"type": "number", "minimum": 0})}
    values = {"kind": {"enum": list(blocks)}, **clock}
    keys = {key: {"description": BLOCK_KEYS[key], **value} for key, value in values.items()}
    return {
        "type": "object",
        "if": {"required": ["kind"]},
        "then": {"properties": keys, "allOf": of_kind},
        "else": {
            "if": {"required": ["graph"]},
            "then": {"$ref": f"#/$defs/{quote(_PART)}"},
            "else": {
                "if": {"required": ["blocks"]},
                "then": {"$ref": f"#/$defs/{quote(_INSIDE)}"},
                "else": {"properties": {"kind": {"description": BLOCK_KEYS["kind"]}}, "required": ["kind"]},
            },
        },
    }


def _block(kind: type[Block]) -> Schema:
    """Return the parameters of a kind; what all kinds have is said once for all, and named here."""
    about = facts(kind)
    common = ("kind",) if about["continuous"] else ("kind", "rate", CLOCK_OFFSET)
    properties = dict.fromkeys(common, True) | {
        name: _parameter(parameter) for name, parameter in about["parameters"].items()
    }
    return {"properties": properties, "additionalProperties": NO_KEY}


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
        "from": _formulated({"type": "number", "minimum": 0}),
        "until": _formulated({"type": "number", "exclusiveMinimum": 0}),
        "unit": _UNIT,
        **{key: _option(row, key) for row in STATISTICS.values() for key in row.options},
    }
    alike: dict[tuple[str, ...], list[str]] = {}  # statistics by their options
    for statistic, row in STATISTICS.items():
        alike.setdefault(tuple(row.options), []).append(statistic)
    suited = [
        {
            "if": {"properties": {"statistic": {"enum": statistics}}, "required": ["statistic"]},
            "then": {
                "required": list(options),
                "properties": dict.fromkeys(sorted(OPTIONS.keys() - {*options}), NO_KEY),
            },
        }
        for options, statistics in alike.items()
    ]
    measure = table(values, MEASURE_KEYS, "signal", "statistic", allOf=suited)
    formula: Schema = {"$ref": "#/$defs/formula"}
    of_others = table({FORMULA: formula, "unit": _UNIT}, MEASURE_FORMULA_KEYS, FORMULA)
    of_table = {"if": {"required": [FORMULA]}, "then": of_others, "else": measure}
    return by_name(by_type(formula, of_table), f"^{NAME.pattern}$")


def _option(statistic: Statistic, key: str) -> Schema:
    """Return the schema of an option: a time, or a number within the parameter's bounds."""
    if key in TIMES or statistic.block is None:
        return _formulated({"type": "number", "minimum": 0})
    parameter = facts(statistic.block)["parameters"][key]
    return _formulated({"type": _JSON_TYPES[parameter["type"]]} | _bounds(parameter))


def _parts(rate: Schema) -> dict[str, Schema]:
    """Return the schema of blocks that are graphs: from a file, or a table with its keys."""
    values: dict[str, Schema] = {
        "graph": {"type": "string", "minLength": 1, "maxLength": TEXT_LENGTH},
        "rate": rate,
        CLOCK_OFFSET: _formulated({"type": "number", "minimum": 0}),
        "count": {"type": "integer", "minimum": 1, "maximum": BLOCKS},
    }
    inside = {"description": "A parameter that the graph exports, or one inside it by its path."}
    return {
        _PART: {
            "properties": {key: {"description": PART_KEYS[key], **value} for key, value in values.items()}
            | dict.fromkeys(("kind", "blocks"), NO_KEY),
            "patternProperties": {f"^{_PATH}$": inside},
            "additionalProperties": NO_KEY,
        },
        _INSIDE: {
            "type": "object",
            "properties": {key: {"$ref": f"#/properties/{key}"} for key in TOP_KEYS}
            | {CLOCK_OFFSET: {"description": PART_KEYS[CLOCK_OFFSET], **values[CLOCK_OFFSET]}},
            **_GRAPH,
        },
    }


def _loop() -> Schema:
    least = _quantity({"type": "number", "minimum": 0})
    values = {key: {"type": "string", "pattern": f"^{_SIGNAL}$"} if key == "open_at" else least for key in LOOP_KEYS}
    return table(values, LOOP_KEYS, "open_at")


def _parameter(parameter: Mapping[str, Any]) -> Schema:
    about = {"description": _description(parameter), "default": _short(parameter["default"])}
    bounds = _bounds(parameter)
    if "choices" in parameter:
        return about | {"enum": parameter["choices"]}
    if parameter["type"] == "list":
        return about | (_defined("list") if not bounds else _list(bounds))
    if parameter["type"] == "format":
        return about | _defined("fix")
    value = {"type": _JSON_TYPES[parameter["type"]]} | bounds
    return about | (value if parameter["type"] in ("bool", "str") else _formulated(value))


def _short(default: Any) -> Any:
    """Return a default without a point where it is whole."""
    return int(default) if isinstance(default, float) and default.is_integer() and abs(default) < 1e6 else default


def _list(bounds: Schema) -> Schema:
    entry = _formulated({"type": "number"} | bounds)
    return by_type({"type": "array", "minItems": 1, "items": entry}, {"$ref": "#/$defs/numbers"})


def _defined(name: str) -> Schema:
    """Return a reference to a definition; Taplo reads no key beside a bare one."""
    return {"allOf": [{"$ref": f"#/$defs/{name}"}]}


def _numbers() -> Schema:
    """Return the schema of a list of numbers that a file holds."""
    name = {"type": "string", "maxLength": TEXT_LENGTH}
    return {
        "type": "object",
        "properties": {"file": name, "column": name, "part": {"enum": list(PARTS)}},
        "required": ["file"],
        "additionalProperties": NO_KEY,
    }


def _bounds(parameter: Mapping[str, Any]) -> Schema:
    return {word: parameter[fact] for fact, word in _BOUNDS.items() if fact in parameter}


def _description(parameter: Mapping[str, Any]) -> str:
    """Return doc and unit, which an editor shows beside the key; the bounds stand in the schema."""
    unit = parameter["unit"].replace("{", "").replace("}", "")
    doc = str(parameter["doc"])
    return f"{doc.rstrip('.')} [{unit}]" if unit not in ("", "1") else doc.rstrip(".")


def _quantity(number: Schema) -> Schema:
    """Return the schema of a number in the declared unit, or a string of a number and a unit."""
    return {**number, "type": [number["type"], "string"], "allOf": [{"$ref": "#/$defs/val"}]}


def _requirement() -> Schema:
    values: dict[str, Schema] = {
        key: {"type": ["number", "string"]} if key in ("at_least", "at_most") else {"type": "string"}
        for key in REQUIREMENT_KEYS
    }
    values["quantity"] = by_type({"type": "string"}, quantity_schema({}, {}))
    tolerances = by_name({"type": ["number", "string", "array"]}, minProperties=1)
    values["tolerances"] = by_type({"const": SPREAD}, tolerances)
    values["proved"] = {"type": "boolean"}
    return table(values, REQUIREMENT_KEYS, "quantity", anyOf=needs_one("at_least", "at_most"))


def _formulated(number: Schema) -> Schema:
    """Return the schema of a number, a quantity or a formula: bounds are those of numbers, the
    pattern is of texts.

    Usual forms are definitions of their own, which keeps the file small.
    """
    usual = next((name for name, form in _USUAL.items() if form == number), "")
    if usual:
        return _defined(usual)
    of_type = _defined("int" if number["type"] == "integer" else "num")
    return {word: bound for word, bound in number.items() if word != "type"} | of_type


def _probe() -> Schema:
    """Return the schema of a signal, or of a table with one: the pattern is of texts, the keys are of tables."""
    signal = {"type": "string", "pattern": f"^{_SIGNAL}$"}
    every = {"type": "integer", "minimum": 1, "maximum": LARGEST_RUN}
    return {
        **signal,
        "type": ["string", "object"],
        "properties": {"signal": signal, "every": every, "unit": _UNIT},
        "required": ["signal"],
        "additionalProperties": NO_KEY,
    }
