"""Measures compiled into the plan: hidden blocks reduce the signals, and their last state gives the measure."""

import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import size_of, unit_of
from proofmass.blocks.declaration.problem import ModelError, Problem, collecting
from proofmass.blocks.declaration.shown_units import displayed, in_print
from proofmass.graphs.checks.schedule import Beat, Schedule
from proofmass.graphs.formulas.tree import plainly
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Endpoint, Wire, split
from proofmass.graphs.model.measures import MEASURES, Measure
from proofmass.graphs.model.rates import Clock, write_rate
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.runner.plan.bindings import Binding, BufferBinding, StateBinding, Tick
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan, PlannedMeasure

FORMULA = "formula"  # stands for the statistic of a measure that follows from others


@dataclass(frozen=True)
class Measured:
    """The value of a measure; NaN where the run ended before it began."""

    value: float
    unit: str
    signal: str
    statistic: str
    shown_in: str = ""  # unit of tables, such as "deg/h", where the graph says one

    def text(self) -> str:
        """Return the value with its unit, to six digits."""
        return displayed(self.value, self.unit, self.shown_in)

    def as_data(self) -> dict[str, str | float | None]:
        """The measure as plain data, for JSON, which knows no NaN; the value is in `unit`, also where tables differ."""
        value = None if math.isnan(self.value) else self.value
        data = {"value": value, "unit": self.unit, "signal": self.signal, "statistic": self.statistic}
        return data | ({"shown_in": self.shown_in} if self.shown_in else {})


def with_measures(graph: FlatGraph, scheduled: Schedule) -> tuple[FlatGraph, Schedule]:
    """Return a flat graph with the hidden blocks of its measures, and the schedule with them.

    They are not in the order of the schedule: nothing reads their outputs before the end of a run.
    """
    blocks, rates, wires = dict(graph.blocks), dict(graph.rates), list(graph.wires)
    divisors, drivers, phases = dict(scheduled.divisors), dict(scheduled.drivers), dict(scheduled.phases)
    offsets, problems = dict(graph.offsets), list[Problem]()
    for own, measure in graph.measures.items():
        name = _reducer(graph, measure)
        source, port = split(measure.signal)
        clock = _clock(graph, scheduled, (source, port))
        unit = unit_of(graph.blocks[source], type(graph.blocks[source]).outputs[port])
        block = None
        with collecting(problems):
            block = _hidden_block(graph, name, measure, unit, clock)
        if block is None:
            continue
        problems += map(graph.placed, _folded(f"{MEASURES}.{own}", measure, block, clock.rate))
        if name not in blocks:
            rates[name], blocks[name] = clock.rate, block
            wires.append(Wire(measure.signal, f"{name}.input"))
            divisors[name] = _stride(graph, scheduled, (source, port))
            if source in phases:
                phases[name], offsets[name] = phases[source], offsets[source]
            drivers[name, "input"] = source, port
    if problems:
        told = dict.fromkeys(problems)  # two measures may share a block
        raise ModelError(sorted(told, key=lambda problem: problem.line))
    measured = replace(graph, blocks=blocks, rates=rates, offsets=offsets, wires=tuple(wires))
    in_order = {name: divisors[name] for name in measured.blocks}
    return measured, replace(scheduled, divisors=in_order, drivers=drivers, phases=phases)


def _hidden_block(graph: FlatGraph, name: str, measure: Measure, unit: str, clock: Clock) -> Block | None:
    """Return the hidden block, if the measure takes one; raises `ModelError` if the rate is too high for it."""
    least = measure.least(clock.rate)
    if measure.until is not None and measure.end(clock) < clock.first(measure.start) + least:
        got, expected = f"until {float(measure.until):g} s", f"{least} or more samples"
        path = (MEASURES, name.removeprefix(f"{MEASURES}."), "until")
        raise graph.placed(Problem(message="too short", got=got, expected=expected, path=path)).error
    try:
        return measure.reducer(unit, clock)
    except ModelError as error:
        first = error.problems[0]
        own = first.path[-1] if first.path else first.key.rpartition(".")[2]
        times = STATISTICS[measure.statistic].times
        key = own if own in dict(measure.options) else next(iter(times), "from")
        raise graph.placed(replace(first, key=f"{name}.{key}", path=(*name.split("."), key))).error from None


def _folded(name: str, measure: Measure, block: Block, rate: Fraction) -> Iterator[Problem]:
    """Yield the frequencies of a measure that its signal does not have."""
    statistic = STATISTICS[measure.statistic]
    for key in (key for key, option in statistic.options.items() if option.spectral):
        value: float = getattr(block, key)
        if not statistic.within(2 * Fraction(value), rate):
            is_below = statistic.within is operator.lt
            yield Problem(
                message=f"is {'not below' if is_below else 'above'} half the rate of the signal",
                key=f"{name}.{key}",
                got=f"{in_print(value, 'Hz', 6)}, of {measure.signal} at {write_rate(rate)}",
                expected=f"{'below' if is_below else 'at most'} {in_print(float(rate / 2), 'Hz', 6)}",
                hint="a signal has nothing there: raise its rate, or lower the frequency",
                path=(*name.split("."), key),
            )


