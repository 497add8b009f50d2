"""The class of every class of blocks, which reads its body: parameters, inputs and buffers."""

import dataclasses
import inspect
import typing
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, dataclass_transform

from proofmass.blocks.declaration.facts import Declaration
from proofmass.blocks.declaration.names import refuse_taken
from proofmass.blocks.declaration.parameter import declared, param
from proofmass.blocks.declaration.ports import Buffer, Input
from proofmass.blocks.declaration.registration import Registration, refuse_no_unit

_NOTHING = Declaration("", {}, {}, {}, None, False)


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(param,))
class BlockType(Registration):
    """The class of every class of blocks: it takes parameters, inputs and buffers out of the body of the class."""

    __dataclass_fields__: "dict[str, dataclasses.Field[Any]]"

    def __new__(mcs, name: str, bases: tuple[type, ...], body: Mapping[str, Any]) -> "BlockType":
        given = {n: v for n, v in body.items() if isinstance(v, dataclasses.Field | Input | Buffer)}
        kind = super().__new__(mcs, name, bases, {n: v for n, v in body.items() if n not in given})
        kind.__declaration__ = _declaration(kind, given)
        for attribute in body.keys() - given.keys():
            _refuse_hiding(kind, attribute)
        kind.__dataclass_fields__ = _fields(kind)
        for name, unit in _units(kind):
            refuse_no_unit(kind, name, unit)
        return kind

    @property
    def __signature__(self) -> inspect.Signature:
        """The parameters by name with types and defaults, for `inspect.signature` and editors."""
        keyword = inspect.Parameter.KEYWORD_ONLY
        return inspect.Signature(
            [
                inspect.Parameter(parameter.name, keyword, default=parameter.default, annotation=parameter.kind)
                for parameter in self.parameters.values()
            ]
        )


def _declaration(kind: BlockType, fields: Mapping[str, Any]) -> Declaration:
    """Declaration in the body of a class, added to that of its base."""
    base = next((b.__declaration__ for b in kind.__mro__[1:] if isinstance(b, BlockType)), _NOTHING)
    hints = typing.get_type_hints(kind)
    annotated = [n for n in inspect.get_annotations(kind) if typing.get_origin(hints[n]) is not ClassVar]
    for name in fields:
        refuse_taken(kind, name)
        if isinstance(fields[name], dataclasses.Field) and name not in annotated:
            raise TypeError(f"{kind.__name__}.{name} needs its type: write {name}: float = param(...)")
    parameters = {name: declared(kind.__name__, name, fields.get(name), hints[name]) for name in annotated}
    inputs = {name: value.named(name) for name, value in fields.items() if isinstance(value, Input)}
    buffers = {name: value.named(name) for name, value in fields.items() if isinstance(value, Buffer)}
    return Declaration(
        kind.__name__,
        {**base.parameters, **parameters},
        {**base.inputs, **inputs},
        {**base.buffers, **buffers},
        base.requirements,
        base.linear,
    )


def _fields(kind: BlockType) -> "dict[str, dataclasses.Field[Any]]":
    """Fields for `dataclasses.fields` and `dataclasses.replace`; the class has no attributes for parameters."""
    fields = [(p.name, p.kind, dataclasses.field(default=p.default)) for p in kind.parameters.values()]
    values: Any = dataclasses.make_dataclass(kind.__name__, fields, eq=False, repr=False)
    return typing.cast("dict[str, dataclasses.Field[Any]]", values.__dataclass_fields__)


def _units(kind: BlockType) -> Iterator[tuple[str, str]]:
    """The unit of each parameter that has one, and of each input."""
    yield from ((parameter.name, parameter.unit) for parameter in kind.parameters.values() if parameter.unit)
    yield from ((port.name, port.unit) for port in kind.inputs.values())


def _refuse_hiding(kind: BlockType, attribute: str) -> None:
    """Raise TypeError if an attribute that is neither parameter nor port would hide one that every kind has."""
    if not attribute.startswith("__") and hasattr(BlockType, attribute):
        raise TypeError(
            f"{kind.__name__}.{attribute}: the name is taken; every block has {attribute}, and only a parameter or a "
            "port may have its name"
        )
