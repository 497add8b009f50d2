"""Programs as text for readers."""

from pathlib import Path

from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    TRUTH,
    Compute,
    External,
    Function,
    Immediate,
    Line,
    Return,
    Storage,
    Value,
)
from proofmass.runner.program.listing import listing
from tests.by_hand.programs import Writer, program


def test_lines_of_python_stand_beside_theirs(tmp_path: Path) -> None:
    file = tmp_path / "spring.py"
    file.write_text("def force(x, v):\n    pull = 3.0 * x\n    return -pull - 2.0 * v + pull * x\n")
    x, v, pull = Value(FLOAT, "x"), Value(FLOAT, "v"), Value(FLOAT, "pull")
    first, second = Line(str(file), 2), Line(str(file), 3)
    parts = [Value(FLOAT) for _ in range(5)]
    body = [
        Compute(pull, "multiply", (Immediate(FLOAT, 3.0), x), first),
        Compute(parts[0], "negate", (pull,), second),
        Compute(parts[1], "multiply", (Immediate(FLOAT, 2.0), v), second),
        Compute(parts[2], "subtract", (parts[0], parts[1]), second),
        Compute(parts[3], "multiply", (pull, x), second),
        Compute(parts[4], "add", (parts[2], parts[3]), second),
        Return((parts[4],), second),
    ]
    text = listing(program(Function("force", (x, v), (FLOAT,), body, origin="spring.force")))
    assert [line.rstrip() for line in text.splitlines()] == [
        f"{'def force(x: f64, v: f64) -> f64:':88}# spring.force",
        f"{'    pull = 3.0 * x':88}# spring.py:2  pull = 3.0 * x",
        f"{'    return ((-pull - (2.0 * v)) + (pull * x))':88}# spring.py:3  return -pull - 2.0 * v + pull * x",
    ]


def test_every_statement_has_a_text() -> None:
    x, n, a = Value(FLOAT, "x"), Value(INTEGER, "n"), Storage(FLOAT, None, True, "a")
    inner = Writer("inner", x, Storage(INTEGER, 2, False, "b"), results=(FLOAT, INTEGER), inline=True)
    inner.leave(x, 1)
    w = Writer("f", x, n, a)
    b = Storage(INTEGER, 2, False, "b")
    w.function.parameters += (b,)
    v = w.variable(INTEGER, "v")
    with w.when(w.do("less", x, 0.0)) as otherwise:
        w.set(v, n)
    with w.into(otherwise):
        w.store(w.view(a, n, 3), 1, w.load(a, 0))
    with w.count(0, n, 2):
        w.skip()
    w.call(inner.function, x, b)
    w.call(External("model_step", (INTEGER,), None), 3)
    test = []  # type: ignore[var-annotated]
    with w.into(test):
        more = w.do("not", w.do("equal_integers", w.get(v), 3))
    with w.loop(test, more):
        w.stop()
    w.do("select", Immediate(TRUTH, True), w.do("absolute", x), float("nan"), name="x")
    assert listing(program(inner.function, w.function)) == (
        "inline def inner(x: f64, b: fixed i64[2]) -> f64, i64:\n"
        "    return x, 1\n"
        "\n"
        "def f(x: f64, n: i64, a: f64[], b: fixed i64[2]):\n"
        "    if (x < 0.0):\n"
        "        v := n\n"
        "    else:\n"
        "        part = a[n : n + 3]\n"
        "        a_2 = a[0]\n"
        "        part[1] := a_2\n"
        "    for i in range(0, n, 2):\n"
        "        continue\n"
        "    t, t_2 = inner(x, b)\n"
        "    model_step(3)\n"
        "    while True:\n"
        "        v_2 = v\n"
        "        t_3 = not (v_2 == 3)\n"
        "        if not t_3: break\n"
        "        break\n"
        "    x_2 = (abs(x) if True else nan)\n"
    )


def test_an_empty_body_is_seen() -> None:
    assert listing(program(Function("f", (), ()))) == "def f():\n    pass\n"


def test_long_expressions_are_broken() -> None:
    x = Value(FLOAT, "a_rather_long_name")
    w = Writer("f", x, results=(FLOAT,))
    value = x
    for _ in range(10):
        value = w.do("add", value, x, name="sum")
    w.leave(value)
    assert max(map(len, listing(program(w.function)).splitlines())) < 120


def test_a_loop_without_statements_in_its_test_has_one_line() -> None:
    x = Value(TRUTH, "x")
    w = Writer("f", x)
    with w.loop([], x):
        w.stop()
    assert listing(program(w.function)) == "def f(x: bool):\n    while x:\n        break\n"
