"""Functions as users write them: constructs that are compiled, and some that are refused."""

import enum
import math
from typing import NamedTuple

TABLE = (1.5, -2.0, 4.0)


class Pair(NamedTuple):
    """A record."""

    first: int
    second: float


class Level(enum.IntEnum):
    """Levels with numbers."""

    LOW = 1
    HIGH = 3


ORIGIN = Pair(2, 0.25)


def declared(a: float, b: float) -> float:
    c: float = 2
    d: float
    d = c * a
    return d - b


def signs(a: float, b: float) -> float:
    return +a - -b + float(-(a > b)) + float(+(a > b))


def counted(a: float, b: float) -> int:
    return a > b


def of_record(a: float, b: float) -> float:
    return a * ORIGIN.second + b * ORIGIN.first


def of_tuple(a: float, b: float) -> float:
    return a * TABLE[-1] + b * TABLE[1] + (a, b)[-2]


def both_turned(a: float, b: float) -> float:
    total = 0
    for one, other in zip(TABLE, (a, b, a)):  # noqa: B905
        if one < 0.0:
            continue
        total = total + one * other
    total = 0 if total > 100.0 else total
    return total


def reset(a: float, b: float) -> float:
    total = 0
    if a > b:  # noqa: SIM108
        total = total + 0.5
    else:
        total = 1
    return total


def cut(a: float, b: float) -> float:
    level = 2.0 * a
    if level > b:
        level = 1
    return level


def in_steps(a: float, b: float) -> float:
    total = 0.0
    for number in range(4):
        total = 10.0 * total + number * a
    for number in range(2, 5):
        total = 10.0 * total + number * b
    for number in range(7, 1, -3):
        total = 10.0 * total + number
    for number in range(int(a), int(b) + 2):
        total = 10.0 * total + number
    return total


def counted_back(a: float, b: float) -> float:
    return (a, b)[-int(b > a)]


def every_way(a: float, b: float) -> float:
    if a > b:
        return a
    else:
        return b


def levelled(a: float, b: float) -> float:
    return a * Level.HIGH + b * Level.LOW


def searched(a: float, b: float) -> float:
    for one in TABLE:
        if one > a:
            break
    else:
        return b
    return one


def applied_to(function, a: float):  # type: ignore[no-untyped-def]
    return function(a)


def handed_on(a: float, b: float) -> float:
    return applied_to(math.floor, a) + applied_to(math.fabs, b)


def left_out(a: float, b: float) -> float:
    total = 0.0
    for one in TABLE:
        if one > a:
            continue
        else:
            part = one * b
        total = total + part
    return total


def left_early(a: float, b: float) -> float:
    total = 0.0
    for one in TABLE:
        if one < a:
            break
        else:
            part = one * b
        total = total + part
    return total


def refused_number(a: float) -> float:
    if a < 0.0:
        raise ValueError("below zero")
    return a


def refused_count(a: float) -> int:
    if a < 0.0:
        raise ValueError("below zero")
    return 1


def refused_truth(a: float) -> bool:
    if a < 0.0:
        raise ValueError("below zero")
    return a > 1.0


def refused_pair(a: float) -> Pair:
    assert a >= 0.0, "below zero"
    return Pair(1, a)


def refused_tuple(a: float) -> tuple[float, int]:
    assert a >= 0.0, "below zero"
    return a, 2


def only_looks(a: float) -> None:
    if a < 0.0:
        raise ValueError("below zero")


class Labelled(NamedTuple):
    """A record with a text."""

    label: str
    level: float


LABELLED = Labelled("label", 1.0)


def of_a_label(a: float) -> float:
    return a * LABELLED.level


def always(a: float):  # type: ignore[no-untyped-def]
    raise ValueError(f"never {a}")


class Named:
    """A class with a member that is no number."""

    text = "words"


def of_a_class(a: float) -> float:
    return Named.text  # type: ignore[return-value]


def starred(a: float) -> float:
    return max(*TABLE)


def of_a_module(a: float) -> float:
    return (math, a)[1]


def below_a_text(a: float) -> float:
    return -"text"  # type: ignore[operator, no-any-return]


def at_a_half(a: float) -> float:
    return TABLE[0.5]  # type: ignore[call-overload, no-any-return]


def perhaps(a: float) -> float:
    if a > 0.0:
        text = f"{a}"
    return text  # type: ignore[return-value]


def of_what_was_refused(a: float) -> float:
    text = f"{a}"
    return text if a > 0.0 else 1.0  # type: ignore[return-value]


def grown(a: Pair) -> float:
    a.second += 1.0  # type: ignore[misc]
    return 1.0


def put(a: float) -> float:
    TABLE[0] = 1.0  # type: ignore[index]
    return a


COMPILED = [
    *(
        declared,
        signs,
        counted,
        cut,
        counted_back,
        in_steps,
        of_record,
        of_tuple,
        both_turned,
        left_out,
        left_early,
        reset,
        every_way,
        levelled,
        searched,
        handed_on,
    ),
]
RAISING = [refused_number, refused_count, refused_truth, refused_pair, refused_tuple, only_looks]
