"""Files made to take long or to crash the reader: each is refused or read within half a second, without a traceback."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.model.limits import FILE_BYTES
from tests.by_hand.graph_texts import SMALL

SECONDS = 0.5  # of the processor for this thread, so that a busy machine does not matter

BOMBS: dict[str, Callable[[], str]] = {
    "nested brackets": lambda: "a = " + "[" * 100_000 + "]" * 100_000,
    "nested brackets, open": lambda: "a = " + "[" * 100_000,
    "nested braces": lambda: "a = " + "{a = " * 100_000,
    "nested tables": lambda: "".join("[" + ".".join("a" * depth) + "]\n" for depth in range(1, 1000)),
    "brackets of headers": lambda: "[" * 100_000 + "a" + "]" * 100_000,
    "dotted key": lambda: ".".join("a" * 32_000) + " = 1",
    "dotted header": lambda: "[" + ".".join("a" * 32_000) + "]",
    "dotted key in braces": lambda: "a = { " + ".".join("a" * 32_000) + " = 1 }",
    "dotted value": lambda: "a = " + ".".join("a" * 32_000),
    "long key": lambda: "a" * 1_000_000 + " = 1",
    "long quoted key": lambda: '"' + "a" * 1_000_000 + '" = 1',
    "long integer": lambda: "seed = " + "9" * 10_000,
    "long hexadecimal integer": lambda: "seed = 0x" + "f" * 10_000,
    "long float": lambda: "seed = 0." + "9" * 10_000,
    "many integers": lambda: "wires = [" + ("9" * 390 + ",") * 2_600 + "]",
    "long integer in quotes": lambda: SMALL.replace('"1 uN"', '"' + "9" * 500_000 + '"'),
    "long integer and a line in quotes": lambda: SMALL.replace('"1 uN"', '"""' + "9" * 500_000 + '\n\n x"""'),
    "long rate": lambda: SMALL.replace('"10 kHz"', '"""' + "9" * 500_000 + '\n\n x"""'),
    "long duration": lambda: SMALL.replace('"1 s"', '"""' + "9" * 500_000 + '\n\n x"""'),
    "long unit": lambda: SMALL.replace('unit = "N"', 'unit = "' + "(" * 500_000 + '"'),
    "long kind": lambda: SMALL.replace('"Gain"', '"' + "Gain" * 100_000 + '"'),
    "long wire": lambda: SMALL.replace("push.output ->", "push" + ".output" * 100_000 + " ->"),
    "arrows": lambda: SMALL.replace("push.output -> mass.force", "->" * 400_000),
    "tall unit": lambda: SMALL.replace('"1 uN"', '"1 sqrt(Ym^12*Ym^12*Ym^12)"'),
    "small unit": lambda: SMALL.replace('unit = "N"', 'unit = "sqrt(ym^12*ym^12*ym^12)"'),
    "tables": lambda: "".join(f"[a{n}]\n" for n in range(100_000)),
    "arrays of tables": lambda: "[[a]]\n" * 100_000,
    "keys": lambda: "".join(f"a{n}=1\n" for n in range(100_000)),
    "entries": lambda: "wires = [" + "1," * 400_000 + "]",
    "one key again and again": lambda: "a = 1\n" * 100_000,
    "unclosed quotes": lambda: "'" * 999_999,
    "unclosed double quotes": lambda: '"' * 999_999,
    "unclosed long texts": lambda: '\\""" "\n' * 100_000,
    "unclosed texts, a line each": lambda: 'a = "\n' * 100_000,
    "backslashes": lambda: 'a = "' + "\\" * 900_000,
    "empty lines": lambda: "\n" * 1_000_000,
    "comments": lambda: "#\n" * 500_000,
    "spaces": lambda: " " * 1_000_000,
    "spaces before a comma": lambda: "a = [" + " " * 900_000 + "x",
    "blocks without kind": lambda: "".join(f"[blocks.b{n}]\n" for n in range(20_000)),
    "samples": lambda: SMALL.replace('duration = "1 s"', "samples = 1" + "0" * 390),
    "every": lambda: SMALL.replace('"adc.code"', '{ signal = "adc.code", every = 1' + "0" * 390 + " }"),
}


@pytest.fixture(scope="module", autouse=True)
def _blocks_are_imported() -> None:
    from proofmass.blocks.declaration.catalog import all_blocks

    all_blocks()


@pytest.mark.parametrize("name", BOMBS)
def test_a_bomb_is_refused_or_read_at_once(name: str) -> None:
    text = BOMBS[name]()
    began = time.thread_time()
    try:
        problems = list(check(read_graph_text(text, "bomb.toml")))
    except ModelError as error:
        problems = list(error.problems)
    taken = time.thread_time() - began
    assert problems
    assert all(len(str(problem)) < 3_000 and problem.file == "bomb.toml" for problem in problems)
    assert taken < SECONDS


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nested brackets", "bomb.toml:1: nested deeper than 32 levels"),
        ("dotted key", "bomb.toml:1: a key of more than 32 parts"),
        ("long integer", "bomb.toml:1: a word of 10000 characters; at most 400 are read"),
        ("tables", "bomb.toml:25001: more than 100000 words"),
        ("long key", "bomb.toml:1: a word of 1000000 characters; at most 400 are read"),
        ("long quoted key", "bomb.toml:1: a name of more than 256 characters"),
        ("backslashes", "bomb.toml:1: more than 100000 backslashes"),
    ],
)
def test_what_is_said_of_a_bomb(name: str, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        read_graph_text(BOMBS[name](), "bomb.toml")
    assert str(caught.value) == message


def test_a_file_over_a_mebibyte_is_refused_unread(tmp_path: Path) -> None:
    file = tmp_path / "large.toml"
    file.write_bytes(b"# " + b"\xff" * 50_000_000)
    began = time.thread_time()
    with pytest.raises(ModelError) as caught:
        read_graph(file)
    assert time.thread_time() - began < SECONDS
    assert (
        str(caught.value)
        == f"""\
{file}: larger than 1024 KiB
  hint:     put recorded data into a file of its own"""
    )


def test_an_endless_file_is_refused() -> None:
    began = time.thread_time()
    with pytest.raises(ModelError, match="/dev/zero: larger than 1024 KiB"):
        read_graph("/dev/zero")
    assert time.thread_time() - began < SECONDS


def test_a_file_of_a_mebibyte_is_read(tmp_path: Path) -> None:
    file = tmp_path / "full.toml"
    file.write_text(SMALL + "#" * (FILE_BYTES - len(SMALL)), encoding="utf-8")
    assert check(read_graph(file)) == []


def test_characters_of_several_bytes_count_as_several() -> None:
    with pytest.raises(ModelError, match="larger than 1024 KiB"):
        read_graph_text("# " + "é" * (FILE_BYTES // 2))


@pytest.mark.exhaustive
def test_a_graph_of_thousands_of_blocks_is_read_within_seconds() -> None:
    text = 'name = "long"\nrate = 1\nwires = [\n'
    text += "".join(f'"b{n}.output -> b{n + 1}.input",\n' for n in range(6_000))
    text += '"b0.output -> b0.input",\n]\nprobes = ["b6000.output"]\n'
    text += "".join(f'[blocks.b{n}]\nkind = "UnitDelay"\n' for n in range(6_001))
    began = time.thread_time()
    assert check(read_graph_text(text)) == []
    assert time.thread_time() - began < 4.0
