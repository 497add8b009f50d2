"""Formulas where a file has them: of parameters and rates, and of measures that follow from others."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from proofmass.blocks.declaration.problem import Problem, Refusal, did_you_mean, shown
from proofmass.graphs.formulas.formula import Formula, is_formula
from proofmass.graphs.model.keys import FORMULA, MEASURE_FORMULA_KEYS
from proofmass.graphs.model.limits import NAME
from proofmass.graphs.model.measures import read_display_unit


def read_formulas(table: object) -> tuple[dict[str, Formula], list[Problem]]:
    """Return the formulas of a table by what they set, and the problems of those that are none."""
    hint = 'write formulas = { "x_axis.mass" = "= mass" }'
    if not isinstance(table, Mapping):
        return {}, [Problem(message="must be a table", key="formulas", got=shown(table), hint=hint, path=("formulas",))]
    formulas: dict[str, Formula] = {}
    problems: list[Problem] = []
    for target, text in table.items():
        try:
            if not isinstance(text, Formula) and not is_formula(text):
                raise Refusal("must be a text that begins with =", hint)
            formulas[str(target)] = text if isinstance(text, Formula) else Formula(text)
        except Refusal as error:
            problems.append(error.problem(f"formulas.{target}", text, path=("formulas", str(target))))
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
                    raise Refusal("unknown key", did_you_mean(str(key), MEASURE_FORMULA_KEYS, "the keys"))
            formula = Formula(table[key := FORMULA])
            key = "unit"
            formulas[name] = replace(formula, unit=read_display_unit(table.get("unit", "")))
        except Refusal as error:
            path = ("measures", name) if entry is not table else ("measures", name, str(key))
            problems.append(error.problem(".".join(path), table[key], path=path))
    return of_signals, formulas, problems
