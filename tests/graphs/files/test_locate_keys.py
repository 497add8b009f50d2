"""Lines of keys against a parser that knows none: in these texts every value is the number of its own line."""

import contextlib
import time
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from proofmass.graphs.files.locate_keys import KeyPath, LimitError, locate_keys
from proofmass.graphs.model.limits import KEY_LENGTH, KEY_PARTS, NESTING, NUMBER_LENGTH, WORDS
from tests.by_hand.graph_texts import LIBRARY

# "@" stands for the number of its line.
CORPUS = {
    "plain": "a = @\nb = @\n\n\nc = @",
    "comments": '# [x]\na = @ # ] } = "\n# b = 1\n  # \'\'\'\nc = @ # """\n[t] # [u]\nd = @ #',
    "tables": "[a]\nx = @\n[b.c]\nx = @\n[b]\ny = @\n[b.c.d]\n  z = @\n[ e . f ]\nx = @",
    "dotted keys": "a.b.c = @\na.b.d = @\na . e = @\n[t]\na.b = @\na.c.d = @",
    "quoted keys": (
        '"a b" = @\n\'c.d\' = @\n"" = @\n\'e\'."f#g" = @\n["h]i".\'j="k\']\nx = @\n"l\\"m" = @\n"n\\u00e9" = @'
    ),
    "numeric keys": "1 = @\n2.5 = @\n-3 = @\n1e5 = @\ntrue = @\n[4.5]\nx = @",
    "arrays": "a = [@, @,\n@,\n# no\n  @, # ]\n\n@\n]\nb = [[@, @], [\n@\n], []]\nc = @",
    "inline tables": (
        "a = { x = @, y.z = @, w = [@, @] }\nb = {}\nc = [{ x = @ }, { x = @, y = { z = @ } }]\n"
        "d = [\n{ x = @ },\n{ x = @ }\n]"
    ),
    "arrays of tables": (
        "[[a]]\nx = @\n[[a]]\nx = @\n[a.b]\ny = @\n[[a.c]]\nz = @\n"
        "[[a.c]]\nz = @\n[[a]]\nx = @\n[[a.c]]\nz = @\n[a.c.d]\nw = @"
    ),
    "strings": 'a = "@ [x] # \\" = "\nb = \'@ ["}#\'\nc = ["@", \'@\', "@ \\\\"]\nd = @',
    "long strings": (
        'a = """@ [x]\n[y]\nz = 1\n"""\nb = @\nc = \'\'\'@\n"""\n[t]\n\'\'\'\nd = @\ne = """@ ""\\" \\\n  """\nf = @'
    ),
    "quotes at the end of long strings": (
        "a = \"\"\"@ \"\"\"\"\nb = \"\"\"@ \"\"\"\"\"\nc = '''@ ''''\nd = '''@ '''''\ne = @"
    ),
    "empty strings": 'a = ["", \'\', """""", \'\'\'\'\'\']\nb = @\nc = """"@" """\nd = @',
    "long strings in arrays": 'a = ["""@\n[\n""", "@", """\n""",\n"@"]\nb = @',
    "windows ends": "a = @\r\n[b]\r\nx = [@,\r\n@,\r\n]\r\n\r\nc = @\r\n",
    "spaces": "\t a\t=\t @ \n  [ b ]  \n  x  .  y  =  @\n\t[[ c ]]\n\t\tz=@",
    "dates and floats": "a = [1979-05-27 07:32:00Z, +1.5e-3, -inf, nan, 0x01, 07:32:00.5]\nb = @",
    "no end": "[a]\nb = @ # end",
    "nothing": "",
    "blank": "\n \n\t\n",
}


def numbered(text: str) -> str:
    """Each "@" replaced by the number of its line."""
    return "\n".join(line.replace("@", str(number)) for number, line in enumerate(text.split("\n"), start=1))


