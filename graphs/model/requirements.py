"""Requirements of a graph: id, text, a quantity of its runs, loops or study, and limits."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.problem import Problem, problems_of_table, shown
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.keys import REQUIREMENT_KEYS
from proofmass.graphs.model.limits import TEXT_LENGTH

TABLE = "requirements"
_problem = problems_of_table(TABLE)
YIELD = "yield"
SPREAD = "spread"  # tolerances that are the spread of the study
_ID = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9_.-]{0,62}[A-Za-z0-9])?")
_EXPECTED_ID = "at most 64 letters, digits, dots, hyphens and underscores"
_EXAMPLE = 'write bias = { quantity = "bias", at_most = "1 mV", text = "The bias after start-up." }'


@dataclass(frozen=True)
class Requirement:
    """Limits of a quantity, as written: numbers in its unit, or texts with their own."""

    quantity: str | Mapping[str, Any]  # a measure, "main.phase_margin", "yield.bias", or a table as goals have
    text: str = ""
    at_least: float | str | None = None
    at_most: float | str | None = None
    at: str = ""  # operating point of a linearised quantity
    tolerances: str | Mapping[str, Any] = ""  # the limits hold for the worst case within these
    proved: bool = False  # they are proved to hold for all sensors within them

    def as_written(self) -> dict[str, Any]:
        """Return the entries that are not empty, as in a graph file."""
        return {key: value for key, value in vars(self).items() if value not in (None, "") and value is not False}


def read_requirements(entries: object) -> tuple[dict[str, Requirement], list[Problem]]:
    """Return the requirements of a table by their ids, and its problems; quantities and units are checked later."""
    if not isinstance(entries, Mapping):
        hint = f"write [requirements] and below it requirements; {_EXAMPLE}"
        return {}, [_problem("must be a table", got=shown(entries), hint=hint)]
    read: dict[str, Requirement] = {}
    problems: list[Problem] = []
    for name, entry in entries.items():
        table = entry.as_written() if isinstance(entry, Requirement) else entry
        wrong = list(_problems(name, table))
        problems += wrong
        if not wrong:
            read[name] = Requirement(**table)
    return dict(sorted(read.items())), problems


def _problems(name: object, table: Any) -> Iterator[Problem]:
    if not isinstance(name, str) or not _ID.fullmatch(name):
        yield _problem("not an id", str(name), got=shown(name), expected=_EXPECTED_ID)
        return
    if not isinstance(table, Mapping):
        yield _problem("must be a table", name, got=shown(table), hint=_EXAMPLE)
        return
    for key, value in table.items():
        if key not in REQUIREMENT_KEYS:
            hint = key_hint(str(key), REQUIREMENT_KEYS, table)
            yield _problem("unknown key", name, str(key), got=shown(key), hint=hint)
        elif key in ("at_least", "at_most"):
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                yield _problem("must be a number, or a text with a unit", name, key, got=shown(value))
        elif key == "quantity" and isinstance(value, Mapping):
            pass  # read with the graph
        elif key == "tolerances":
            if not (isinstance(value, Mapping) and value) and value != SPREAD:
                hint = f'write {{ "torquer.gain" = "5 %" }}, or "{SPREAD}" for that of [study]'
                yield _problem("must be a table of tolerances", name, key, got=shown(value), hint=hint)
        elif key == "proved":
            if not isinstance(value, bool):
                yield _problem("must be true or false", name, key, got=shown(value))
        elif not isinstance(value, str) or len(value) > 10 * TEXT_LENGTH:
            yield _problem("must be a text", name, key, got=shown(value))
    if "quantity" not in table:
        yield _problem("has no quantity", name, expected=REQUIREMENT_KEYS["quantity"], hint=_EXAMPLE)
    if not {"at_least", "at_most"} & table.keys():
        yield _problem("asks nothing", name, expected="at_least or at_most, or both", hint=_EXAMPLE)
