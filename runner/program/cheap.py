"""Statements so cheap that a program may execute them even where their values are not needed."""

from proofmass.runner.program.form import Compute, Constant, Get, Load, Region, Statement

_DEAR = {"divide", "square_root", "floor_divide", "modulo"}  # operations too slow to be done in vain
_MANY = 12  # statements that must not run in vain


def is_cheap(*regions: Region) -> bool:
    """Return whether all statements of some regions together are so cheap that they may always be executed."""
    return sum(map(len, regions)) <= _MANY and all(_costs_little(s) for region in regions for s in region)


def _costs_little(statement: Statement) -> bool:
    match statement:
        case Compute(_, operation):
            return operation not in _DEAR
        case Get() | Load(_, _, Constant()):
            return True
    return False
