"""Libraries of others that only some uses need: what each is for, and the extra of the package that brings it.

A plain installation has none of them: it declares, checks and runs graphs and studies, and finds
margins. Whoever imports one of them within a function asks `need` for it first; modules that import
one at their head are imported when they are used.
"""

import sys
from collections.abc import Mapping
from importlib.util import find_spec
from types import MappingProxyType
from typing import NamedTuple

from proofmass.blocks.declaration.problem import ModelError, Problem


class Library(NamedTuple):
    """Purpose of a library, and the extra that brings it."""

    extra: str
    purpose: str


LIBRARIES: Mapping[str, Library] = MappingProxyType(
    {
        "h5netcdf": Library("netcdf", "netCDF files"),
        "h5py": Library("netcdf", "netCDF files"),
        "pyarrow": Library("parquet", "Parquet files"),
        "xarray": Library("xarray", "labelled results of xarray"),
        "pandas": Library("xarray", "tables of pandas"),
        "distributed": Library("dask", "studies on the workers of a cluster"),
        "cryptography": Library("dask", "certificates of local workers"),
        "pyosys": Library("rtl", "proofs, resources and models of Verilog"),
        "bitwuzla": Library("rtl", "proofs of Verilog"),
    }
)


class MissingLibraryError(ModelError, ImportError):
    """Raised where a library is not installed; its problems name what brings it."""


def installed(library: str) -> bool:
    """Return whether Python finds a library."""
    return sys.modules.get(library) is not None or find_spec(library) is not None


def need(*libraries: str, purpose: str = "") -> None:
    """Raise `MissingLibraryError` with what to install, where a library is missing."""
    problems = [_missing(library, purpose) for library in libraries if not installed(library)]
    if problems:
        raise MissingLibraryError(problems)


def told(error: ImportError) -> MissingLibraryError | None:
    """Return the error to raise for an import that failed; None if no library is missing."""
    library = (error.name or "").partition(".")[0]
    return MissingLibraryError([_missing(library)]) if library in LIBRARIES and not installed(library) else None


def cure(library: str) -> str:
    """The command that installs a library."""
    return f'pip install "proofmass[{LIBRARIES[library].extra}]"'


def _missing(library: str, purpose: str = "") -> Problem:
    made = purpose or LIBRARIES[library].purpose
    return Problem(message=f"{library} is not installed: it makes {made}", hint=cure(library))
