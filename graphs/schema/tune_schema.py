"""JSON Schema of the table `[tune]` of a graph file."""

from collections.abc import Mapping
from typing import Any

from proofmass.graphs.model.keys import FREE_KEYS, GOAL_KEYS, TUNE_KEYS
from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.graphs.model.loops import SETTLED
from proofmass.graphs.model.quantities import FIGURES, QUANTITIES, QUANTITY_KEYS, RESPONSE_FIGURES
from proofmass.graphs.tuning.build import MOST_SAMPLES, MOST_STARTS, SAMPLES, SCALES, STARTS

Schema = dict[str, Any]

_NUMBER: Schema = {"anyOf": [{"type": "number"}, {"$ref": "#/$defs/quantity"}]}
_LIMIT: Schema = {"anyOf": [{"type": "number"}, {"type": "string"}]}  # decibels are no unit of anything else
_FLAG: Schema = {"type": "boolean"}
_TEXT: Schema = {"type": "string", "minLength": 1}


def tune_schema() -> Schema:
    """Return the keys of a tuning."""
    free = _table({"at_least": _NUMBER, "at_most": _NUMBER, "scale": {"enum": list(SCALES)}}, FREE_KEYS)
    values: dict[str, Schema] = {
        "free": _by_name(free | {"required": ["at_least", "at_most"]}, r"^[a-z][a-z0-9_.]*$"),
        "goals": _by_name(_goal(), None),
        "points": _by_name(_by_name(_NUMBER, r"^[a-z][a-z0-9_.]*$"), None),
        "tolerances": _by_name(_NUMBER, r"^[a-z][a-z0-9_.]*$"),
        "ages": {"type": "array", "minItems": 1, "items": _NUMBER},
        "at": {"anyOf": [{"const": SETTLED}, *_NUMBER["anyOf"]]},
        "starts": {"type": "integer", "minimum": 1, "maximum": MOST_STARTS, "default": STARTS},
        "samples": {"type": "integer", "minimum": 1, "maximum": MOST_SAMPLES, "default": SAMPLES},
        "seed": {"type": "integer", "minimum": 0, "maximum": LARGEST_SEED, "default": 0},
    }
    return _table(values, TUNE_KEYS) | {"required": ["free", "goals"]}


def quantity_schema(more: dict[str, Schema], docs: Mapping[str, str]) -> Schema:
    """Return the keys that name a quantity, and others beside them."""
    quantity: dict[str, Schema] = dict.fromkeys(QUANTITY_KEYS, _TEXT)
    quantity["figure"] = {"enum": [*FIGURES, *(figure for figure in RESPONSE_FIGURES if figure not in FIGURES)]}
    quantity["band"] = {"type": "array", "minItems": 2, "maxItems": 2, "items": _NUMBER}
    quantity["frequency"] = _NUMBER
    quantity["yield"] = {"anyOf": [{"const": True}, _TEXT]}
    needs = {
        "loop": ["figure"],
        "scale_factor": ["input"],
        "bias": ["input"],
        "response": ["input"],
        "band": ["noise"],
        "frequency": ["response"],
    }
    return _table(quantity | more, {**QUANTITY_KEYS, **docs}) | {
        "oneOf": [{"required": [key]} for key in QUANTITIES],
        "dependentRequired": needs,
    }


def _goal() -> Schema:
    wanted: dict[str, Schema] = {"at_least": _LIMIT, "at_most": _LIMIT} | dict.fromkeys(
        ("soft", "minimise", "maximise"), _FLAG
    )
    return quantity_schema(wanted, GOAL_KEYS) | {"anyOf": [{"required": [key]} for key in wanted if key != "soft"]}


def _table(values: dict[str, Schema], docs: Mapping[str, str]) -> Schema:
    return {
        "type": "object",
        "properties": {key: {"description": docs[key], **value} for key, value in values.items()},
        "additionalProperties": False,
    }


def _by_name(entry: Schema, pattern: str | None) -> Schema:
    names = {"propertyNames": {"pattern": pattern}} if pattern else {}
    return {"type": "object", **names, "additionalProperties": entry}
