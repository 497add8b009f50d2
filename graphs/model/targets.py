"""Targets of formulas: parameters, values of subgraphs, rates, duration; and their numbers."""

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Refusal, did_you_mean
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import convert_exactly, is_quantity, turned
from proofmass.graphs.formulas.formula import Formula
from proofmass.graphs.formulas.operations import NUMBER
from proofmass.graphs.formulas.tree import dimension_of
from proofmass.graphs.formulas.turning import ANGLE, STILL, TURNS, turning_of
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.measures import MEASURE_TIMES, MEASURES
from proofmass.graphs.model.rates import simplest
from proofmass.graphs.model.values import NamedValue, resolved

RATE, DURATION, CLOCK_OFFSET = "rate", "duration", "clock_offset"
OF_MEASURES = f"{MEASURES}."  # the targets of formulas begin so, as "measures.settled.from"
LARGEST_WHOLE = 2**53  # beyond which floats are not all integers


def is_of_measure(graph: Graph, target: str) -> bool:
    """Return whether a formula sets an entry of a measure, and nothing of a block or subgraph of that name."""
    return target.startswith(OF_MEASURES) and MEASURES not in {*graph.blocks, *graph.subgraphs}


class Target(NamedTuple):
    """Target of a formula: its unit, and whether it takes whole numbers only, or is a rate."""

    unit: str
    whole: bool = False
    rate: bool = False  # of a block: a frequency, exactly, or a period


def number_of(formula: Formula, values: Mapping[str, NamedValue], target: Target) -> float | int | Fraction:
    """Return the number of a formula in the unit of its target; raises `Refusal`."""
    if target.rate:
        return rate_of(formula, values)
    dimensions = {name: value.dimension for name, value in values.items()}
    number = formula.quantity({name: value.number for name, value in values.items()}, dimensions, target.unit)
    _refuse_turns(formula, values, target.unit)
    if not target.whole:
        return number
    if not number.is_integer() or abs(number) > LARGEST_WHOLE:
        raise Refusal(f"must be an integer, not {number!r}")
    return int(number)


def _refuse_turns(formula: Formula, values: Mapping[str, NamedValue], target: str) -> None:
    """Refuse angle where turns are wanted, or the other way round, unless the formula may convert."""
    counted = turning_of(formula.tree, lambda name: values[name].turning)
    told = turned({ANGLE: "rad/s", TURNS: "Hz"}.get(counted or STILL, "1"), target)
    if not told:
        return
    body = formula.text.strip().removeprefix("=").strip()
    if is_quantity(body):
        convert_exactly(body, target)  # refuses, and says which quantity was meant
    name = body if body in values else f"({body})"
    cure = f"{name} / (2 * pi)" if told.startswith("angle") else f"2 * pi * {name}"
    raise Refusal(f"the formula is {told}", f'write "= {cure}"')


def rate_of(formula: Formula, values: Mapping[str, NamedValue]) -> Fraction:
    """Return the rate in hertz a formula of a frequency or a period gives; raises `Refusal`."""
    dimension = dimension_of(formula.tree, {name: value.dimension for name, value in values.items()})
    if dimension == unit("s").exponents:
        return 1 / _exactly(formula, values, "s")
    return _exactly(formula, values, "Hz")


def offset_of(formula: Formula, values: Mapping[str, NamedValue]) -> Fraction:
    """Return the clock offset in seconds that a formula gives; raises `Refusal`."""
    number = number_of(formula, values, Target("s"))
    if not 0.0 <= number < math.inf:
        raise Refusal(f"must be at least zero, not {float(number):g} s")
    return simplest(float(number)) if number else Fraction(0)


def entry_of(formula: Formula, values: Mapping[str, NamedValue], key: str) -> Any:
    """Return what a formula stands for at a key of a measure: a time, a number, or a text with its unit.

    Raises `Refusal`.
    """
    if key in MEASURE_TIMES:
        return offset_of(formula, values)
    value = resolved(formula, values)
    if value.dimension == NUMBER:
        return value.number
    hertz = value.dimension == unit("Hz").exponents
    if hertz:
        _refuse_turns(formula, values, "Hz")
    return f"{value.number!r} {'Hz' if hertz else value.coherent_unit}"


def _exactly(formula: Formula, values: Mapping[str, NamedValue], unit: str) -> Fraction:
    """Return the value of a formula without the rounding of its arithmetic."""
    number = number_of(formula, values, Target(unit))
    if not 0.0 < number < math.inf:
        raise Refusal(f"must be above zero, not {float(number):g} {unit}")
    return simplest(float(number))


def target_at(graph: Graph, signal: str) -> Target:
    """Return what a path names, as the target of a formula; raises `Refusal`."""
    name, entry = split(signal)
    if entry == CLOCK_OFFSET and (name in graph.blocks or name in graph.subgraphs):
        return Target("s")
    if name in graph.blocks:
        if entry == RATE:
            return Target("Hz", rate=True)
        return parameter_target(graph.blocks[name], entry)
    if signal in graph.values:
        return Target(graph.values[signal].coherent_unit)
    head, _, tail = signal.partition(".")
    if head not in graph.subgraphs or not tail:
        names = [*graph.blocks, *graph.subgraphs]
        raise Refusal(f"there is no block {head if tail else signal}", did_you_mean(head, names, "the blocks"))
    part = graph.subgraphs[head]
    return target_at(part, part.exports.get(tail, tail))


def parameter_target(block: Block, entry: str) -> Target:
    """Return a parameter, or an entry of a list as `taps[3]`, as the target of a formula; raises `Refusal`."""
    name, bracket, index = entry.partition("[")
    kind = type(block)
    if name not in kind.parameters:
        hint = did_you_mean(name, kind.parameters, f"the parameters of {kind.__name__}")
        raise Refusal(f"{kind.__name__} has no parameter {name}", hint)
    parameter = kind.parameters[name]
    if bracket and parameter.kind is tuple:
        entries = len(getattr(block, name))
        if not index.removesuffix("]").isdecimal() or int(index[:-1]) >= entries:
            raise Refusal(f"{name} has no entry {index.removesuffix(']')}", f"it has {entries}, the first being 0")
        return Target(unit_of(block, parameter))
    return of_parameter(parameter, unit_of(block, parameter))


def of_parameter(parameter: Parameter, unit: str) -> Target:
    """Return a parameter that is one number as the target of a formula; raises `Refusal`."""
    if parameter.kind not in (float, int):
        what = {bool: "true or false", str: "a text", tuple: "a list"}.get(parameter.kind, "no single number")
        hint = 'give its entries formulas, ["= a", "= b"]' if parameter.kind is tuple else "write it out"
        raise Refusal(f"is {what}: a formula gives one number", hint)
    return Target(unit, parameter.kind is int)
