"""Facts of a block that depend on the values of its parameters: units, sizes, formats."""

import typing
from collections.abc import Collection

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.parameter import Parameter, fill
from proofmass.blocks.declaration.ports import BufferPort, DeclaredSize, Port
from proofmass.blocks.declaration.problem import ModelError, Problem


def written(block: Block, name: str) -> str:
    """Return the text by which a parameter was given, such as "50.43 ug"; empty for a number.

    >>> from proofmass.blocks import MassSpringDamper
    >>> written(MassSpringDamper(mass="50.43 ug"), "mass"), written(MassSpringDamper(mass=5.043e-8), "mass")
    ('50.43 ug', '')
    """
    return block._texts.get(name, "")


def keep_written(changed: Block, before: Block, names: Collection[str]) -> Block:
    """Return a changed block with the texts of the one before, but for these parameters."""
    texts = {name: text for name, text in before._texts.items() if name not in names}
    object.__setattr__(changed, "_texts", {**texts, **{n: t for n, t in changed._texts.items() if n in names}})
    return changed


def takes_unit(block: Block, name: str, unit: str) -> bool:
    """Return whether a unit that is a parameter of a block may be another one, with all that the
    block says in units.

    >>> from proofmass.blocks import Gain
    >>> takes_unit(Gain(), "input_unit", "V"), takes_unit(Gain(gain="2 V", output_unit="V"), "input_unit", "A")
    (True, False)
    """
    try:
        type(block)(**{**vars(block), **block._texts, name: unit})
    except ModelError:
        return False
    return True


def unit_of(block: Block, what: Port | Parameter) -> str:
    """The unit of a port or parameter, with the block's own unit parameters put in."""
    if "{" not in what.unit:
        return what.unit
    return fill(what.unit, {n: getattr(block, n) for n, p in type(block).parameters.items() if p.kind is str})


def size_of(block: Block, size: DeclaredSize) -> int:
    """A size as a number: itself, an integer parameter's value, or the length of a list."""
    if isinstance(size, int):
        return size
    if callable(size):
        return size(block)
    value = getattr(block, size)
    return len(value) if isinstance(value, tuple) else int(value)


def shape_of(block: Block, what: Port | BufferPort) -> tuple[int, ...]:
    """The shape of a port or buffer as numbers."""
    return tuple(size_of(block, size) for size in what.shape)


def format_of(block: Block, what: str) -> Fixed:
    """The format of a fixed-point port or buffer, or of a field as in "x.total"; `formats` may say "x" for all."""
    functions = type(block).functions
    formats = functions["formats"].function(block) if "formats" in functions else {}
    format = formats.get(what) or formats.get(what.partition(".")[0])
    if format is None:
        key = f"{type(block).__name__}.formats"
        hint = f'return it there: {{"{what}": Fixed(16, 12)}}'
        raise Problem(message=f"the format of {what} is not said", key=key, hint=hint).error
    return typing.cast(Fixed, format)
