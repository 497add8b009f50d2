"""Dataclasses are frozen: descriptions stay as they are, and may be keys. Those that change are of a list."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
_DATACLASS = re.compile(r"^@(?:dataclasses\.)?dataclass\b(.*)\n(?:@.*\n)*class (\w+)", re.MULTILINE)
CHANGING = {  # written step by step, or what moves in a run
    "blocks/declaration/facts.py: Declaration",
    "blocks/language/functions.py: Form",
    "blocks/language/loops.py: _Loop",
    "graphs/drawing/items.py: Item",
    "graphs/drawing/items.py: Net",
    "graphs/drawing/routing.py: Bar",
    "runner/design/proof/search.py: BoxPart",
    "runner/fixed/affine.py: AffineForms",
    "runner/fixed/integer_ir.py: IntegerProgram",
    "runner/live/named_values.py: NamedValues",
    "runner/plan/memory.py: Memory",
    "runner/program/form.py: Function",
    "runner/program/form.py: Program",
    "runner/program/parts.py: _Part",
    "runner/program/slots.py: Slots",
    "runner/program/varying.py: Varying",
    "runner/rtl/bench/cost.py: Cost",
}


def test_all_dataclasses_but_those_of_the_list_are_frozen() -> None:
    found = {
        f"{path.relative_to(ROOT)}: {name}": "frozen=True" in words
        for room in ("blocks", "graphs", "runner")
        for path in (ROOT / room).rglob("*.py")
        for words, name in _DATACLASS.findall(path.read_text(encoding="utf-8"))
    }
    assert len(found) > 200
    assert {name for name, frozen in found.items() if not frozen} == CHANGING
