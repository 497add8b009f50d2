"""The version of proofmass, and those of installed packages, each read from its files once."""

import importlib.metadata as metadata
from functools import cache

PROOFMASS = "0.2.0"


@cache
def version(package: str) -> str:
    """The version of a package as it is installed."""
    return metadata.version(package)
