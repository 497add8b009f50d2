"""Encodings and letters: what cannot be read is refused with its line, what is shown can move no terminal."""

from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from tests.by_hand.graph_texts import SMALL, changed, problems_of, said_about

RIGHT_TO_LEFT, RED = "\u202e", "\x1b[31m"


def written(folder: Path, data: bytes) -> Path:
    file = folder / "model.toml"
    file.write_bytes(data)
    return file


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    assert read_graph(written(tmp_path, b"\xef\xbb\xbf" + SMALL.encode())) == read_graph_text(SMALL)


def test_line_ends_of_windows_are_read_and_counted(tmp_path: Path) -> None:
    data = SMALL.replace("\n", "\r\n").encode()
    assert read_graph(written(tmp_path, data)) == read_graph_text(SMALL)
    broken = written(tmp_path, data.replace(b"bits = 16", b"bist = 16"))
    assert said_about(broken).startswith("model.toml:27: blocks.adc.bist: ")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"a = 1\nb = '\xff'\n", "model.toml:2: not UTF-8 text\n  hint:     save the file as UTF-8"),
        (b"\xff\xfea\x00", "model.toml:1: not UTF-8 text\n  hint:     save the file as UTF-8"),
        (b"a = '\xed\xa0\x80'\n", "model.toml:1: not UTF-8 text\n  hint:     save the file as UTF-8"),
        (b"a = '\xc0\xaf'\n", "model.toml:1: not UTF-8 text\n  hint:     save the file as UTF-8"),
        (b"a = 'caf\xe9'\n", "model.toml:1: not UTF-8 text\n  hint:     save the file as UTF-8"),
        (b"\n\na = '\x00'\n", "model.toml:3: holds a NUL character\n  hint:     save it as plain text"),
        (b"a\x00", "model.toml:1: holds a NUL character\n  hint:     save it as plain text"),
    ],
)
def test_what_is_no_text_is_refused_with_its_line(data: bytes, said: str, tmp_path: Path) -> None:
    assert said_about(written(tmp_path, data)) == said


@pytest.mark.parametrize("escape", ["\\ud800", "\\U00110000", "\\udc00"])
def test_escapes_of_half_characters_are_refused(escape: str) -> None:
    assert problems_of(f'name = "{escape}"\n')[0].message.startswith("not TOML: ")


@pytest.mark.parametrize("text", ['name = "\ud800"', "\udcff = 1", '[blocks."\ud800"]\nkind = "Gain"'])
def test_half_characters_of_a_text_from_python_are_refused(text: str) -> None:
    problems = problems_of(text)
    assert problems
    "\n".join(map(str, problems)).encode("utf-8")


@pytest.mark.parametrize(
    "name",
    [
        "аdc",
        "ɑdc",
        "adс",
        "ａdc",
        "ad\u200bc",
        f"adc{RIGHT_TO_LEFT}",
        "عداد",
        "ADC",
        "adc\u0301",
        "ádc",
        "adc\n",
        "adc\t",
    ],
)
def test_names_with_look_alike_and_hidden_letters_are_refused_and_shown_escaped(name: str) -> None:
    written_name = name.replace("\n", "\\n").replace("\t", "\\t")
    problems = problems_of(changed(SMALL, "[blocks.adc]", f'[blocks."{written_name}"]'))
    (problem,) = [problem for problem in problems if problem.message == "not a name"]
    assert problem.line == 25
    assert problem.got.isascii()
    assert name not in str(problem) or name == "ADC"


@pytest.mark.parametrize("letters", [RIGHT_TO_LEFT, RED, "\x07", "\x7f", "\x9b31m", "\u2028", "\u200b", "\ufeff", "\r"])
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[blocks.adc]", '[blocks."adc@"]'),
        ("bits = 16", '"bits@" = 16'),
        ("bits = 16", 'reference = "5 @V"'),
        ("bits = 16", 'reference = "5 V@"'),
        ("bits = 16", 'rate = "5 @Hz"'),
        ('"Gain"', '"Gain@"'),
        ('unit = "N"', 'unit = "N@"'),
        ('"push.output -> mass.force"', '"push.output@ -> mass.force"'),
        ('probes = ["adc.code"]', 'probes = ["adc.code@"]'),
        ('probes = ["adc.code"]', 'probes = [{ signal = "adc.code", "every@" = 1 }]'),
        ('name = "', '"name@" = "'),
        ('"10 kHz"', '"@"'),
    ],
)
def test_control_characters_are_escaped_in_messages(old: str, new: str, letters: str) -> None:
    for escaped in (letters, f"\\u{ord(letters[0]):04x}{letters[1:]}"):
        if old == 'unit = "N"':
            text = SMALL.replace('unit = "N"', new.replace("@", escaped))
        else:
            text = changed(SMALL, old, new.replace("@", escaped))
        for problem in problems_of(text):
            assert all(line.isprintable() for line in str(problem).split("\n"))
            assert problem.line > 0


def test_a_text_may_hold_letters_of_any_script() -> None:
    graph = read_graph_text(changed(SMALL, "a mass and a converter", "Beschleunigungsmesser für 加速度 und تسارع"))
    assert check(graph) == []
    assert graph.name == "Beschleunigungsmesser für 加速度 und تسارع"


@pytest.mark.friendly(41, "such names in messages")
def test_file_names_with_spaces_umlauts_and_escapes(tmp_path: Path) -> None:
    folder = tmp_path / "mein Gerät \x1b[31m"
    folder.mkdir()
    good = folder / "größe 1.toml"
    good.write_text(SMALL, encoding="utf-8")
    assert check(read_graph(good)) == []
    good.write_text(changed(SMALL, "bits", "bist"), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        read_graph(good)
    assert "größe 1.toml:27: blocks.adc.bist" in str(caught.value)
    assert "\x1b" not in str(caught.value)
