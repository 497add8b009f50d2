"""Control loops of a graph: the output at which each is opened, and its required margins."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from proofmass.blocks.declaration.problem import Problem, Refusal, collecting, problems_of_table, shown
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.keys import LOOP_KEYS
from proofmass.graphs.model.rates import read_duration

REQUIREMENTS = {"gain_margin": "dB", "phase_margin": "deg", "delay_margin": "s", "sensitivity_peak": "dB"}
PEAKS = frozenset({"sensitivity_peak"})  # of these at most so much is required
VERDICTS = {"unstable": 0.0, "marginal": 0.5, "stable": 1.0}  # numbers the measure `stable` has
MARGIN_MEASURES = {**REQUIREMENTS, "stable": "1"}  # measures of each loop, and their units
AUTO = "auto"  # an operating point: the first of the others at which there is an answer
SETTLED = "settled"  # the loops have come to rest
PERIODIC = "periodic"  # an orbit that repeats after a period
_problem = problems_of_table("loops")
_DECIBELS = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*dB\s*")


@dataclass(frozen=True, kw_only=True)
class Loop:
    """A loop and its requirements: at least these margins, at most this sensitivity peak; None requires nothing."""

    open_at: str  # the output whose wires are cut
    gain_margin: float | None = None  # dB, upwards and downwards
    phase_margin: float | None = None  # deg
    delay_margin: float | None = None  # s
    sensitivity_peak: float | None = None  # dB

    @property
    def requirements(self) -> dict[str, float]:
        """Requirements by name, in the units of `REQUIREMENTS`."""
        return {name: value for name, value in asdict(self).items() if name in REQUIREMENTS and value is not None}


def read_moment(at: object) -> str:
    """Return an operating point as a text, "" for none; raises `Refusal` unless it is a time, "auto" or "settled"."""
    if at not in ("", AUTO, SETTLED):
        try:
            read_duration(at)
        except Refusal as error:
            raise Refusal(str(error), f'write a time, as "20 ms", "{AUTO}" or "{SETTLED}"', got=shown(at)) from None
    return at if isinstance(at, str) else f"{at} s"


def read_loops(entries: object, is_path: Callable[[str], bool]) -> tuple[dict[str, Loop], list[Problem]]:
    """Return loops by name, from values or tables, and their problems."""
    hint = 'write [loops.main] and below it open_at = "block.output"'
    if not isinstance(entries, Mapping):
        return {}, [_problem("must be a table", got=shown(entries), hint=hint)]
    loops: dict[str, Loop] = {}
    problems: list[Problem] = []
    for name, value in sorted(entries.items(), key=lambda item: str(item[0])):
        table = asdict(value) if isinstance(value, Loop) else value
        if not isinstance(name, str) or not is_path(name):
            expected = "lower-case letters and digits, words joined by single underscores"
            problems.append(_problem("not a name", str(name), key="loops", got=shown(name), expected=expected))
        elif not isinstance(table, Mapping):
            at = value if isinstance(value, str) and "." in value else "block.output"
            as_table = f'write {name} = {{ open_at = "{at}" }}'
            problems.append(_problem("must be a table", name, got=shown(value), hint=as_table))
        else:
            values, wrong = _read_loop(name, {key: entry for key, entry in table.items() if entry is not None})
            problems += wrong
            if not wrong:
                loops[name] = Loop(**values)
    return loops, problems


def _read_loop(name: str, table: Mapping[Any, object]) -> tuple[dict[str, Any], list[Problem]]:
    problems = [
        _problem("unknown key", name, str(key), got=shown(key), hint=key_hint(str(key), LOOP_KEYS, table))
        for key in table
        if key not in LOOP_KEYS
    ]
    if "open_at" not in table:
        hint = 'add open_at = "block.output", an output that all of the loop goes through'
        problems.append(_problem("has no open_at", name, hint=hint))
    values: dict[str, Any] = {}
    for key, entry in table.items():
        with collecting(problems, entry, ("loops", name, key)):
            if key == "open_at":
                values[key] = _signal(entry)
            elif key in REQUIREMENTS:
                values[key] = read_requirement(entry, REQUIREMENTS[key])
    return values, problems


def _signal(value: object) -> str:
    if not isinstance(value, str) or "." not in value:
        raise Refusal("not an output", 'write "block.output"')
    return value


def read_requirement(value: object, unit: str) -> float:
    """Return a number in the unit, from number or text, but no decibels. Raises `Refusal`."""
    example = {"dB": 'write it as "6 dB"', "deg": 'write it as "30 deg"', "s": 'write it as "100 us"'}[unit]
    if isinstance(value, str) and unit == "dB":
        found = _DECIBELS.fullmatch(value)
        if found is None:
            raise Refusal("not a ratio in decibels", example)
        number = float(found[1])
    elif isinstance(value, str):
        number = convert(value, unit)
    elif isinstance(value, bool) or not isinstance(value, int | float):
        raise Refusal("must be a number", example)
    else:
        number = float(value)
    if not math.isfinite(number) or number < 0.0:
        raise Refusal("must be finite and not negative", example)
    return number
