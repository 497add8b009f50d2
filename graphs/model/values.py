"""The table `[values]` of a graph: quantities and formulas by name, resolved, with all problems."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from graphlib import CycleError, TopologicalSorter

from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import Problem, Refusal, problems_of_table, shown
from proofmass.blocks.declaration.unit_expressions import is_unit, unit
from proofmass.blocks.declaration.units import convert_exactly, split_quantity
from proofmass.graphs.formulas.formula import Formula, in_unit, is_formula
from proofmass.graphs.formulas.operations import CONSTANTS, FUNCTIONS, Dimension, coherent_unit
from proofmass.graphs.formulas.tree import dimension_of
from proofmass.graphs.formulas.turning import Turning, counted_unit, turning_of, turning_of_quantity
from proofmass.graphs.model.limits import EXPECTED_NAME, NAME

MOST_VALUES = 1000
EXAMPLE = 'write mass = "50 ug", a number, or a formula of other values, "= 2 * pi * f0"'
TABLE = "values"
_problem = problems_of_table(TABLE)


@dataclass(frozen=True)
class NamedValue:
    """A named value: as written, and as a number.

    `number` is in coherent SI units; a value written in other units is rounded once.
    """

    written: str  # "50 ug", "0.5", "= 2 * pi * f0"
    number: float
    dimension: Dimension
    turning: Turning | None  # whether it counts angle or turns; None of a formula that may convert

    @property
    def coherent_unit(self) -> str:
        """The coherent unit of its number: Hz or rad/s where it is written so, or follows from what is."""
        return counted_unit(self.turning, self.dimension)

    @property
    def formula(self) -> Formula | None:
        """The formula that gives it, or None for a quantity."""
        return Formula(self.written) if is_formula(self.written) else None

    @property
    def unit(self) -> str:
        """The unit that it was written in, or a coherent one for a formula."""
        return self.coherent_unit if is_formula(self.written) else split_quantity(self.written)[1] or "1"

    def text(self) -> str:
        """Return number and unit, to six digits."""
        own = self.unit
        return f"{in_unit(self.number, own):.6g}" + (f" {own}" if own != "1" else "")


def with_number(value: NamedValue, number: float) -> NamedValue:
    """Return a value with another number, in coherent SI units."""
    own = value.coherent_unit
    return replace(value, written=repr(float(number)) + (f" {own}" if own != "1" else ""), number=float(number))


def read_values(table: object, taken: Mapping[str, str]) -> tuple[dict[str, NamedValue], list[Problem]]:
    """Return the values of a table in the order of their names, and its problems; `taken` names are refused."""
    if not isinstance(table, Mapping):
        hint = f"write [values] and below it values; {EXAMPLE}"
        return {}, [_problem("must be a table", got=shown(table), hint=hint)]
    if len(table) > MOST_VALUES:
        return {}, [_problem("too many", got=str(len(table)), expected=f"at most {MOST_VALUES}")]
    problems = [problem for name in table for problem in bad_name(name, taken)]
    read: dict[str, NamedValue] = {}
    formulas: dict[str, Formula] = {}
    for name, entry in table.items():
        try:
            if isinstance(entry, NamedValue):
                entry = entry.written
            if is_formula(entry):
                formulas[str(name)] = Formula(entry)
            else:
                read[str(name)] = read_quantity(entry)
        except Refusal as error:
            problems.append(_problem(str(error), str(name), got=shown(entry), hint=error.hint))
    problems += _resolve(formulas, read, {str(name) for name in table} - read.keys() - formulas.keys())
    return dict(sorted(read.items())), problems


def bad_name(name: object, taken: Mapping[str, str]) -> Iterator[Problem]:
    """Yield why a value may not have a name."""
    if not isinstance(name, str) or not NAME.fullmatch(name):
        yield _problem("not a name", str(name), got=shown(name), expected=EXPECTED_NAME)
        return
    why = taken.get(name, "")
    if name in FUNCTIONS or name in CONSTANTS:
        why = "a function" if name in FUNCTIONS else "a constant"
    elif not why and is_unit(name):
        why = "a unit"
    if why:
        hint = "choose another: words say more than letters, as in mass or drive_frequency"
        yield _problem(f"the name is taken: {name} is {why}", name, hint=hint)


def read_quantity(entry: object) -> NamedValue:
    """Return the value of a number, or a text with a number and a unit; raises `Refusal`."""
    entry = plain(entry)
    if isinstance(entry, bool) or not isinstance(entry, int | float | str):
        raise Refusal("must be a number, or a text with a unit", EXAMPLE)
    if isinstance(entry, float) and not math.isfinite(entry):
        raise Refusal("must be finite")
    text = entry if isinstance(entry, str) else repr(entry)
    try:
        name = split_quantity(text)[1]
        parsed = unit(name or "1")
        number = float(convert_exactly(text, coherent_unit(parsed.exponents)))
    except OverflowError:
        raise Refusal("is too large for a number") from None
    return NamedValue(
        text.strip(), number, parsed.exponents, turning_of_quantity(number, parsed.exponents, name or "1")
    )


def _resolve(formulas: Mapping[str, Formula], read: dict[str, NamedValue], unknown: set[str]) -> Iterator[Problem]:
    """Add the values of formulas to those read, each after those that it needs; yield the problems.

    A formula that needs a value that could not be read has no value either, and no problem of its
    own.
    """
    circles, order = circles_and_order(formulas)
    for chain in circles:
        message = "the value depends on itself: " + " -> ".join(chain)
        got, hint = shown(formulas[chain[0]].text), "write one of them as a number"
        yield _problem(message, chain[0], got=got, hint=hint)
        unknown |= set(chain)
    for name in order:
        if formulas[name].names & unknown:
            unknown.add(name)  # the problem is reported at the formula that names it
            continue
        try:
            read[name] = resolved(formulas[name], read)
        except Refusal as error:
            unknown.add(name)
            yield _problem(str(error), name, got=shown(formulas[name].text), hint=error.hint)


def circles_and_order(formulas: Mapping[str, Formula]) -> tuple[list[list[str]], list[str]]:
    """Return circles of formulas, each with its first at the end, and the others in order."""
    needs = {name: set(formula.names & formulas.keys()) for name, formula in formulas.items()}
    circles: list[list[str]] = []
    while True:
        try:
            return circles, list(TopologicalSorter(needs).static_order())
        except CycleError as error:
            circles.append(error.args[1][::-1])
            circle = set(circles[-1])
            needs = {name: others - circle for name, others in needs.items() if name not in circle}


def resolved(formula: Formula, values: Mapping[str, NamedValue]) -> NamedValue:
    """Return the value that a formula gives; raises `Refusal`."""
    dimension = dimension_of(formula.tree, {name: value.dimension for name, value in values.items()})
    turning = turning_of(formula.tree, lambda name: values[name].turning)
    number = formula.number({name: value.number for name, value in values.items()})
    return NamedValue(formula.text, number, dimension, turning)
