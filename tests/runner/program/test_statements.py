"""Statements of generated source, with what they read and write."""

from proofmass.runner.program.statements import statements


def test_reads_and_writes_of_numbers() -> None:
    first, second = statements(["y = f(x, 1.0)", "y += z.field"])
    assert (first.reads, first.writes) == ({"f", "x"}, {"y"})
    assert (second.reads, second.writes) == ({"y", "z"}, {"y"})
    assert first.straight
    assert first.surely
    assert second.straight


def test_a_rate_guards_each_of_its_statements() -> None:
    made = statements(["if tick % 4 == 0:", "    a = 1", "    b = a", "c = b"])
    assert [(s.guard, s.lines) for s in made] == [
        ("tick % 4 == 0", ("a = 1",)),
        ("tick % 4 == 0", ("b = a",)),
        ("", ("c = b",)),
    ]


def test_a_function_may_change_the_arrays_that_it_is_given() -> None:
    call, read, write = statements(["f(a, x)", "y = a[0]", "a[1] = x"], {"a"})
    assert "a" in call.writes
    assert "a" not in read.writes
    assert "a" in write.writes
    assert not (call.straight)
    assert not (read.straight)
    assert not write.straight


def test_what_a_branch_writes_is_not_sure() -> None:
    (branch,) = statements(["if x > 0.0:", "    y = 1.0"])
    assert branch.writes == {"y"}
    assert not branch.surely
    assert not branch.straight
