"""Choice and construction of the engine that runs a plan."""

from collections.abc import Callable
from functools import partial

from proofmass.runner.plan.memory import Engine, Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.run.engine_table import ENGINES, EngineName
from proofmass.runner.run.estimates import compiling_seconds, interpreting_seconds, is_short

INTERPRETED_PART = 0.5  # part of the compiling time that a run in plain Python may take before compiling pays
_KNOWING_SECONDS = 0.03  # about the time to find out whether a plan has been compiled before
_WRITING_FUNCTION = 0.5e-3  # seconds for each function of a block until a plan is written as text

_spent: dict[int, float] = {}  # seconds like plans have taken in plain Python, by their likeness


def choose(
    planned: Plan, ticks: int, wanted: EngineName, compiled_before: Callable[[], bool] | None = None
) -> EngineName:
    """The engine that is ready sooner: short runs are interpreted, long ones and ones compiled
    before are compiled.

    Whether they were is found out by writing the plan as text, unless `compiled_before` says so.
    Runs of like graphs add up, so that a loop over variants is compiled in the end.
    """
    if wanted != "auto":
        return wanted
    if any(block.wide for block in planned.digital.values()):
        return "python"
    seconds, compiling = interpreting_seconds(planned, ticks), compiling_seconds(planned)
    key = _likeness(planned)
    spent = _spent.get(key, 0.0) + seconds
    longer = seconds > _WRITING_FUNCTION * len(planned.schedule.order)  # than writing it as text, which each plan needs
    if seconds > INTERPRETED_PART * compiling or (longer and spent > compiling):
        return "compiled"
    if longer and spent > _KNOWING_SECONDS:
        # for start-up time: short runs need no compiler
        from proofmass.runner.targets.native import already_compiled

        if (compiled_before or partial(already_compiled, planned, is_short(planned, ticks)))():
            return "compiled"
    _spent[key] = spent
    return "python"


def _likeness(planned: Plan) -> int:
    """A number that plans of one loop share, whatever their parameters."""
    kinds = tuple((name, type(block)) for name, block in planned.blocks.items())
    return hash((kinds, planned.graph.wires, planned.probes, planned.schedule.base_rate))


def make_engine(planned: Plan, name: str, seed: int, run: int, memory: Memory, last: int) -> Engine:
    """An engine that starts from a memory, for a run to the tick `last`."""
    return ENGINES[name].prepare(planned, last - memory.tick)(planned, seed, run, memory)
