"""Digital blocks in the generated loop: calls of their integer code, and what becomes of an overflow.

`block__overflow_` is not 0 when a value of the block saturated or wrapped in the tick, `block__overflows_` counts such
ticks; `refused` is not 0 from the tick on in which a value did not fit its format and should have.
"""

from collections.abc import Iterator

from proofmass.blocks.declaration.instance import format_of, shape_of
from proofmass.graphs.checks.schedule import Node
from proofmass.runner.plan.keys import OverflowsOf, made_up, word
from proofmass.runner.program.pieces import Pieces, entries


class DigitalCode:
    """The lines of digital blocks, and the integer code that they call."""

    def __init__(self, pieces: Pieces) -> None:
        self.pieces, self.plan = pieces, pieces.plan
        self.steps: dict[str, str] = {}  # source of the integer code by name
        self._counted = [name for name, block in self.plan.digital.items() if block.overflows]

        pieces.flags |= {made_up(word(name), "overflow") for name in self._counted}

    def before(self) -> Iterator[str]:
        """The counts that a call of the loop goes on from."""
        for name in self._counted:
            yield f"{made_up(word(name), 'overflows')} = {self.pieces.memory.add(OverflowsOf(name), int)}"

    def begin_tick(self) -> Iterator[str]:
        """No overflow yet."""
        return (f"{made_up(word(name), 'overflow')} = 0" for name in self._counted)

    def end_tick(self) -> Iterator[str]:
        """Counts, behind one condition that seldom holds."""
        words = [word(name) for name in self._counted]
        if words:
            yield f"if {' | '.join(f'{each}__overflow_' for each in words)}:"
            yield from (f"    {each}__overflows_ += {each}__overflow_ != 0" for each in words)

    def call(self, name: str, function: str, target: str) -> Iterator[str]:
        """Lines that call a function of a digital block and keep what it returns in `target`, where there is one."""
        block, step = self.plan.blocks[name], self.plan.digital[name].steps[function]
        behaviour = type(block).output_functions.get(function) or type(block).functions[function]
        called = self.pieces.named(block, function, step.code.function)
        self.steps[called] = step.code.source.replace(f"def {function}(", f"def {called}(", 1)
        self.pieces.refuses |= step.refuses
        flags = [made_up(word(name), "overflow")] * step.overflows + ["refused"] * step.refuses
        found = [target or "_"] * bool(target or flags) + [f"_{flag}" for flag in flags]
        given = [made_up(word(name), "c"), *(self.pieces.argument(name, function, a) for a in behaviour.arguments)]
        yield f"{', '.join(found)} = {called}({', '.join(given)})" if found else f"{called}({', '.join(given)})"
        yield from (f"{flag} |= _{flag}" for flag in flags)

    def hold(self, node: Node) -> Iterator[str]:
        """Mantissas that a converter made must fit their format; integer code relies on it to the end of the chunk."""
        block = self.plan.blocks[node[0]]
        format = format_of(block, node[1])
        self.pieces.refuses = True
        for entry in entries(node, shape_of(block, type(block).outputs[node[1]])):
            yield f"_held = min(max({entry}, {format.lowest}), {format.highest})"
            yield f"refused |= _held ^ {entry}"
            yield f"{entry} = _held"
