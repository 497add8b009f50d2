"""Names that a package does not have: an error with a cure, for `package.name` and for `from package import name`."""

import sys
from opcode import opmap


def absent(package: str, name: str, cure: str) -> Exception:
    """Return the error that a `__getattr__` of a package raises for a name.

    An import statement swallows AttributeError and its words, but not ImportError.
    """
    caller = sys._getframe(2)  # of `__getattr__`
    by_import = caller.f_code.co_code[caller.f_lasti] == opmap["IMPORT_FROM"] if caller.f_lasti >= 0 else False
    if by_import:
        return ImportError(f"cannot import name {name!r} from {package!r}{cure}", name=name)
    return AttributeError(f"module {package!r} has no attribute {name!r}{cure}")