def nodes(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Every key, table and entry of a parsed document."""
    if path:
        yield path, value
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in entries:
        yield from nodes(entry, (*path, str(key)))


def own_line(value: Any) -> int | None:
    """The line that a leaf says it stands on."""
    words = str(value).replace('"', "").split()
    known = isinstance(value, int | str) and words and words[0].isdigit()
    return int(words[0]) if known else None


def assert_lines_are_right(text: str) -> None:
    """Leaves say their line; a table is on the line of the statement after which a parser first knows it."""
    text = text.replace("\r\n", "\n")
    parsed, found = dict(nodes(tomllib.loads(text))), locate_keys(text)
    assert set(found) == set(parsed)
    for path, value in parsed.items():
        line = own_line(value)
        assert line is None or found[path] == line, path
    lines, known, start = text.split("\n"), set[KeyPath](), 1
    for end in range(1, len(lines) + 1):
        try:
            after = dict(nodes(tomllib.loads("\n".join(lines[:end]))))
        except tomllib.TOMLDecodeError:
            continue
        for path in after.keys() - known:
            assert start <= found[path] <= end, path
        known, start = set(after), end + 1


@pytest.mark.parametrize("name", CORPUS)
def test_lines_of_tricky_texts(name: str) -> None:
    assert_lines_are_right(numbered(CORPUS[name]))


@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_lines_of_the_library(path: Any) -> None:
    text = path.read_text(encoding="utf-8")
    found = locate_keys(text)
    assert set(found) == {path for path, _ in nodes(tomllib.loads(text))}
    lines = text.split("\n")
    for (*_, key), line in found.items():
        assert key in lines[line - 1] or key.isdigit()


names = st.text("ab1-", min_size=1, max_size=2)
keys = st.one_of(names, names.map(lambda name: f'"{name}]"'), names.map(lambda name: f"'{name} #'"))
dotted = st.lists(keys, min_size=1, max_size=3).map(".".join)
gaps = st.sampled_from(["", " ", "\n", "# ]'\"\n", "\n\n  "])
leaves = st.sampled_from(["@", '"@"', "'@ ] \"'", '"""@\n[x]\n"""', "'''@\n\n'''", '"@ \\" ["'])
arrays = st.lists(st.tuples(gaps, leaves, gaps).map("".join), max_size=3).map(lambda entries: f"[{','.join(entries)}]")
inline = st.lists(st.tuples(dotted, st.just(" = "), st.sampled_from(["@", "'@'"])).map("".join), max_size=2).map(
    lambda pairs: f"{{ {', '.join(pairs)} }}"
)
values = st.one_of(leaves, arrays, inline, st.lists(inline, max_size=2).map(lambda tables: f"[{', '.join(tables)}]"))
pairs = st.tuples(dotted, values).map(" = ".join)
headers = dotted.flatmap(lambda key: st.sampled_from([f"[{key}]", f"[[{key}]]"]))
documents = st.lists(st.one_of(pairs, pairs, headers, st.just("# [a] = '"), st.just("")), max_size=8).map("\n".join)


@pytest.mark.exhaustive
@given(documents)
@settings(max_examples=300, deadline=None)
def test_lines_of_random_documents(text: str) -> None:
    text = numbered(text)
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:  # a key or table given twice
        locate_keys(text)
    else:
        assert_lines_are_right(text)


@pytest.mark.exhaustive
@given(st.text(st.sampled_from("[]{}=,.\"'#\\\n\r\t ab1-_é\x00\u00a0\u2028\ud800"), max_size=60))
@settings(max_examples=1000, deadline=None)
@example('"""\\"""')
@example("[[")
@example("a = [")
@example("a = {")
@example("= 1")
@example("a = 1 2 3")
@example("[a.]]\n.b")
@example("a={b={c=[")
@example('"\\u12" = 1')
def test_any_text_gives_lines_or_a_limit(text: str) -> None:
    try:
        found = locate_keys(text)
    except LimitError as error:
        found = {("beyond",): error.line}
    assert all(1 <= line <= text.count("\n") + 1 for line in found.values())
    try:
        parsed = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return
    assert found.keys() == {("beyond",)} or set(found) == {path for path, _ in nodes(parsed)}


@pytest.mark.exhaustive
@given(st.sampled_from(sorted(CORPUS.values())), st.data())
@settings(max_examples=300, deadline=None)
def test_damaged_texts_give_lines_or_a_limit(text: str, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(text)))
    piece = data.draw(st.text(st.sampled_from("[]{}=,.\"'#\\\n a"), max_size=3))
    drop = data.draw(st.integers(0, 3))
    test_any_text_gives_lines_or_a_limit.hypothesis.inner_test(text[:at] + piece + text[at + drop :])  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("text", "message", "line"),
    [
        ("a = 1\nb = " + "[" * (NESTING + 1), f"nested deeper than {NESTING} levels", 2),
        ("\n" + ".".join("a" * (KEY_PARTS + 1)) + " = 1", f"a key of more than {KEY_PARTS} parts", 2),
        ("[" + ".".join("a" * (KEY_PARTS + 1)) + "]", f"a key of more than {KEY_PARTS} parts", 1),
        ("a" * (KEY_LENGTH + 1) + " = 1", f"a name of more than {KEY_LENGTH} characters", 1),
        ('x = {"' + "a" * (KEY_LENGTH + 1) + '" = 1}', f"a name of more than {KEY_LENGTH} characters", 1),
        ("a = " + "1" * 401, f"a word of 401 characters; at most {NUMBER_LENGTH} are read", 1),
        ("a = [" + "1,\n" * WORDS + "]", f"more than {WORDS} words", WORDS // 3),
    ],
)
def test_what_is_beyond_a_limit_is_refused_with_its_line(text: str, message: str, line: int) -> None:
    with pytest.raises(LimitError) as caught:
        locate_keys(text)
    assert str(caught.value) == message
    assert caught.value.line == line


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * NESTING + "]" * NESTING,
        ".".join("a" * KEY_PARTS) + " = 1",
        "a" * KEY_LENGTH + " = 1",
        "a = " + "1" * NUMBER_LENGTH,
        'a = "' + "x" * 100_000 + '"',
        "a = 1 # " + "[" * 100_000,
        "a = '" + "[" * 100_000 + "'",
    ],
    ids=range(7),
)
def test_what_is_within_the_limits_is_read(text: str) -> None:
    assert set(locate_keys(text).values()) == {1}


@pytest.mark.parametrize(
    "piece", ['\\""" "\n', '"""\\', "'''a\n'", '"\n', "\\", "#\n", "\n", "= ", "a.", '"""a', "'", "''", 'a="""\n"""\n']
)
def test_time_grows_with_length_alone(piece: str) -> None:
    began = time.process_time()
    with contextlib.suppress(LimitError):
        locate_keys(piece * (1_000_000 // len(piece)))
    assert time.process_time() - began < 1.0


def test_what_is_no_key_has_no_line() -> None:
    """The parser of TOML refuses it, and says where."""
    assert locate_keys("= 3\na = 1") == {("a",): 2}
    assert locate_keys('"\\q" = 1') == {("\\q",): 1}  # no escape
