"""Dataclasses are frozen: descriptions stay as they are, and may be keys. Those that change are of a list.

Those of another list have many fields of like types: each is given by its name.
"""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
_DATACLASS = re.compile(r"^@(?:dataclasses\.)?dataclass\b(.*)\n(?:@.*\n)*class (\w+)", re.MULTILINE)
NAMED = {
    "blocks/declaration/problem.py: Problem",
    "graphs/model/flatten.py: FlatGraph",
    "graphs/model/graph.py: Graph",
    "graphs/model/graph.py: Placed",
    "graphs/model/loops.py: Loop",
    "graphs/studies/study.py: Study",
    "graphs/tuning/tuning.py: Tuning",
    "runner/analysis/margins/figures.py: Figures",
    "runner/analysis/margins/margins.py: Margins",
    "runner/analysis/several/together.py: Together",
    "runner/fixed/operations.py: OperationKind",
    "runner/plan/planned.py: Filled",
    "runner/plan/planned.py: Plan",
    "runner/plan/planned.py: WiredPlan",
}
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


def declared() -> dict[str, str]:
    """What stands behind the decorator of each dataclass."""
    return {
        f"{path.relative_to(ROOT)}: {name}": words
        for room in ("blocks", "graphs", "runner")
        for path in (ROOT / room).rglob("*.py")
        for words, name in _DATACLASS.findall(path.read_text(encoding="utf-8"))
    }


def test_all_dataclasses_but_those_of_the_list_are_frozen() -> None:
    found = declared()
    assert len(found) > 200
    assert {name for name, words in found.items() if "frozen=True" not in words} == CHANGING


def test_those_of_another_list_take_fields_by_name_alone() -> None:
    assert {name for name, words in declared().items() if "kw_only=True" in words} == NAMED
