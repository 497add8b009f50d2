"""A claim of a paper: a row of docs/papers/claims.md, with the function that finds ours by running graphs."""

from collections.abc import Callable
from typing import Literal, NamedTuple

Verdict = Literal["holds", "differs", "fails", "open"]
VERDICTS: dict[Verdict, str] = {
    "holds": "ours is the paper's figure, or what it says is so",
    "differs": "ours is another figure, for a reason that is given",
    "fails": "what it says is not so, or does not follow from its own numbers",
    "open": "cannot be reproduced, for a reason that is given",
}


class Claim(NamedTuple):
    """What a paper says, where, what is found here, and why that differs."""

    name: str  # of the row, for the command
    place: str  # section, equation, table or figure
    claim: str
    paper: str  # its figure, as printed
    verdict: Verdict
    why: str  # they differ, or it cannot be reproduced; empty where they agree
    graph: str = ""  # of the library, or the module that holds more
    ours: Callable[[], str] | None = None  # None where nothing can be run
    slow: bool = False  # more than a fraction of a second
