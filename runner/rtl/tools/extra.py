"""Packages of `pip install proofmass[rtl]`, and the message if one is missing."""

from importlib.util import find_spec

from proofmass.blocks.declaration.problem import ModelError, Problem


def installed(package: str) -> bool:
    """Return whether Python finds a package."""
    return find_spec(package) is not None


def need(package: str, purpose: str, hint: str = "pip install proofmass[rtl]") -> None:
    """Raise `ModelError` with what to install if a package is missing."""
    if not installed(package):
        raise ModelError([Problem(message=f"{package} is not installed: it makes {purpose}", hint=hint)])
