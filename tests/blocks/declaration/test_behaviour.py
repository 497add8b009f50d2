"""What a function reads, by its instructions on every Python, against its text."""

import ast
import types

from proofmass.blocks import EllipticBand
from proofmass.blocks.declaration.behaviour import reads
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.source import tree_of


def test_what_the_functions_of_all_blocks_read_is_what_their_text_names() -> None:
    seen = set[bool]()
    for kind in all_blocks().values():
        for behaviour in {**kind.functions, **kind.output_functions}.values():
            assert isinstance(behaviour.function, types.FunctionType)
            tree = tree_of(behaviour.function)
            inside = (node for statement in tree.body for node in ast.walk(statement))
            named = {n.id for n in inside if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
            for argument in (arg.arg for arg in tree.args.args):
                assert reads(behaviour.function, argument) == (argument in named), (behaviour.function, argument)
                seen.add(argument in named)
    assert seen == {False, True}


def test_a_variable_in_an_inner_function_is_read_and_one_that_is_stored_is_not() -> None:
    def inner(first: float, second: float) -> float:
        return sum(first for _ in range(2))

    def stored(first: float, second: float) -> float:
        second = first  # noqa: F841
        return first

    assert reads(inner, "first")
    assert not reads(inner, "second")
    assert reads(stored, "first")
    assert not reads(stored, "second")


def test_what_a_helper_of_a_requirement_reads_is_not_driven() -> None:
    assert not EllipticBand.drivable("low_frequency")
    assert "ordered" in EllipticBand.requirements.__code__.co_names
    assert "low_frequency" not in EllipticBand.requirements.__code__.co_names
