"""Certificates of fixed point: what the checker says of them, forged ones, and any number changed.

What is taken of a changed certificate is true by partial sums of responses, in exact numbers that are written anew.
"""

import ast
import json
import random
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from math import ceil, floor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.verification import digital_checker
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.integer_sections import Section
from tests.runner.design.proof.test_digital_graphs import about, delays
from tests.runner.design.proof.test_digital_soundness import random_loop
from tests.runner.verification.test_certificates import forged

TIMES = 60  # periods of the partial sums


@cache
def section(a1: int, a2: int, bits: int, rounding: str = "", most: int = 1) -> Proofs:
    graph = replace(Section(64, a1, a2, 6, 7, "half_up"), bits=bits).graph()
    return prove(
        graph, no_overflow=True, rounding={"filter.output": rounding}, input_ranges={"input.output": [-most, most]}
    )


def loop() -> Proofs:
    graph = random_loop(random.Random(3))
    return prove(graph, no_overflow=True, rounding={"gain.output": ""}, input_ranges={"source.output": [-1, 1]})


GRAPHS: dict[str, Callable[[], Proofs]] = {
    "first order": lambda: section(-58, 0, 12),
    "second order": lambda: section(-110, 61, 14),
    "loop at two rates": loop,
    "delays": lambda: about(delays(0.75, 3), no_overflow=True, rounding={"sum.output": ""}),
}


@pytest.fixture(scope="module", params=GRAPHS)
def proved(request: pytest.FixtureRequest) -> str:
    found = GRAPHS[request.param]()
    assert found.proved
    return certificate(found)


def changed(text: str, number: int = 1, **values: Any) -> str:
    """A certificate with other values in one claim, and a hash that is right."""
    return forged(text, lambda c: c["digital"][number].update(values))


@pytest.mark.parametrize(("factor", "constant", "most"), [(1, 0, 2.0), (3, 1, 7.0)])
def test_what_a_register_reaches_counts_whatever_its_factor(factor: int, constant: int, most: float) -> None:
    """x' = x / 2 + u with |u| <= 1 comes as near to 2 as one likes."""

    def numbers(*row: float) -> Any:
        return np.array([[Fraction(value) for value in row]], dtype=object)

    system = numbers(factor, 0, constant), numbers(0.5, 1, 0), numbers(0)[0], [(Fraction(-1), Fraction(1))]
    assert digital_checker._all_within(lambda _, low, high: high <= most + 0.01, *system)
    assert not digital_checker._all_within(lambda _, low, high: high <= most - 0.01, *system)


def test_what_the_checker_says_and_how_near_it_is() -> None:
    """An error of half a step moves y = x + 29 / 32 y by at most 0.5 / (1 - 29 / 32) = 16 / 3."""
    text, enters = certificate(section(-58, 0, 12)), "quantiser.output from -1 to 1 steps"
    assert check_certificate(text) == [
        f"no overflow, {enters}",
        f"rounding error of filter.output of at most 5.334, {enters}",
    ]
    assert check_certificate(changed(text, limit=16 / 3 + 1e-14))
    for limit in (16 / 3, 5.0, 0.0, -1.0):
        with pytest.raises(FalseCertificateError, match="not shown"):
            check_certificate(changed(text, limit=limit))


def test_ranges_end_where_inputs_and_errors_bring_a_number() -> None:
    """Of inputs up to 186 and errors from -15 / 32 to 1 / 2: from -(186 + 15 / 32) 32 / 3 = -1989 to 1989 + 1 / 3."""
    text = certificate(section(-58, 0, 12, most=186))
    ranges = json.loads(text)["digital"][0]["ranges"]
    assert {*map(tuple, ranges)} == {(-2048, 2047)}
    assert check_certificate(changed(text, 0, ranges=[[-1989, 1989] for _ in ranges]))
    for ends in ([-1988, 1989], [-1989, 1988]):
        with pytest.raises(FalseCertificateError, match="not shown"):
            check_certificate(changed(text, 0, ranges=[ends for _ in ranges]))


