"""Tables of blocks and of graphs from files: what is wrong with them, each at its line."""

from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.limits import PROBLEMS
from tests.by_hand.graph_texts import SMALL, line_of, problems_of

PART = 'exports = { out = "a.output" }\n[blocks.a]\nkind = "Step"\n'


@pytest.mark.parametrize(
    ("tables", "at", "said"),
    [
        (
            '[blocks.part]\ngraph = "part.toml"\ncount = 2\n[blocks.part_1]\nkind = "Step"\n',
            "count =",
            "blocks.part.count: there is another block of that name\n  got:      part_1\n"
            "  hint:     rename [blocks.part_1]: blocks.part.count makes part_1 to part_2",
        ),
        (
            f'[blocks.part]\ngraph = "part.toml"\n"a.unit" = "{"m" * 401}"\n',
            '"a.unit"',
            "blocks.part.a.unit: a text of over 400 characters",
        ),
    ],
)
def test_a_graph_from_a_file(tables: str, at: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "part.toml").write_text(PART)
    text = f"{SMALL}\n{tables}"
    (problem,) = (problem for problem in problems_of(text, folder=str(tmp_path)) if not problem.note)
    assert str(problem) == f"model.toml:{line_of(text, at)}: {said}"


def test_the_clock_offset_of_a_graph_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "part.toml").write_text(PART)
    text = f'{SMALL}\n[blocks.part]\ngraph = "part.toml"\nclock_offset = "10 us"\ncount = 2\n'
    graph = read_graph_text(text, folder=str(tmp_path))
    assert flatten(graph).offsets == {"part_1.a": graph.offsets["part_1"], "part_2.a": graph.offsets["part_2"]}
    assert float(graph.offsets["part_2"]) == pytest.approx(1e-5)
    late = text.replace('"10 us"', '"10 ms"')
    (problem, *_) = (problem for problem in problems_of(late, folder=str(tmp_path)) if not problem.note)
    assert problem.message == "the clock offset is too long"


def test_an_own_block_whose_defaults_do_not_go_together_has_the_problems_of_its_table(tmp_path: Path) -> None:
    file = tmp_path / "own_blocks.py"
    file.write_text(
        "from proofmass import Block, param\n"
        "class Middle(Block):\n"
        '    """A level between two."""\n'
        '    low: float = param("V", "Lower end.", default=1.0)\n'
        '    high: float = param("V", "Upper end.", default=1.0)\n'
        "@Middle.requires\n"
        "def requires(p):\n"
        "    if p.high <= p.low:\n"
        '        yield "high", "above low"\n'
        '@Middle.output("V")\n'
        "def output(p) -> float:\n"
        '    """The middle."""\n'
        "    return 0.5 * (p.low + p.high)\n",
        encoding="utf-8",
    )
    text = 'rate = "1 kHz"\nprobes = ["b.output"]\n[blocks.b]\nkind = "Middle"\nhigh = "2 V"\nlow = "0 V"\n'
    own = load_own_blocks(file)
    assert read_graph_text(text, own=own).blocks["b"].high == 2.0  # type: ignore[attr-defined]
    with pytest.raises(ModelError) as caught:
        read_graph_text(text.replace("0 V", "3 V"), own=own)
    (problem,) = caught.value.problems
    assert str(problem).startswith("<text>:5: blocks.b.high: does not go with the other parameters")
    assert problem.expected == "above low"


def test_beyond_a_hundred_wrong_blocks_no_more_are_read() -> None:
    wrong = "".join(f'[blocks.wrong_{i}]\nkind = "Stpe"\n' for i in range(PROBLEMS + 20))
    found = [problem for problem in problems_of(wrong) if problem.key.endswith(".kind")]
    assert len(found) == PROBLEMS
