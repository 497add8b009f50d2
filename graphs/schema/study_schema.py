"""JSON Schema of a study: the table `[study]` of a graph file, or a file of its own."""

from proofmass.graphs.model.keys import (
    CHANGE_KEYS,
    EPOCH_KEYS,
    LIMIT_KEYS,
    MISSION_KEYS,
    PHASE_KEYS,
    RECALIBRATION_KEYS,
    STUDY_INTEGERS,
    STUDY_KEYS,
)
from proofmass.graphs.model.limits import TEXT_LENGTH
from proofmass.graphs.model.loops import SETTLED, VERDICTS
from proofmass.graphs.schema.tables import (
    FLAG,
    NUMBER,
    PARAMETERS,
    QUANTITY,
    Schema,
    by_name,
    either,
    needs_one,
    pair,
    plain,
    several,
    table,
)
from proofmass.graphs.studies.ageing import DRIFT_KEYS, LAWS, NEEDED_BY
from proofmass.graphs.studies.changes import CALIBRATION
from proofmass.graphs.studies.designs import DESIGNS
from proofmass.graphs.studies.distributions import LEAST_TRUNCATION, NORMAL, SHAPES, SPREAD_KEYS
from proofmass.graphs.studies.epochs import NEVER
from proofmass.graphs.studies.variants import KEYS as VARIANT_KEYS

_LIMIT: Schema = either(NUMBER, {"enum": list(VERDICTS)})
_WIDTH: Schema = {"allOf": [{"$ref": "#/$defs/wid"}]}
_FILE: Schema = {"type": "string", "minLength": 1, "maxLength": TEXT_LENGTH}
_TEXT: Schema = {"type": "string"}


def study_schema(*required: str) -> Schema:
    """Return the keys of a study; "graph" is one of study files only, which require it."""
    ages = {"ages": several(_WIDTH), "every": _WIDTH, "until": _WIDTH}
    limits = {"at_least": _LIMIT, "at_most": _LIMIT, "change": NUMBER, "from": _WIDTH}
    values: dict[str, Schema] = {
        **dict.fromkeys(required, _FILE),
        **{key: plain(form) for key, form in STUDY_INTEGERS.items()},
        "design": {"enum": list(DESIGNS), "default": "random"},
        "spread": by_name({"$ref": "#/$defs/spread"}, PARAMETERS),
        "correlation": by_name(
            by_name(either({"type": "number", "minimum": -1, "maximum": 1}, QUANTITY), PARAMETERS), PARAMETERS
        ),
        "sweep": by_name({"type": "array", "minItems": 1}, PARAMETERS),
        "epochs": table(ages, EPOCH_KEYS, oneOf=[{"required": ["ages"]}, {"required": ["every", "until"]}]),
        "recalibration": _recalibration(),
        "margins": either({"const": SETTLED}, _WIDTH),
        "drift": by_name({"$ref": "#/$defs/drift_law"}, PARAMETERS),
        "missions": by_name({"$ref": "#/$defs/mission"}, PARAMETERS),
        "changes": by_name({"$ref": "#/$defs/change"}, PARAMETERS),
        "limits": by_name(table(limits, LIMIT_KEYS), PARAMETERS),
        "stop": by_name(_WIDTH, PARAMETERS),
    }
    anything: Schema = {"type": "object"}
    inner: dict[str, Schema] = {key: values.get(key, anything) for key in VARIANT_KEYS}
    inner["epochs"] = table(ages, EPOCH_KEYS)
    return table(values | {"variants": by_name(table(inner, VARIANT_KEYS))}, STUDY_KEYS, *required)


def study_parts() -> dict[str, Schema]:
    """Return the definitions of the entries that a study and its variants have."""
    return {"spread": _spread(), "drift_law": _drift(), "mission": _mission(), "change": _changes()}


def _spread() -> Schema:
    values: dict[str, Schema] = {
        **dict.fromkeys((*NORMAL, "uniform", "triangular"), _WIDTH),
        "values": several(NUMBER),
        "weights": several(_WIDTH),
        "file": _FILE,
        "column": _TEXT,
        "relative": FLAG | {"default": False},
        "truncated": either({"type": "number", "minimum": LEAST_TRUNCATION}, QUANTITY),
    }
    suits = {"weights": ["values"], "column": ["file"], "file": ["column"]}
    truncated = {"if": {"required": ["truncated"]}, "then": {"anyOf": needs_one(*NORMAL)}}
    return table(values, SPREAD_KEYS, oneOf=needs_one(*SHAPES), dependentRequired=suits, allOf=[truncated])


def _recalibration() -> Schema:
    interval = either({"const": NEVER}, _WIDTH)
    values = {"every": either(interval, several(interval)), "carried": by_name(_TEXT, PARAMETERS)}
    return table(values, RECALIBRATION_KEYS, "every", "carried")


def _changes() -> Schema:
    values = {"measure": _TEXT, "since": either({"const": CALIBRATION}, _WIDTH), "relative": FLAG}
    return table(values, CHANGE_KEYS, "measure")


def _mission() -> Schema:
    phase = table({"temperature": NUMBER, "for": _WIDTH}, PHASE_KEYS, *PHASE_KEYS)
    ways = {"phases": several(phase), "points": several(pair(NUMBER), 2), "file": _FILE}
    return table({**ways, "time": _TEXT, "temperature": _TEXT}, MISSION_KEYS, oneOf=needs_one(*ways))


def _drift() -> Schema:
    types = {"relative": FLAG, "mission": _TEXT}
    needs = {key: [law] for key, law in NEEDED_BY.items()}
    values = {key: types.get(key, NUMBER) for key in DRIFT_KEYS}
    return table(values, DRIFT_KEYS, anyOf=needs_one(*LAWS), dependentRequired=needs)
