"""Names that a parameter or port cannot have, each with its present meaning."""

import keyword

from proofmass.blocks.declaration.arguments import Meaning

RESERVED = {meaning.argument: meaning.doc for meaning in Meaning if meaning.argument} | {
    "c": "the constants, the first argument of functions",
    "kind": "a key of a block in a graph file",
    "rate": "a key of a block in a graph file",
    "graph": "a key of a block in a graph file",
}
MOVING = {  # functions of a block that engines call beside those of its outputs, by name as those
    "update": "the function that gives the state of the next tick",
    "derivative": "the function that gives the rates of the state",
    "fold": "the function that writes the state in another form",
}


def refuse_taken(owner: type, name: str) -> None:
    """Raise TypeError if a parameter or port cannot have a name."""
    if name in RESERVED:
        raise taken(owner, name, f"{name} is {RESERVED[name]}")
    if keyword.iskeyword(name):
        raise taken(owner, name, f"{name} is a word of Python")
    if not name.isidentifier() or name.startswith("_"):
        raise TypeError(f"{owner.__name__}.{name}: a name begins with a letter and has letters, digits and _ only")


def taken(owner: type, name: str, by: str) -> TypeError:
    """Return the error for a name that something else has."""
    return TypeError(f"{owner.__name__}.{name}: the name is taken; {by}")
