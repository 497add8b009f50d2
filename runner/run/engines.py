"""Choice and construction of the engine that runs a plan."""

from collections.abc import Callable
from functools import partial

from proofmass.runner.continuous.exact_hold import MANY_COLUMNS
from proofmass.runner.plan.memory import Engine, Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.run.engine_table import ENGINES, EngineName

INTERPRETED_PART = 0.5  # part of the compiling time that a run in plain Python may take before compiling pays
COMPILING_SECONDS = 0.1  # about that of compiling, which like runs may take in Python
_KNOWING_SECONDS = 0.03  # about the time to find out whether a plan has been compiled before
_COMPILING_FUNCTION = 2.5e-3  # seconds more for each function of a block: 7 s for the 31 graphs of the library
_WRITING_FUNCTION = 0.5e-3  # seconds for each function of a block until a plan is written as text
_INTERPRETED_STEP = 1.5e-6  # seconds per function and tick in plain Python, measured
_INTERPRETED_ENTRY = 0.15e-6  # the same per entry of a buffer
_INTERPRETED_PRODUCT = 0.1e-6  # the same per product of a matrix
_ARRAY_PRODUCT = 2e-9  # the same where NumPy multiplies large matrices
_PRODUCTS = 30.0  # products of matrices in an exponential, about
_INTERPRETED_INTEGER = 0.4e-6  # for an integer operation, which runs in `FixedValue`

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

        if (compiled_before or partial(already_compiled, planned))():
            return "compiled"
    _spent[key] = spent
    return "python"


def interpreting_seconds(planned: Plan, ticks: int) -> float:
    """Estimate the seconds that a run takes in plain Python."""
    entries = sum(len(held) for node, held in planned.buffers.items() if node not in planned.recorded)
    integers = sum(len(s.code.live) for block in planned.digital.values() for s in block.steps.values())
    tick = len(planned.schedule.order) * _INTERPRETED_STEP + entries * _INTERPRETED_ENTRY
    tick += integers * _INTERPRETED_INTEGER
    return ticks * (tick + sum(map(_interpreted, planned.solvers))) + sum(map(_assembled, planned.solvers))


def compiling_seconds(planned: Plan) -> float:
    """Estimate the seconds that compiling a plan takes."""
    return COMPILING_SECONDS + _COMPILING_FUNCTION * len(planned.schedule.order)


def _interpreted(solver: Solver) -> float:
    """Seconds that a group takes for a tick in plain Python, about."""
    n, m = len(solver.group.states), len(solver.group.inputs)
    if solver.exact:
        return n * (n + m) * _INTERPRETED_PRODUCT + (_assembled(solver) if solver.renewed else 0.0)
    calls = {"runge_kutta_4": 4, "dormand_prince": 7}.get(solver.method, 20 + n)
    return solver.substeps * calls * _instant(solver)


def _assembled(solver: Solver) -> float:
    """Seconds that the matrices of a group take in plain Python, about: its rates for each column, and products."""
    if not solver.exact:
        return 0.0
    columns = len(solver.group.states) + len(solver.group.inputs)
    product = _INTERPRETED_PRODUCT if columns <= MANY_COLUMNS else _ARRAY_PRODUCT
    return columns * _instant(solver) + _PRODUCTS * columns**3 * product


def _instant(solver: Solver) -> float:
    group = solver.group
    return (len(group.states) + len(group.blocks) + len(group.nodes)) * _INTERPRETED_STEP


def _likeness(planned: Plan) -> int:
    """A number that plans of one loop share, whatever their parameters."""
    kinds = tuple((name, type(block)) for name, block in planned.blocks.items())
    return hash((kinds, planned.graph.wires, planned.probes, planned.schedule.base_rate))


def make_engine(planned: Plan, name: str, seed: int, run: int, memory: Memory) -> Engine:
    """An engine that starts from a memory."""
    return ENGINES[name].prepare(planned)(planned, seed, run, memory)
