"""JSON Schema of the table `[tune]` of a graph file."""

from collections.abc import Mapping

from proofmass.graphs.model.keys import FREE_KEYS, GOAL_KEYS, TUNE_INTEGERS, TUNE_KEYS
from proofmass.graphs.model.loops import SETTLED
from proofmass.graphs.model.quantities import FIGURES, QUANTITIES, QUANTITY_KEYS, RESPONSE_FIGURES
from proofmass.graphs.schema.tables import (
    FLAG,
    NUMBER,
    PARAMETERS,
    Schema,
    by_name,
    either,
    needs_one,
    pair,
    plain,
    several,
    table,
)
from proofmass.graphs.tuning.build import SCALES

_LIMIT: Schema = {"anyOf": [{"type": "number"}, {"type": "string"}]}  # nothing else is in decibels
_TEXT: Schema = {"type": "string", "minLength": 1}
_NEEDS = {
    "loop": ["figure"],
    "scale_factor": ["input"],
    "bias": ["input"],
    "response": ["input"],
    "band": ["noise"],
    "frequency": ["response"],
}


def tune_schema() -> Schema:
    """Return the keys of a tuning."""
    bounds = {"at_least": NUMBER, "at_most": NUMBER, "scale": {"enum": list(SCALES)}}
    values: dict[str, Schema] = {
        "free": by_name(table(bounds, FREE_KEYS, "at_least", "at_most"), PARAMETERS),
        "goals": by_name(_goal()),
        "points": by_name(by_name(NUMBER, PARAMETERS)),
        "tolerances": by_name(NUMBER, PARAMETERS),
        "ages": several(NUMBER),
        "at": either({"const": SETTLED}, NUMBER),
        **{key: plain(form) for key, form in TUNE_INTEGERS.items()},
    }
    return table(values, TUNE_KEYS, "free", "goals")


def quantity_schema(more: dict[str, Schema], docs: Mapping[str, str], **wanted: list[Schema]) -> Schema:
    """Return the keys that name a quantity, and others beside them."""
    quantity: dict[str, Schema] = dict.fromkeys(QUANTITY_KEYS, _TEXT)
    quantity["figure"] = {"enum": [*FIGURES, *(figure for figure in RESPONSE_FIGURES if figure not in FIGURES)]}
    quantity |= {"band": pair(NUMBER), "frequency": NUMBER, "yield": either({"const": True}, _TEXT)}
    docs = {**QUANTITY_KEYS, **docs}
    return table(quantity | more, docs, oneOf=needs_one(*QUANTITIES), dependentRequired=_NEEDS, **wanted)


def _goal() -> Schema:
    wanted = {"at_least": _LIMIT, "at_most": _LIMIT} | dict.fromkeys(("minimise", "maximise"), FLAG)
    return quantity_schema(wanted | {"soft": FLAG}, GOAL_KEYS, anyOf=needs_one(*wanted))
