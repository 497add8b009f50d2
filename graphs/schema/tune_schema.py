"""JSON Schema of the table `[tune]` of a graph file."""

from typing import Any

from proofmass.graphs.model.keys import FREE_KEYS, GOAL_KEYS, TUNE_KEYS
from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.graphs.model.loops import SETTLED
from proofmass.graphs.tuning.build import MOST_SAMPLES, MOST_STARTS, SAMPLES, SCALES, STARTS
from proofmass.graphs.tuning.quantities import FIGURES, QUANTITY_KEYS

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
        "at": {"anyOf": [{"const": SETTLED}, *_NUMBER["anyOf"]]},
        "starts": {"type": "integer", "minimum": 1, "maximum": MOST_STARTS, "default": STARTS},
        "samples": {"type": "integer", "minimum": 1, "maximum": MOST_SAMPLES, "default": SAMPLES},
        "seed": {"type": "integer", "minimum": 0, "maximum": LARGEST_SEED, "default": 0},
    }
    return _table(values, TUNE_KEYS) | {"required": ["free", "goals"]}


def _goal() -> Schema:
    quantity: dict[str, Schema] = dict.fromkeys(QUANTITY_KEYS, _TEXT)
    quantity["figure"] = {"enum": list(FIGURES)}
    quantity["band"] = {"type": "array", "minItems": 2, "maxItems": 2, "items": _NUMBER}
    wanted: dict[str, Schema] = {"at_least": _LIMIT, "at_most": _LIMIT} | dict.fromkeys(
        ("soft", "minimise", "maximise"), _FLAG
    )
    kinds = ("loop", "noise", "scale_factor", "bias", "measure")
    needs = {"loop": ["figure"], "figure": ["loop"], "scale_factor": ["input"], "bias": ["input"], "band": ["noise"]}
    return _table(quantity | wanted, {**QUANTITY_KEYS, **GOAL_KEYS}) | {
        "oneOf": [{"required": [key]} for key in kinds],
        "anyOf": [{"required": [key]} for key in wanted if key != "soft"],
        "dependentRequired": needs,
    }


def _table(values: dict[str, Schema], docs: dict[str, str]) -> Schema:
    return {
        "type": "object",
        "properties": {key: {"description": docs[key], **value} for key, value in values.items()},
        "additionalProperties": False,
    }


def _by_name(entry: Schema, pattern: str | None) -> Schema:
    names = {"propertyNames": {"pattern": pattern}} if pattern else {}
    return {"type": "object", **names, "additionalProperties": entry}