FORGERIES: dict[str, Callable[[dict[str, Any]], None]] = {
    "grows": lambda c: c["following"][0].update({"register 0": "2"}),
    "counts on": lambda c: c["following"][0].update({"register 0": "1"}),
    "more comes in": lambda c: c["inputs"][0].update(ends=[-2000, 2000]),
    "ends change places": lambda c: c["errors"][0].reverse(),
    "larger errors": lambda c: c["errors"].__setitem__(0, ["-1000", "1000"]),
    "a smaller limit": lambda c: c.update(limit=0.5),
    "larger steps": lambda c: c.update(step="2"),
    "steps below zero": lambda c: c.update(step="-1"),
    "no output": lambda c: c.update(outputs=[]),
    "an unknown symbol": lambda c: c["outputs"][0].update({"register 7": "0"}),
    "another kind": lambda c: c.update(kind="limit cycle"),
    "fewer registers": lambda c: c["following"].pop(),
    "more ranges": lambda c: c["ranges"].append([0, 0]),
    "numbers that are not exact": lambda c: c["outputs"][0].update({"": 0.5}),
    "digits without end": lambda c: c["outputs"][0].update({"": "9" * 5000}),
    "exponents": lambda c: c["start"].__setitem__(0, "1e999999999"),
    "division by zero": lambda c: c["start"].__setitem__(0, "1/0"),
    "inputs without ends": lambda c: c["inputs"][0].update(ends=[None, None]),
    "no input there": lambda c: c["entering"].__setitem__(0, 5),
    "no number": lambda c: c.update(limit=None),
}  # fmt: skip


@pytest.mark.parametrize("way", FORGERIES)
def test_a_forged_certificate_is_refused_soon(way: str) -> None:
    text, begin = certificate(section(-110, 61, 14)), time.process_time()
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(text, lambda c: FORGERIES[way](c["digital"][1])))
    assert time.process_time() - begin < 10.0


def test_every_proof_of_random_loops_is_shown() -> None:
    for seed in range(5, 11):
        rng = random.Random(seed)
        graph, most = random_loop(rng), rng.choice([0.5, 1.0])
        found = prove(
            graph, no_overflow=True, rounding={"gain.output": ""}, input_ranges={"source.output": [-most, most]}
        )
        proofs = [proof for proof in found.digital if proof.status == "proved"]
        assert len(check_certificate(certificate(found))) == len(proofs) > 0


class Claim:
    """A claim of a certificate, and how far its numbers get by partial sums of exact responses."""

    def __init__(self, of: dict[str, Any]) -> None:
        self.of, entering = of, [of["inputs"][place]["ends"] for place in of["entering"]]
        self.symbols = {f"input {i}": self._pair(ends) for i, ends in enumerate(entering)}
        self.symbols |= {f"error {i}": self._pair(ends) for i, ends in enumerate(of["errors"])}
        self.start = {f"register {i}": Fraction(value) for i, value in enumerate(of["start"])}
        self.after = {f"register {i}": self._form(form) for i, form in enumerate(of["following"])}

    @staticmethod
    def _pair(ends: Any) -> tuple[Fraction, Fraction]:
        return Fraction(ends[0]), Fraction(ends[1])

    @staticmethod
    def _form(form: dict[str, Any]) -> dict[str, Fraction]:
        return {name: Fraction(value) for name, value in form.items()}

    def reaches(self, form: dict[str, Any], errors_alone: bool) -> tuple[Fraction, Fraction]:
        """Return the least and the most of a form within some periods, its registers written out by those before."""
        now, low, high, ends = self._form(form), Fraction(0), Fraction(0), list[tuple[Fraction, Fraction]]()
        for _ in range(TIMES):
            constant = Fraction(0) if errors_alone else now.pop("", Fraction(0))
            low, high = low + constant, high + constant
            for name, (least, most) in self.symbols.items():
                if not (errors_alone and name.startswith("input")):
                    sides = [now.get(name, Fraction(0)) * end for end in (least, most)]
                    low, high = low + min(sides), high + max(sides)
            registers = {name: factor for name, factor in now.items() if name in self.after}
            begin = Fraction(0) if errors_alone else sum((self.start[n] * f for n, f in registers.items()), Fraction(0))
            ends.append((low + begin, high + begin))
            now = {}
            for register, factor in registers.items():
                for name, of_it in self.after[register].items():
                    now[name] = now.get(name, Fraction(0)) + factor * of_it
        return min(one for one, _ in ends), max(one for _, one in ends)

    def assert_true(self) -> None:
        for form, (least, most) in zip(self.of["conditions"], self.of["ranges"], strict=True):
            low, high = self.reaches(form, errors_alone=False)
            assert least is None or ceil(low) >= least
            assert most is None or floor(high) <= most
        if self.of["kind"] == "rounding error":
            for form in self.of["outputs"]:
                low, high = self.reaches(form, errors_alone=True)
                assert max(-low, high) * Fraction(self.of["step"]) <= Fraction(self.of["limit"])


