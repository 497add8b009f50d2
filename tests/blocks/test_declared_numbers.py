"""Defaults and bounds of all parameters and inputs are those of a list, so that none changes without a word.

A graph that does not say a parameter or wire an input has its default: another one changes its runs.
`python -m tests.blocks.test_declared_numbers` writes the list.
"""

from pathlib import Path

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.parameter import Parameter

LIST = Path(__file__).with_name("declared_numbers.txt")


def told(parameter: Parameter) -> str:
    bounds = f" {parameter.bounds()}" if parameter.bounds() else ""
    return f"    {parameter.name} [{parameter.unit}] = {parameter.default!r}{bounds}\n"


def declared() -> str:
    lines = []
    for kind in all_blocks().values():
        lines += [f"{kind.__name__}\n", *map(told, kind.parameters.values())]
        lines += [f"    input {p.name} = {p.default!r}\n" for p in kind.inputs.values() if p.default is not None]
    return "".join(lines)


def test_every_default_and_bound_is_that_of_the_list() -> None:
    assert declared().splitlines() == LIST.read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    LIST.write_text(declared(), encoding="utf-8")
