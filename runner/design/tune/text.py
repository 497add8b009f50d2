"""The result of a tuning as text for people."""

from collections.abc import Iterator

from proofmass.runner.design.tune.tune import Tuned, TunedGoal
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table


def tuned_text(tuned: Tuned) -> str:
    """Return the verdict, the parameters, the goals, and what binds."""
    free = tuned.tuning.free
    rows: list[tuple[str, ...]] = [("parameter", "before", "after", "bounds", "unit")]
    for name, value in tuned.parameters.items():
        bounds = f"{free[name].at_least:.6g} to {free[name].at_most:.6g}"
        unit = tuned.tuning.unit_of(name)
        written = tuned.tuning.written.get(name, name)
        rows.append((written, f"{tuned.before[name]:.6g}", f"{value:.6g}", bounds, unit if unit != "1" else ""))
    goals: list[tuple[str, ...]] = [("goal", "wanted", "before", "after", "")]
    goals += [_row(goal) for goal in tuned.goals]
    lines = [_verdict(tuned), "", *text_table(rows, left=(0, 3, 4)), "", *text_table(goals, left=(0, 1, 4))]
    return "\n".join([*lines, "", *_binding(tuned)]).rstrip()


def _verdict(tuned: Tuned) -> str:
    tried = count(tuned.evaluations, "point") + " tried"
    if tuned.interrupted:
        tried += ", interrupted: the best so far"
    if tuned.without_value:
        return (
            f"no parameters that give every goal a value were found; without: {', '.join(tuned.without_value)}; {tried}"
        )
    hard = [goal for goal in tuned.goals if goal.goal.hard]
    if tuned.met:
        return f"all {count(len(hard), 'hard goal')} met; {tried}" if len(hard) > 1 else f"the goals are met; {tried}"
    missed = [goal.name for goal in hard if not goal.met]
    return f"no parameters within the bounds were found that meet all hard goals; missed: {', '.join(missed)}; {tried}"


def _row(goal: TunedGoal) -> tuple[str, ...]:
    state = "" if goal.met else "missed" if goal.goal.hard else "short of it"
    if goal.binds:
        state = ", ".join(filter(None, (state, "binds")))
    if goal.case:
        state = ", ".join(filter(None, (state, f"worst at {goal.case}")))
    unit = goal.goal.quantity.unit
    after = _number(goal.after) + (f" {unit}" if unit != "1" and goal.after is not None else "")
    return goal.name, goal.goal.wanted, _number(goal.before), after, state


def _number(value: float | None) -> str:
    return "undefined" if value is None else "no limit" if value == float("inf") else f"{value:.6g}"


def _binding(tuned: Tuned) -> Iterator[str]:
    yield from (f"{goal.name} has no value: {goal.why}" for goal in tuned.goals if goal.why)
    for goal in sorted((goal for goal in tuned.goals if goal.binds), key=lambda goal: -goal.price):
        if tuned.met:
            yield f"{goal.name} binds: relaxing its limit by 1 % gains about {100.0 * goal.price:.2g} %"
        elif goal.goal.hard:
            unit = f" {goal.goal.quantity.unit}" if goal.goal.quantity.unit != "1" else ""
            reach = f"; with all other hard goals met it reaches {_number(goal.reachable)}{unit}"
            yield f"{goal.name} is in conflict" + (reach if goal.reachable is not None else "")
    for name, side in tuned.at_bounds.items():
        yield f"{tuned.tuning.written.get(name, name)} is at its {side} bound, which binds"
