"""Blocks: one file per block, pure functions over scalars, the standard library only.

    from proofmass.blocks import MassSpringDamper, Step

Each name is imported when it is first used, from the module that the catalogue finds for it.
"""

from typing import Any


def __getattr__(name: str) -> Any:
    if name[:1].isupper():
        from proofmass.blocks.declaration.catalog import find  # the catalogue costs start-up time

        kind = find(name)
        if kind is not None:
            return kind
    raise AttributeError(f"module 'proofmass.blocks' has no attribute {name!r}")


def __dir__() -> list[str]:
    from proofmass.blocks.declaration.catalog import all_blocks  # imports every block

    return sorted([*globals(), *all_blocks()])
