"""Home of each kind of block: a file with its name in words joined by underscores, in the folder of its family."""

import pkgutil
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOUNDATIONS = ("arithmetic", "declaration", "language", "parameter_sets")  # folders of foundations, not of blocks


@cache
def families() -> dict[str, tuple[str, ...]]:
    """The modules of each family, both in alphabetical order."""
    folders = (m.name for m in pkgutil.iter_modules([str(ROOT)]) if m.ispkg and m.name not in FOUNDATIONS)
    return {name: tuple(m.name for m in pkgutil.iter_modules([str(ROOT / name)])) for name in sorted(folders)}


@cache
def homes() -> dict[str, str]:
    """The module of each kind, as in {"massspringdamper": "mechanics.mass_spring_damper"}.

    >>> homes()["massspringdamper"]
    'mechanics.mass_spring_damper'
    """
    return {stem.replace("_", ""): f"{family}.{stem}" for family, stems in families().items() for stem in stems}
