"""Keys at the top of a graph file, from the fields of `Graph`; those with plain values are read by their form."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import TypeGuard

from proofmass.blocks.declaration.problem import Problem, shown
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.keys import Integer, Text
from proofmass.graphs.model.limits import LARGEST_SEED

_AT_FIELDS = {field.name: field.metadata for field in fields(Graph) if "meaning" in field.metadata}
TOP_KEYS: dict[str, str] = {  # with their meanings
    **{name: of["meaning"] for name, of in _AT_FIELDS.items()},
    "study": "A Monte Carlo study of the graph: runs, spread, drift, epochs; `proofmass montecarlo` runs it.",
    "tune": "What to tune: [tune.free] and [tune.goals]; `proofmass tune` finds the parameters.",
}
PLAIN_KEYS: dict[str, Text | Integer] = {name: of["form"] for name, of in _AT_FIELDS.items() if of["form"]}


def wrong_values(values: Mapping[str, object]) -> Iterator[Problem]:
    """Yield a problem for each wrong value of a plain key; a value that may be missing is None."""
    for key, value in values.items():
        form = PLAIN_KEYS[key]
        if isinstance(form, Text):
            yield from _wrong_text(key, value, form)
        elif value is not None or form.default is not None:
            yield from _wrong_integer(key, value, form)


def _wrong_text(key: str, value: object, form: Text) -> Iterator[Problem]:
    if not isinstance(value, str):
        yield Problem(message="must be a string", got=shown(value), path=(key,))
    elif len(value) > form.longest:
        yield Problem(message=f"longer than {form.longest} characters", got=shown(value), path=(key,))
    elif not value.isascii() and any("\ud800" <= letter <= "\udfff" for letter in value):
        yield Problem(message="holds half a character", got=shown(value), path=(key,))


def _wrong_integer(key: str, value: object, form: Integer) -> Iterator[Problem]:
    expected = f"an integer from {form.lowest} to {form.highest:g}"
    if not form.whole(value):
        hint = f"write it without a point or an exponent: {key} = {int(value)}" if _is_whole(value) else ""
        yield Problem(message="must be an integer", got=shown(value), expected=expected, hint=hint, path=(key,))
    elif not form.holds(value):
        yield Problem(message="out of range", got=shown(value), expected=expected, path=(key,))


def _is_whole(value: object) -> TypeGuard[float]:
    return isinstance(value, float) and value.is_integer() and 0 <= value <= LARGEST_SEED
