"""Blocks: one file per block, pure functions over scalars, the standard library only.

    from proofmass.blocks import MassSpringDamper, Step

Each name is imported when it is first used, from the module that the catalogue finds for it.
"""

from importlib import import_module
from typing import Any


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return _kinds()
    if name[:1].isupper():
        from proofmass.blocks.declaration.catalog import find  # the catalogue costs start-up time

        kind = find(name)
        if kind is not None:
            return kind
    from proofmass.blocks.declaration.absent_names import absent  # few names are wrong

    raise absent("proofmass.blocks", name, "" if name.startswith("_") else _instead(name))


def _instead(name: str) -> str:
    """Return what was meant by a name that is not a kind of block."""
    if name in import_module("proofmass").__all__:
        return f"; it is one floor up: from proofmass import {name}"
    from proofmass.blocks.declaration.other_names import kind_hint  # few names are wrong

    return f"; {kind_hint(name, _kinds(), own=True)}"


def _kinds() -> list[str]:
    from proofmass.blocks.declaration.catalog import all_blocks  # imports every block

    return list(all_blocks())


def __dir__() -> list[str]:
    return _kinds()
