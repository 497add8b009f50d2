"""A thousand damaged copies of the library: each is read and checked, or refused with file and line."""

import random
import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph
from tests.by_hand.graph_texts import LIBRARY

COPIES = 1000
SECONDS = 20.0  # for all of them
TAKEN: dict[str, float] = {}  # by the kind of damage
WHOLE_FILE = {"the graph has no rate", "the graph has no blocks", "no probes: a run records nothing"}
TOKEN = re.compile(rb"\"[^\"\n]*\"|[\w.]+|[^\w\s]")
VALUES = [
    *(b"0 -1 1e999 nan -inf true [] {} '' 1979-05-27 0x7f 1_0 -0.0 9223372036854775808 [[1]] {a.b=1} 5e-324".split()),
    b'"1 V"',
    b'"0 s"',
    b'"50 kHz"',
    b'"\xc2\xb5"',
    b'"""\n"""',
    b'"a.b -> c.d"',
    b'["x"]',
    b"9" * 300,
]


def flipped(data: bytes, draw: random.Random) -> bytes:
    """Up to four bytes changed by a bit each."""
    damaged = bytearray(data)
    for _ in range(draw.randint(1, 4)):
        damaged[draw.randrange(len(damaged))] ^= 1 << draw.randrange(8)
    return bytes(damaged)


def tokens_swapped(data: bytes, draw: random.Random) -> bytes:
    """Two words, texts or marks in each other's place."""
    first, second = sorted(draw.sample(list(TOKEN.finditer(data)), 2), key=lambda token: token.start())
    between = data[first.end() : second.start()]
    return data[: first.start()] + second[0] + between + first[0] + data[second.end() :]


def line_deleted(data: bytes, draw: random.Random) -> bytes:
    lines = data.split(b"\n")
    del lines[draw.randrange(len(lines))]
    return b"\n".join(lines)


def line_doubled(data: bytes, draw: random.Random) -> bytes:
    lines = data.split(b"\n")
    lines.insert(draw.randrange(len(lines)), draw.choice(lines))
    return b"\n".join(lines)


def value_changed(data: bytes, draw: random.Random) -> bytes:
    lines = data.split(b"\n")
    at = draw.choice([number for number, line in enumerate(lines) if b"=" in line])
    lines[at] = lines[at].partition(b"=")[0] + b"= " + draw.choice(VALUES)
    return b"\n".join(lines)


def end_cut_off(data: bytes, draw: random.Random) -> bytes:
    return data[: draw.randrange(len(data))]


DAMAGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    flipped,
    tokens_swapped,
    line_deleted,
    line_doubled,
    value_changed,
    end_cut_off,
)


def problems_of_file(file: Path) -> tuple[Problem, ...]:
    try:
        return tuple(check(read_graph(file)))
    except ModelError as error:
        return error.problems


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
@pytest.mark.friendly(9, "damaged files are read, or refused with their line")
def test_a_damaged_file_is_read_or_refused_with_file_and_line(
    damage: Callable[[bytes, random.Random], bytes], tmp_path: Path
) -> None:
    file = tmp_path / "damaged.toml"
    texts = [path.read_bytes() for path in LIBRARY]
    refused = 0
    began = time.thread_time()
    for seed in range(COPIES // len(DAMAGES) + 1):
        draw = random.Random(f"{damage.__name__} {seed}")
        data = damage(draw.choice(texts), draw)
        file.write_bytes(data)
        problems = problems_of_file(file)
        refused += any(not problem.note for problem in problems)
        for problem in problems:
            told = f"seed {seed}: {problem}"
            assert problem.file == str(file), told
            assert problem.line <= data.count(b"\n") + 1, told
            assert problem.line > 0 or problem.message in WHOLE_FILE, told
            assert problem.message, told
            assert all(row.isprintable() for row in str(problem).split("\n")), told
    TAKEN[damage.__name__] = time.thread_time() - began
    assert sum(TAKEN.values()) < SECONDS, TAKEN
    assert refused > 20
