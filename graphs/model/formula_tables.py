"""Formulas of a file: of parameters and rates, and of measures that follow from others."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
from proofmass.graphs.formulas.formula import Formula, is_formula
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.keys import FORMULA, MEASURE_FORMULA_KEYS
from proofmass.graphs.model.limits import NAME
from proofmass.graphs.model.measures import MEASURES, Measure, read_display_unit, read_measures
from proofmass.graphs.model.statistics import OPTIONS
from proofmass.graphs.model.targets import OF_MEASURES, entry_of
from proofmass.graphs.model.values import NamedValue

BY_FORMULAS = OPTIONS.keys() | {"from", "until"}  # keys of measures that named values give


def read_formulas(table: object, at_blocks: bool = False) -> tuple[dict[str, Formula], list[Problem]]:
    """Return the formulas of a table by what they set, and the problems of the others.

    They stand in the table `formulas`, or as rates and offsets at the blocks and at the top of the
    graph.
    """
    hint = 'write formulas = { "x_axis.mass" = "= mass" }'
    if not isinstance(table, Mapping):
        return {}, [Problem(message="must be a table", got=shown(table), hint=hint, path=("formulas",))]
    formulas: dict[str, Formula] = {}
    problems: list[Problem] = []
    for target, text in table.items():
        try:
            if not isinstance(text, Formula) and not is_formula(text):
                raise Refusal("must be a text that begins with =", hint)
            formulas[str(target)] = text if isinstance(text, Formula) else Formula(text)
        except Refusal as error:
            name, key = split(str(target))
            above = ("blocks", name) if name else ()
            path = (*above, key) if at_blocks else ("formulas", str(target))
            problems.append(error.problem(".".join(path), text, path=path))
    return formulas, problems


def split_measures(measures: object, derived: Mapping[str, Formula]) -> tuple[Any, dict[str, Formula], list[Problem]]:
    """Split measures into those of signals and those that are formulas of others."""
    formulas, problems = dict(derived), list[Problem]()
    if not isinstance(measures, Mapping):
        return measures, formulas, problems
    of_signals = dict[Any, Any]()
    for name, entry in measures.items():
        table = {FORMULA: entry} if is_formula(entry) else entry
        if not (isinstance(name, str) and NAME.fullmatch(name) and isinstance(table, Mapping) and FORMULA in table):
            of_signals[name] = entry
            continue
        key = FORMULA
        try:
            if not is_formula(table[FORMULA]):
                raise Refusal("must be a text that begins with =", 'write formula = "= (plus - minus) / 2"')
            for key in table:
                if key not in MEASURE_FORMULA_KEYS:
                    raise Refusal("unknown key", key_hint(str(key), MEASURE_FORMULA_KEYS, table))
            formula = Formula(table[key := FORMULA])
            key = "unit"
            formulas[name] = replace(formula, unit=read_display_unit(table.get("unit", "")))
        except Refusal as error:
            path = ("measures", name) if entry is not table else ("measures", name, str(key))
            problems.append(error.problem(".".join(path), table[key], path=path))
    return of_signals, formulas, problems


def read_measured(
    measures: object, values: Mapping[str, NamedValue], declared: object
) -> tuple[dict[str, Measure], dict[str, Formula], list[Problem]]:
    """Return the measures of a table, the formulas of their entries by their targets, and the problems of both.

    A formula that needs a value which could not be read adds no problem.
    """
    table, formulas, problems = _with_numbers(measures, values, declared)
    try:
        return read_measures(table), formulas, problems
    except ModelError as error:
        return {}, formulas, problems + [as_written(problem, formulas) for problem in error.problems]


def _with_numbers(
    measures: object, values: Mapping[str, NamedValue], declared: object
) -> tuple[object, dict[str, Formula], list[Problem]]:
    """Return a table of measures with numbers in place of formulas, without wrong ones."""
    formulas, problems = dict[str, Formula](), list[Problem]()
    if not isinstance(measures, Mapping):
        return measures, formulas, problems
    broken = set(declared if isinstance(declared, Mapping) else ()) - values.keys()
    whole = dict[Any, Any]()
    for name, entry in measures.items():
        texts = {key: text for key, text in entry.items() if is_formula(text)} if isinstance(entry, Mapping) else {}
        numbers = dict[str, Any]()
        for key, text in texts.items():
            if key not in BY_FORMULAS:
                continue  # the text is refused as such
            try:
                formula = Formula(text)
                if formula.names.isdisjoint(broken):
                    numbers[key] = entry_of(formula, values, key)
                    formulas[f"{OF_MEASURES}{name}.{key}"] = formula
            except Refusal as error:
                path = (MEASURES, str(name), str(key))
                problems.append(error.problem(".".join(path), text, path=path))
        if all(key in numbers or key not in BY_FORMULAS for key in texts):
            whole[name] = {**entry, **numbers} if numbers else entry
    return whole, formulas, problems


def bad_targets(formulas: Mapping[str, Formula], measures: Mapping[str, Measure]) -> Iterator[Problem]:
    """Yield the formulas that set something of measures that are not there."""
    for target, formula in formulas.items():
        name, _, key = target.removeprefix(OF_MEASURES).rpartition(".")
        if target.startswith(OF_MEASURES) and (name not in measures or key not in BY_FORMULAS):
            known, what = (BY_FORMULAS, "the keys") if name in measures else (measures, "the measures")
            hint = did_you_mean(key if name in measures else name, known, what)
            error = Refusal("there is no such entry of a measure", hint)
            yield error.problem(f"formulas.{target}", formula.text, path=("formulas", target))


def as_written(problem: Problem, formulas: Mapping[str, Formula]) -> Problem:
    """Return a problem of a measure with the formula in place of what it gives."""
    formula = formulas.get(problem.key)
    return replace(problem, got=shown(formula.text)) if formula else problem
