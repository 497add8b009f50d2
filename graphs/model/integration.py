"""Integration of the continuous blocks of a graph between ticks: the table `[integration]`."""

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, problems_of_table, shown
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.rates import read_duration

CHOICES = {
    "method": ("auto", "exact", "runge_kutta_4", "dormand_prince", "radau"),
    "sources": ("held", "first_order_hold", "continuous"),
    "algebraic_loops": ("refuse", "newton"),
}
FINEST, COARSEST = 1e-14, 0.1  # accuracy
MOST_SUBSTEPS = 1_000_000
INTEGRATION_KEYS = {
    "method": "exact (linear blocks only), runge_kutta_4, dormand_prince (adaptive steps), radau (stiff), or auto.",
    "accuracy": "Error that a run reaches, of the largest value of each state; runge_kutta_4 does not watch it.",
    "substeps": "Sub-steps in each tick, instead of as many as the accuracy asks for.",
    "event_tolerance": "How exactly the time of an event is found; 1e-12 of a tick when nothing is said.",
    "sources": "Sources that drive continuous blocks: held over the tick, first_order_hold, or continuous.",
    "algebraic_loops": "refuse loops without delay, or solve them in every tick by newton's method.",
}
_problem = problems_of_table("integration")


@dataclasses.dataclass(frozen=True)
class Integration:
    """Settings for the integration of the continuous blocks of a graph; raises `ModelError`."""

    method: str = "auto"
    accuracy: float = 1e-9
    substeps: int | None = None
    event_tolerance: float | None = None  # seconds, or a text with its unit
    sources: str = "held"
    algebraic_loops: str = "refuse"

    def __post_init__(self) -> None:
        problems = list(self._problems())
        if problems:
            raise ModelError(problems)

    def _problems(self) -> Iterator[Problem]:
        for name, choices in CHOICES.items():
            if getattr(self, name) not in choices:
                hint = did_you_mean(str(getattr(self, name)), choices, "the choices")
                yield self._bad(name, "there is no such choice", "", hint)
        if not _is_number(self.accuracy) or not FINEST <= self.accuracy <= COARSEST:
            yield self._bad("accuracy", "must be a number within its bounds", f"{FINEST:g} to {COARSEST:g}")
        if self.substeps is not None and not (type(self.substeps) is int and 1 <= self.substeps <= MOST_SUBSTEPS):
            yield self._bad("substeps", "must be an integer within its bounds", f"1 to {MOST_SUBSTEPS}")
        if self.event_tolerance is not None:
            try:
                seconds = float(read_duration(self.event_tolerance))
                if seconds <= 0.0:
                    yield self._bad("event_tolerance", "must be above 0 s", "a time")
                object.__setattr__(self, "event_tolerance", seconds)
            except Refusal as error:
                yield self._bad("event_tolerance", str(error), "a time", error.hint)

    def _bad(self, name: str, message: str, expected: str, hint: str = "") -> Problem:
        got = shown(getattr(self, name))
        return _problem(message, name, got=got, expected=expected, hint=hint)

    def changed(self) -> dict[str, Any]:
        """Settings that differ from the defaults."""
        fields = dataclasses.fields(self)
        return {f.name: getattr(self, f.name) for f in fields if getattr(self, f.name) != f.default}


def read_integration(table: object) -> Integration:
    """The table `[integration]` of a graph file, or an `Integration`; raises `ModelError` with all that is wrong."""
    if isinstance(table, Integration):
        return table
    if not isinstance(table, Mapping):
        hint = "write [integration] and below it accuracy = 1e-9"
        raise _problem("must be a table", got=shown(table), hint=hint).error
    settings = {key: value for key, value in table.items() if key in INTEGRATION_KEYS}
    problems = [
        _problem("unknown key", str(key), got=shown(key), hint=key_hint(str(key), INTEGRATION_KEYS, table))
        for key in table
        if key not in settings
    ]
    try:
        integration = Integration(**settings)
    except ModelError as error:
        raise ModelError([*problems, *error.problems]) from None
    if problems:
        raise ModelError(problems)
    return integration


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