def planned_measures(graph: FlatGraph, scheduled: Schedule) -> tuple[PlannedMeasure, ...]:
    """Return the output to read each measure of a flat graph with hidden blocks from."""
    measures = []
    for name, measure in graph.measures.items():
        statistic, node = STATISTICS[measure.statistic], split(measure.signal)
        clock = _clock(graph, scheduled, node)
        first = clock.first(measure.start) + measure.least(clock.rate) - 1
        at = Beat(_stride(graph, scheduled, node), scheduled.phases.get(node[0], 0)).at(first)
        read = (_reducer(graph, measure), measure.output) if measure.block else node
        block = graph.blocks[node[0]]
        unit = statistic.unit_for(unit_of(block, type(block).outputs[node[1]]))
        reduced = measure.block is not None
        measures.append(PlannedMeasure(name, measure.signal, measure.statistic, unit, read, reduced, at, measure.unit))
    return tuple(measures)


def measured(plan: Plan, memory: Memory) -> dict[str, Measured]:
    """Measures of a run that ended with this memory; those given by formulas come last."""
    measures = {
        m.name: Measured(value_of(plan, m, memory), m.unit, m.signal, m.statistic, m.shown_in) for m in plan.measures
    }
    values = {name: measure.value for name, measure in measures.items()}
    for derived, value in zip(plan.derived, derived_values(plan, values), strict=True):
        measures[derived.name] = Measured(value, derived.unit, derived.formula.text, FORMULA, derived.shown_in)
    return measures


def derived_values(
    plan: Plan, measures: Mapping[str, Any], apply: Callable[[str, list[Any]], Any] = plainly
) -> tuple[Any, ...]:
    """Values of the measures that follow from others; `apply` computes with numbers or arrays."""
    known = dict(measures)
    for derived in plan.derived:
        known[derived.name] = derived.value(known, apply)
    return tuple(known[derived.name] for derived in plan.derived)


def planned_derived(plan: Plan) -> tuple[PlannedMeasure, ...]:
    """Describe measures given by formulas as signals have, for studies; the loop reads neither."""
    return tuple(
        PlannedMeasure(d.name, d.formula.text, FORMULA, d.unit, ("", ""), False, 0, d.shown_in) for d in plan.derived
    )


def value_of(plan: Plan, measure: PlannedMeasure, memory: Memory) -> float:
    """Value of one measure: its block's output for the last state, or the wire's last value."""
    name, port = measure.node
    if memory.tick <= measure.first:
        return math.nan
    if not measure.reduced:
        return float(memory.wires[name, port])
    defined = STATISTICS[measure.statistic].defined
    return (
        float(_output(plan, (name, port), memory))
        if not defined or _output(plan, (name, defined), memory)
        else math.nan
    )


def _output(plan: Plan, node: Endpoint, memory: Memory) -> Any:
    """Value of an output of a hidden block after the last tick."""
    name, port = node
    given = (_at_the_end(memory, binding) for binding in plan.bindings(name, port))
    return type(plan.blocks[name]).output_functions[port].function(plan.constants[name], *given)


def _at_the_end(memory: Memory, binding: Binding) -> Any:
    """Value of an argument of a hidden block's output after the last tick."""
    match binding:
        case StateBinding(name):
            return memory.states[name]
        case BufferBinding(node):
            return memory.buffers[node]
        case Tick(divisor, phase):
            return Beat(divisor, phase).before(memory.tick)
        case _:
            raise ValueError(f"a measure cannot be read from {binding}")


def refuse_late(plan: Plan, ticks: int) -> None:
    """Raise `ModelError` where a measure would begin after the end of the run."""
    problems = [
        Problem(
            message="the run ends before the measure begins",
            got=f"a run of {ticks} ticks of {write_rate(plan.schedule.base_rate)}",
            expected=f"more than {m.first} ticks",
            hint="run longer, or measure from an earlier time",
            path=("measures", m.name, "from"),
        )
        for m in plan.measures
        if m.first >= ticks
    ]
    if problems:
        raise ModelError([plan.graph.placed(problem) for problem in problems])


def _reducer(graph: FlatGraph, measure: Measure) -> str:
    """Name of the hidden block; measures that need the same one share it."""
    kind = _kind(measure)
    return next(f"{MEASURES}.{name}" for name, other in graph.measures.items() if _kind(other) == kind)


def _kind(measure: Measure) -> tuple[object, ...]:
    return measure.block, measure.signal, measure.start, measure.until, measure.options


def _clock(graph: FlatGraph, scheduled: Schedule, node: Endpoint) -> Clock:
    rate = scheduled.base_rate / _stride(graph, scheduled, node)
    return Clock(rate, graph.offsets.get(node[0], Fraction(0)))


def _stride(graph: FlatGraph, scheduled: Schedule, node: Endpoint) -> int:
    """Base ticks from one value of an output to its next."""
    block = graph.blocks[node[0]]
    return scheduled.divisors[node[0]] * size_of(block, type(block).outputs[node[1]].every)
