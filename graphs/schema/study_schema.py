"""JSON Schema of a study: the table `[study]` of a graph file, or a file of its own."""

from typing import Any

from proofmass.graphs.model.keys import (
    CHANGE_KEYS,
    EPOCH_KEYS,
    LIMIT_KEYS,
    MISSION_KEYS,
    PHASE_KEYS,
    RECALIBRATION_KEYS,
    STUDY_KEYS,
)
from proofmass.graphs.model.limits import LARGEST_SEED, TEXT_LENGTH
from proofmass.graphs.model.loops import SETTLED, VERDICTS
from proofmass.graphs.studies.ageing import DRIFT_KEYS, LAWS, NEEDED_BY
from proofmass.graphs.studies.changes import CALIBRATION
from proofmass.graphs.studies.designs import DESIGNS
from proofmass.graphs.studies.distributions import LEAST_TRUNCATION, NORMAL, SHAPES, SPREAD_KEYS
from proofmass.graphs.studies.epochs import NEVER
from proofmass.graphs.studies.variants import KEYS as VARIANT_KEYS

Schema = dict[str, Any]

_QUANTITY = {"$ref": "#/$defs/quantity"}
_NUMBER: Schema = {"anyOf": [{"type": "number"}, _QUANTITY]}
_LIMIT: Schema = {"anyOf": [*_NUMBER["anyOf"], {"enum": list(VERDICTS)}]}
_WIDTH: Schema = {"anyOf": [{"type": "number", "minimum": 0}, _QUANTITY]}
_LIST: Schema = {"type": "array", "minItems": 1, "items": _NUMBER}
_DRIFT_TYPES: dict[str, Schema] = {"relative": {"type": "boolean"}, "mission": {"type": "string"}}
_FILE: Schema = {"type": "string", "minLength": 1, "maxLength": TEXT_LENGTH}


def study_schema(most_runs: int) -> Schema:
    """Return the keys of a study; `graph` is a key of study files only."""
    values: dict[str, Schema] = {
        "graph": _FILE,
        "runs": {"type": "integer", "minimum": 1, "maximum": most_runs, "default": 100},
        "seed": {"type": "integer", "minimum": 0, "maximum": LARGEST_SEED, "default": 0},
        "design": {"enum": list(DESIGNS), "default": "random"},
        "spread": _by_parameter(_spread()),
        "correlation": _by_parameter(_by_parameter({"anyOf": [_between(-1, 1), _QUANTITY]})),
        "sweep": _by_parameter({"type": "array", "minItems": 1}),
        "epochs": _table(
            {"ages": {"type": "array", "minItems": 1, "items": _WIDTH}, "every": _WIDTH, "until": _WIDTH}, EPOCH_KEYS
        ),
        "recalibration": _recalibration(),
        "margins": {"anyOf": [{"const": SETTLED}, *_WIDTH["anyOf"]]},
        "drift": _by_parameter(_drift()),
        "missions": _by_measure(_mission()),
        "changes": _by_measure(_changes()),
        "limits": _by_measure(
            _table({"at_least": _LIMIT, "at_most": _LIMIT, "change": _NUMBER, "from": _WIDTH}, LIMIT_KEYS)
        ),
        "stop": _by_measure(_WIDTH),
    }
    anything: Schema = {"type": "object"}
    inner: dict[str, Schema] = {key: values.get(key, anything) for key in VARIANT_KEYS}
    values["variants"] = {"type": "object", "additionalProperties": _table(inner, VARIANT_KEYS)}
    values["epochs"]["oneOf"] = [{"required": ["ages"]}, {"required": ["every", "until"]}]
    return _table(values, STUDY_KEYS)


def _spread() -> Schema:
    widths = dict.fromkeys((*NORMAL, "uniform", "triangular"), _WIDTH)
    values: dict[str, Schema] = {
        **widths,
        "values": _LIST,
        "weights": {"type": "array", "minItems": 1, "items": _WIDTH},
        "file": _FILE,
        "column": {"type": "string"},
        "relative": {"type": "boolean", "default": False},
        "truncated": {"anyOf": [{"type": "number", "minimum": LEAST_TRUNCATION}, _QUANTITY]},
    }
    suits = {"weights": ["values"], "column": ["file"], "file": ["column"]}
    truncated = {"if": {"required": ["truncated"]}, "then": {"anyOf": [{"required": [shape]} for shape in NORMAL]}}
    return _table(values, SPREAD_KEYS) | {
        "oneOf": [{"required": [shape]} for shape in SHAPES],
        "dependentRequired": suits,
        "allOf": [truncated],
    }


def _recalibration() -> Schema:
    interval: Schema = {"anyOf": [{"const": NEVER}, *_WIDTH["anyOf"]]}
    every: Schema = {"anyOf": [*interval["anyOf"], {"type": "array", "minItems": 1, "items": interval}]}
    carried = _by_parameter({"type": "string"})
    return _table({"every": every, "carried": carried}, RECALIBRATION_KEYS) | {"required": ["every", "carried"]}


def _changes() -> Schema:
    since: Schema = {"anyOf": [{"const": CALIBRATION}, *_WIDTH["anyOf"]]}
    values: dict[str, Schema] = {"measure": {"type": "string"}, "since": since, "relative": {"type": "boolean"}}
    return _table(values, CHANGE_KEYS) | {"required": ["measure"]}


def _mission() -> Schema:
    phase = _table({"temperature": _NUMBER, "for": _WIDTH}, PHASE_KEYS) | {"required": list(PHASE_KEYS)}
    point: Schema = {"type": "array", "minItems": 2, "maxItems": 2, "items": _NUMBER}
    values: dict[str, Schema] = {
        "phases": {"type": "array", "minItems": 1, "items": phase},
        "points": {"type": "array", "minItems": 2, "items": point},
        "file": _FILE,
        "time": {"type": "string"},
        "temperature": {"type": "string"},
    }
    ways = [{"required": [way]} for way in ("phases", "points", "file")]
    return _table(values, MISSION_KEYS) | {"oneOf": ways}


def _drift() -> Schema:
    values = {key: _DRIFT_TYPES.get(key, _NUMBER) for key in DRIFT_KEYS}
    return _table(values, DRIFT_KEYS) | {
        "anyOf": [{"required": [law]} for law in LAWS],
        "dependentRequired": {key: [law] for key, law in NEEDED_BY.items()},
    }


def _table(values: dict[str, Schema], docs: dict[str, str]) -> Schema:
    return {
        "type": "object",
        "properties": {key: {"description": docs[key], **value} for key, value in values.items()},
        "additionalProperties": False,
    }


def _by_parameter(entry: Schema) -> Schema:
    """Return a table by parameters: exported names, or paths, which are single keys in quotes."""
    return {"type": "object", "propertyNames": {"pattern": r"^[a-z][a-z0-9_.]*$"}, "additionalProperties": entry}


def _by_measure(entry: Schema) -> Schema:
    """Return a table by measures; margins are named after their loop, which may be a path."""
    return {"type": "object", "propertyNames": {"pattern": r"^[a-z][a-z0-9_.]*$"}, "additionalProperties": entry}


def _between(low: float, high: float) -> Schema:
    return {"type": "number", "minimum": low, "maximum": high}
