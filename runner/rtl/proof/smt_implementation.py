"""A Verilog module as SMT-LIB definitions, as Yosys reads the text, with registers and inputs as constants.

Yosys writes functions of a state, `(define-fun |m#3| ((state |m_s|)) (_ BitVec 8) ...)`, and one
relation between a state and the next. Here the state is left out: `|m#3|` is a term, a register's
present value is a constant, and its next value is the term that the relation equates with it.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.rtl.tools.yosys import run_yosys

_DECLARED = re.compile(r"\(declare-fun (\|[^|]+\|) \(\|[^|]+\|\) (.+)\)(?: ;.*)?$")
_DEFINED = re.compile(r"\(define-fun (\|[^|]+\|) \(\(state \|[^|]+\|\)\) (Bool|\(_ BitVec \d+\)) (.+)\)(?: ;.*)?$")
_NEXT = re.compile(r"\(= (.+) \((\|[^|]+\|) next_state\)\)(?: ;.*)?$")
_OF_STATE = re.compile(r"\((\|[^|]+\|) state\)")
_ROLE = re.compile(r"; yosys-smt2-(input|output|register|wire) (.+) (\d+)$")
_CLOCKED_OTHERWISE = " ".join(
    (
        "t:$dff i:clock %a %co1:+$dff[CLK] %d",  # registers that the clock does not move
        "t:$dff r:CLK_POLARITY<1 %i %u",  # or its falling edge
        "%co1:+$dff[Q] w:* %i",  # by the names of their results
    )
)


@dataclass(frozen=True)
class Implementation:
    """Definitions of a module; terms are unsigned words as wide as ports and registers."""

    lines: tuple[str, ...]
    widths: Mapping[str, int]  # of inputs, outputs, registers and wires, by Verilog name
    terms: Mapping[str, str]  # their values
    words: tuple[str, ...]  # names of all words that are computed
    following: Mapping[str, str]  # the next values of registers, at the clock
    moves: Mapping[str, str]  # the same by the constants that registers are


def read_implementation(verilog: str, top: str) -> Implementation:
    """The module `top` of a Verilog text, flat."""
    with TemporaryDirectory() as folder:
        (Path(folder) / "module.v").write_text(verilog)
        commands = ["read_verilog module.v", f"hierarchy -check -top {top}", "proc", "flatten"]
        commands += [f"tee -q -o otherwise.txt select -list {_CLOCKED_OTHERWISE}", "write_smt2 -wires module.smt2"]
        run_yosys(Path(folder), commands)
        otherwise = (Path(folder) / "otherwise.txt").read_text().split()
        if otherwise:
            message, expected = "registers of another clock", "the rising edge of clock moves every register"
            raise Problem(message=message, key=top, got=", ".join(otherwise), expected=expected).error
        return _read((Path(folder) / "module.smt2").read_text(), top)


def _read(text: str, top: str) -> Implementation:
    lines, bodies, relation = list[str](), dict[str, str](), dict[str, str]()
    widths, registers = dict[str, int](), set[str]()
    for line in text.splitlines():
        if role := _ROLE.match(line):
            widths[role[2]] = int(role[3])
            if role[1] == "register":
                registers.add(role[2])
        elif declared := _DECLARED.match(line):
            if not declared[1].endswith("_is|"):
                lines.append(f"(declare-const {declared[1]} {declared[2]})")
        elif defined := _DEFINED.match(line):
            body = _OF_STATE.sub(r"\1", defined[3])
            bodies[defined[1]] = body
            lines.append(f"(define-fun {defined[1]} () {defined[2]} {body})")
        elif following := _NEXT.search(line):
            relation[following[2]] = _OF_STATE.sub(r"\1", following[1])
    names = {name: f"|{top}_n {name}|" for name in widths}
    return Implementation(
        tuple(lines),
        widths,
        {name: _word(term, widths[name]) for name, term in names.items()},
        tuple(bodies),
        {name: _word(_moved(bodies[names[name]], relation), widths[name]) for name in registers},
        relation,
    )


def _word(term: str, width: int) -> str:
    """A wire of one bit is a Boolean in Yosys' text."""
    return f"(ite {term} #b1 #b0)" if width == 1 else term


def _moved(body: str, relation: Mapping[str, str]) -> str:
    """Next value of a register."""
    return re.sub(r"\|[^|]+\|", lambda found: relation[found[0]], body)
