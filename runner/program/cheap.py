"""What may as well be executed where its values are not needed."""

from proofmass.runner.program.form import Compute, Constant, Get, Load, Region, Statement

_DEAR = {"divide", "square_root", "floor_divide", "modulo"}  # operations that are not done in vain
_MANY = 12  # statements that are not executed in vain


def is_cheap(*regions: Region) -> bool:
    """Whether the statements of some regions, together, may as well be executed where their values are not needed."""
    return sum(map(len, regions)) <= _MANY and all(_costs_little(s) for region in regions for s in region)


def _costs_little(statement: Statement) -> bool:
    match statement:
        case Compute(_, operation):
            return operation not in _DEAR
        case Get() | Load(_, _, Constant()):
            return True
    return False
