"""Variants of a study: designs with names, and values of a sweep for which the loop is compiled anew.

Each variant is a study of its own, with the same seed, so that all have the same sensors. What a
variant says takes the place of what the study says, key by key; `set` changes parameters of the
graph, of any kind. A sweep makes a variant of each of its values where these are integers, texts,
truth values, numbers in fixed point, rates or clock offsets, and where they are those of a law of
drift, `"drift.amplifier.gain.ramp"`.
"""

import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.graphs.model.changes import is_rate
from proofmass.graphs.model.dependence import Dependence
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.keys import STUDY_KEYS
from proofmass.graphs.model.names import Missing, find_any

VARIANTS, SET, DRIFT = "variants", "set", "drift"
VARIANTS_EXAMPLE = 'write [study.variants] and below it cheap = { set = { "adc.bits" = 12 } }'
MOST_VARIANTS = 100
_SCALARS = ("runs", "seed", "design", "margins")
KEYS = {SET: "Parameters of the graph, of any kind."} | {
    key: doc for key, doc in STUDY_KEYS.items() if key not in ("graph", VARIANTS)
}


class Variant(NamedTuple):
    """Parameters of the graph that differ, and the tables of the study."""

    parameters: dict[str, Any]
    tables: dict[str, Any]


def variants_of(table: Mapping[str, Any], graph: Graph) -> dict[str, Variant]:
    """Return the variants of the tables of a study by name; one without a name if it says none. Raises `Refusal`."""
    tables = {key: entry for key, entry in table.items() if key != VARIANTS}
    named = {"": Variant({}, tables)}
    if VARIANTS in table:
        named = {name: _variant(entry, tables) for name, entry in _entries(table[VARIANTS])}
    flat = flatten(graph)
    variants: dict[str, Variant] = {}
    for name, variant in named.items():
        for swept, one in _each_value(variant, graph, flat):
            variants[", ".join(filter(None, (name, swept)))] = one
    if len(variants) > MOST_VARIANTS:
        raise Refusal("too many variants", key=VARIANTS, got=str(len(variants)), expected=f"at most {MOST_VARIANTS}")
    return variants


def _entries(given: object) -> Iterator[tuple[str, Mapping[str, Any]]]:
    if not isinstance(given, Mapping) or not given:
        raise Refusal("must be a table of variants", VARIANTS_EXAMPLE, key=VARIANTS, got=shown(given))
    for name, entry in given.items():
        if not isinstance(entry, Mapping):
            raise Refusal("must be a table", VARIANTS_EXAMPLE, key=f"{VARIANTS}.{name}", got=shown(entry))
        for key, inner in entry.items():
            if key not in KEYS:
                hint = key_hint(str(key), KEYS, entry)
                raise Refusal("unknown key", hint, key=f"{VARIANTS}.{name}.{key}", got=shown(key))
            if key not in _SCALARS and not isinstance(inner, Mapping):
                raise Refusal("must be a table", VARIANTS_EXAMPLE, key=f"{VARIANTS}.{name}.{key}", got=shown(inner))
        yield str(name), entry


def _variant(entry: Mapping[str, Any], tables: Mapping[str, Any]) -> Variant:
    """Return the tables of the study with those of a variant in their place, key by key."""
    merged = dict(tables)
    for key, inner in entry.items():
        if key in _SCALARS:
            merged[key] = inner
        elif key != SET:
            before = tables.get(key, {})
            merged[key] = {**before, **inner} if isinstance(before, Mapping) else inner
    return Variant(dict(entry.get(SET, {})), merged)


def _each_value(variant: Variant, graph: Graph, flat: FlatGraph) -> Iterator[tuple[str, Variant]]:
    """Yield a variant for each combination of the swept values that a compiled loop cannot vary."""
    sweep = variant.tables.get("sweep", {})
    sweep = sweep if isinstance(sweep, Mapping) else {}
    apart = {key: values for key, values in sweep.items() if _is_law(key, graph, flat) or _is_fixed(key, graph, flat)}
    if not apart:
        yield "", variant
        return
    for key, values in apart.items():
        if not isinstance(values, list | tuple) or not values:
            raise Refusal("must be a list of values", key=f"sweep.{key}", got=shown(values))
    rest = {key: values for key, values in sweep.items() if key not in apart}
    for chosen in itertools.product(*apart.values()):
        parameters, tables = dict(variant.parameters), {**variant.tables, "sweep": rest}
        for key, value in zip(apart, chosen, strict=True):
            if _is_law(key, graph, flat):
                tables[DRIFT] = _with_law(key, value, tables.get(DRIFT, {}))
            else:
                parameters[key] = value
        named = ", ".join(f"{key} = {value}" for key, value in zip(apart, chosen, strict=True))
        yield named, Variant(parameters, tables)


def _is_fixed(key: str, graph: Graph, flat: FlatGraph) -> bool:
    """Return whether a name is a rate, a parameter for which code is made anew, or a value that moves such."""
    if is_rate(graph, graph.exports.get(key, key)):
        return True
    if key in graph.values:
        steps = Dependence(graph).followers([key])
        return any(step.fixed or _is_fixed(step.target, graph, flat) for step in steps)
    found = find_any(flat, inside(graph, graph.exports.get(key, key)).partition("[")[0])
    if isinstance(found, Missing) or not isinstance(found[1], Parameter):
        return False
    return found[1].kind is not float or type(found[0]).has_formats()


def _is_law(key: str, graph: Graph, flat: FlatGraph) -> bool:
    """Return whether a name is one of a law of drift, and of no parameter."""
    if not key.startswith(f"{DRIFT}.") or key.count(".") < 2:
        return False
    return isinstance(find_any(flat, inside(graph, graph.exports.get(key, key))), Missing)


def _with_law(key: str, value: object, drift: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table of drifts with another number in a law."""
    parameter, _, law = key.removeprefix(f"{DRIFT}.").rpartition(".")
    entry = drift.get(parameter)
    if not isinstance(entry, Mapping):
        hint = did_you_mean(parameter, [str(name) for name in drift], "the parameters that drift")
        raise Refusal("nothing drifts by that name", hint, key=f"sweep.{key}", got=shown(parameter))
    return {**drift, parameter: {**entry, law: value}}
