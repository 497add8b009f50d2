"""Every claim of the three papers beside what is found here.

    python -m docs.papers.claims [NAME ...] [--quick | --write]

Names, or what they begin with, choose rows. `--quick` leaves out those that take more than a fraction of a second; all
of them take some minutes. `--write` runs all and writes the tables of docs/papers/claims.md.
"""

import argparse
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from docs.papers import pn_claims, quartz_claims, temperature_claims
from docs.papers.claim import VERDICTS, Claim

PAGE = Path(__file__).with_suffix(".md")
PAPERS: Mapping[str, tuple[Claim, ...]] = {  # headings of the page
    "Self-test and self-calibration": pn_claims.CLAIMS,
    "The quartz accelerometer": quartz_claims.CLAIMS,
    "Temperature compensation": temperature_claims.CLAIMS,
}
CLAIMS = tuple(claim for claims in PAPERS.values() for claim in claims)
HEAD = "| row | claim | in the paper | paper | here | verdict | why they differ, or what is assumed | graph |"


def table(claims: tuple[Claim, ...], found: Mapping[str, str]) -> str:
    """The rows of a paper as a table of the page."""
    rows = (
        f"| `{c.name}` | {c.claim} | {c.place} | {c.paper} | {found[c.name]} | {c.verdict} | {c.why} | {shown(c)} |"
        for c in claims
    )
    return "\n".join([HEAD, "|" + "---|" * (HEAD.count("|") - 1), *rows])


def shown(claim: Claim) -> str:
    """The graph of a row."""
    return f"`{claim.graph}`" if claim.graph else ""


def counts() -> str:
    """How many claims of each paper have which verdict."""
    lines = ["| paper | " + " | ".join(VERDICTS) + " |", "|---|" + "---:|" * len(VERDICTS)]
    for heading, claims in PAPERS.items():
        number = Counter(claim.verdict for claim in claims)
        lines.append(f"| {heading} | " + " | ".join(str(number[verdict]) for verdict in VERDICTS) + " |")
    return "\n".join(lines)


def rendered(page: str, found: Mapping[str, str]) -> str:
    """The page with its tables written anew."""
    tables = {"Counts": counts()} | {heading: table(claims, found) for heading, claims in PAPERS.items()}
    for heading, text in tables.items():
        pattern = rf"(<!-- {heading} -->\n\n)(?:\|.*\n)*"
        page, written = re.subn(pattern, lambda match: f"{match[1]}{text}\n", page)  # noqa: B023
        if written != 1:
            raise ValueError(f"docs/papers/claims.md has no place for the table <!-- {heading} -->")
    return page


def stated(page: str) -> dict[str, str]:
    """What the page states for each row."""
    return dict(re.findall(r"^\| `([\w.-]+)` \|(?:[^|]*\|){3} ([^|]*) \|", page, re.MULTILINE))


def ours(claim: Claim) -> str:
    """What graphs say of it."""
    return claim.ours() if claim.ours else "-"


def wanted(names: list[str], quick: bool) -> Iterator[Claim]:
    """The claims that names choose."""
    for claim in CLAIMS:
        if (not names or any(claim.name.startswith(name) for name in names)) and not (quick and claim.slow):
            yield claim


def main() -> None:
    """Print rows, or write the page."""
    parser = argparse.ArgumentParser(
        prog="python -m docs.papers.claims", description="Print claims of the papers beside what is found here."
    )
    parser.add_argument("names", nargs="*", metavar="NAME")
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument("--quick", action="store_true", help="leave out rows of more than a fraction of a second")
    mode.add_argument("--write", action="store_true", help="run all and write the tables of the page")
    arguments = parser.parse_args()
    chosen, found = list(wanted(arguments.names, arguments.quick)), {}
    if not chosen:
        parser.error(f"no row begins with {' or '.join(arguments.names)}; the page docs/papers/claims.md has all names")
    for claim in chosen:
        found[claim.name] = ours(claim)
        print(f"{claim.name}: {claim.claim} ({claim.place})\n  paper {claim.paper}\n  here  {found[claim.name]}")
        print(f"  {claim.verdict}{': ' + claim.why if claim.why else ''}\n", flush=True)
    if arguments.write:
        page = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(rendered(page, stated(page) | found), encoding="utf-8")


if __name__ == "__main__":
    main()
