"""The stubs that tell editors and type checkers what the two lazy packages hold.

python -m tests.documents.stubs     writes them
"""

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import proofmass
from proofmass.blocks.declaration.catalog import all_blocks

ROOT = Path(__file__).parents[2]
STUBS = ("src/proofmass/__init__.pyi", "blocks/__init__.pyi")


def stub_text(path: str) -> str:
    """What a stub must say, from the tables of the package."""
    if path == STUBS[0]:
        return _text("proofmass.", proofmass._HOMES) + "\n__version__: str\n"
    return _text("", {name: kind.__module__ for name, kind in all_blocks().items()})


def _text(prefix: str, homes: Mapping[str, str]) -> str:
    by_home = defaultdict(list)
    for name, home in homes.items():
        by_home[prefix + home].append(name)
    lines = [f"from {home} import {', '.join(f'{n} as {n}' for n in sorted(names))}" for home, names in by_home.items()]
    return "\n".join(sorted(line for line in lines)) + "\n"


if __name__ == "__main__":
    for stub in STUBS:
        (ROOT / stub).write_text(stub_text(stub), encoding="utf-8")