def test_partial_sums_come_near_to_what_is_proved() -> None:
    """Else they show nothing. Of y = x + 29 / 32 y, errors add up to 16 / 3 (1 - (29 / 32)^60), which is 5.319."""
    _, claim = json.loads(certificate(section(-58, 0, 12)))["digital"]
    assert max(Claim(claim).reaches(claim["outputs"][0], errors_alone=True)) == pytest.approx(
        16 / 3 * (1 - (29 / 32) ** TIMES)
    )


def another(value: Any, draw: random.Random) -> Any:
    if isinstance(value, str):
        top, _, parts = value.partition("/")
        tops = (0, -int(top), int(top) + 1, int(top) - 1, 2 * int(top))
        return f"{draw.choice(tops)}/{draw.choice([parts or '1', str(2 * int(parts or 1)), '3'])}"
    near = value + 1 if isinstance(value, int) else value * (1.0 + 1e-9)
    return draw.choice(
        [0, -value, near, value - 1, 2 * value, value * 4, value // 2 if isinstance(value, int) else value / 2]
    )


def places(tree: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The places of all numbers of a claim."""
    if isinstance(tree, dict | list):
        parts = sorted(tree.items()) if isinstance(tree, dict) else enumerate(tree)
        return [place for key, part in parts for place in places(part, (*at, key))]
    return [at] if tree is not None and at[0] != "kind" and at[-1] not in ("signal", "output", "unit") else []


@pytest.mark.exhaustive("loop at two rates")
@pytest.mark.parametrize("seed", chosen([0], range(1, 40)))
def test_what_is_taken_of_a_changed_certificate_is_true(proved: str, seed: int) -> None:
    draw, taken = random.Random(seed), 0
    claims = json.loads(proved)["digital"]
    for _ in range(12):
        claim = json.loads(json.dumps(draw.choice(claims)))
        for place in draw.sample(places(claim), draw.choice((1, 1, 2, 3))):
            part = claim
            for key in place[:-1]:
                part = part[key]
            part[place[-1]] = another(part[place[-1]], draw)
        try:
            check_certificate(forged(proved, lambda c, claim=claim: c.update(digital=[claim])))
        except FalseCertificateError:
            continue
        taken += 1
        Claim(claim).assert_true()
    assert seed or taken


def test_the_checker_shares_no_code_and_is_short() -> None:
    text = Path(digital_checker.__file__).read_text(encoding="utf-8")
    tree = ast.walk(ast.parse(text))
    names = {alias.name for node in tree if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)}
    assert names == {"collections.abc", "fractions", "math", "numpy", "typing"}
    assert len(text.splitlines()) <= 300
