"""Estimated seconds of a run in plain Python and of machine code, by which engines and settings of LLVM are chosen."""

from proofmass.runner.continuous.exact_hold import MANY_COLUMNS
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver

COMPILING_SECONDS = 0.1  # about that of compiling, which like runs may take in Python
_COMPILING_FUNCTION = 2.5e-3  # seconds more for each function of a block: 7 s for the 31 graphs of the library
_INTERPRETED_STEP = 1.5e-6  # seconds per function and tick in plain Python, measured
_INTERPRETED_ENTRY = 0.15e-6  # the same per entry of a buffer
_INTERPRETED_PRODUCT = 0.1e-6  # the same per product of a matrix
_ARRAY_PRODUCT = 2e-9  # the same where NumPy multiplies large matrices
_PRODUCTS = 30.0  # products of matrices in an exponential, about
_INTERPRETED_INTEGER = 0.4e-6  # for an integer operation, which runs in `FixedValue`
_OPTIMISING_FUNCTION = 5e-3  # seconds that optimising machine code takes for each function, and more
_UNOPTIMISED_FUNCTION = 7e-9  # seconds more per function and tick without it, as of graphs of the library
_UNOPTIMISED_NUMBER = 1e-9  # the same per entry of a buffer or product of a group


def interpreting_seconds(planned: Plan, ticks: int) -> float:
    """Estimate the seconds that a run takes in plain Python."""
    integers = sum(len(s.code.live) for block in planned.digital.values() for s in block.steps.values())
    tick = len(planned.schedule.order) * _INTERPRETED_STEP + _entries(planned) * _INTERPRETED_ENTRY
    tick += integers * _INTERPRETED_INTEGER
    return ticks * (tick + sum(map(_interpreted, planned.solvers))) + sum(map(_assembled, planned.solvers))


def compiling_seconds(planned: Plan) -> float:
    """Estimate the seconds that compiling a plan takes."""
    return COMPILING_SECONDS + _COMPILING_FUNCTION * len(planned.schedule.order)


def is_short(planned: Plan, ticks: int) -> bool:
    """Return whether some ticks of machine code take less time than optimising it gains."""
    functions, numbers = len(planned.schedule.order), _entries(planned) + sum(map(_products, planned.solvers))
    more = functions * _UNOPTIMISED_FUNCTION + numbers * _UNOPTIMISED_NUMBER
    return ticks * more < functions * _OPTIMISING_FUNCTION


def _entries(planned: Plan) -> int:
    """Count the entries of the buffers that a tick may look at."""
    return sum(len(held) for node, held in planned.buffers.items() if node not in planned.recorded)


def _products(solver: Solver) -> int:
    """Count the products of an exact group in a tick, about, or what the steps of another one call."""
    n, m = len(solver.group.states), len(solver.group.inputs)
    if solver.exact:
        return n * (n + m)
    calls = {"runge_kutta_4": 4, "dormand_prince": 7}.get(solver.method, 20 + n)
    return solver.substeps * calls * _functions(solver)


def _interpreted(solver: Solver) -> float:
    """Seconds that a group takes for a tick in plain Python, about."""
    if solver.exact:
        return _products(solver) * _INTERPRETED_PRODUCT + (_assembled(solver) if solver.renewed else 0.0)
    return _products(solver) * _INTERPRETED_STEP


def _assembled(solver: Solver) -> float:
    """Seconds that the matrices of a group take in plain Python, about: its rates for each column, and products."""
    if not solver.exact:
        return 0.0
    columns = len(solver.group.states) + len(solver.group.inputs)
    product = _INTERPRETED_PRODUCT if columns <= MANY_COLUMNS else _ARRAY_PRODUCT
    return columns * _functions(solver) * _INTERPRETED_STEP + _PRODUCTS * columns**3 * product


def _functions(solver: Solver) -> int:
    group = solver.group
    return len(group.states) + len(group.blocks) + len(group.nodes)
