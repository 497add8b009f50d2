"""A program as a WebAssembly module, made without a linker, which computes the bits of machine code.

LLVM's object file for wasm32 is a module already, but for an export: one is put in. The module
imports its memory, and the functions of libm that the program calls, since there are none in a
browser; a program without them computes the same bits everywhere.
"""

from collections.abc import Iterator
from typing import NamedTuple

import llvmlite.binding as llvm

from proofmass.runner.program.form import Program
from proofmass.runner.targets.llvm_functions import externals
from proofmass.runner.targets.llvm_operations import PORTABLE
from proofmass.runner.targets.llvm_text import ENTRY, llvm_text
from proofmass.runner.targets.machine_code import ALONE, optimise

_TRIPLE = "wasm32-unknown-unknown"
_FEATURES = "+bulk-memory,+nontrapping-fptoint,+sign-ext"
_CUSTOM, _EXPORTS, _ELEMENTS, _CODE, _DATA, _DATA_COUNT = 0, 7, 9, 10, 11, 12  # sections
_BEHIND_EXPORTS = (_ELEMENTS, _DATA_COUNT, _CODE, _DATA)


class WasmModule(NamedTuple):
    """A module whose function `ENTRY` is the program's entry; addresses are integers of 32 bits."""

    code: bytes
    libm: tuple[str, ...]  # functions that whoever loads the module brings, from `env`
    constants: int  # bytes at the beginning of memory that are the module's own


def wasm_module(program: Program) -> WasmModule:
    """The program as a module."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(_TRIPLE).create_target_machine(features=_FEATURES, opt=3)
    module = llvm.parse_assembly(llvm_text(program, _TRIPLE, str(machine.target_data), PORTABLE))
    optimise(module, machine, ALONE)
    return _exported(bytes(machine.emit_object(module)), tuple(sorted(externals(program))))


def _exported(code: bytes, libm: tuple[str, ...]) -> WasmModule:
    """The object file with its entry as an export, without what only linkers read."""
    before, behind, constants = bytearray(code[:8]), bytearray(), 0
    for kind, whole, body in _sections(code):
        if kind == _CUSTOM:
            continue
        if kind == _DATA:
            constants = _end_of_data(body)
        (behind if kind in _BEHIND_EXPORTS else before).extend(whole)
    name = ENTRY.encode()
    export = b"\x01" + _leb(len(name)) + name + b"\x00" + _leb(_names(code)[ENTRY])
    return WasmModule(bytes(before) + bytes([_EXPORTS]) + _leb(len(export)) + export + bytes(behind), libm, constants)


def _sections(code: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    """Kind of each section, all of it, and what is in it."""
    at = 8  # behind the magic number and the version
    while at < len(code):
        length, begin = _unsigned(code, at + 1)
        yield code[at], code[at : begin + length], code[begin : begin + length]
        at = begin + length


def _names(code: bytes) -> dict[str, int]:
    """Numbers of functions by the names that the section for linkers has of them."""
    names: dict[str, int] = {}
    for kind, _, body in _sections(code):
        if kind != _CUSTOM:
            continue
        length, at = _unsigned(body, 0)
        if body[at : at + length] == b"linking":
            names |= _symbols(body, at + length)
    return names


def _symbols(body: bytes, at: int) -> dict[str, int]:
    """Functions of a symbol table that are defined in the module."""
    symbols: dict[str, int] = {}
    _, at = _unsigned(body, at)  # the version
    while at < len(body):
        kind, at = body[at], at + 1
        length, at = _unsigned(body, at)
        if kind == 8:  # the symbol table
            count, entry = _unsigned(body, at)
            for _ in range(count):
                symbol, entry = _symbol(body, entry)
                symbols |= symbol
        at += length
    return symbols


def _symbol(body: bytes, at: int) -> tuple[dict[str, int], int]:
    """A symbol, if it is a function that is defined here, and where the next one begins."""
    kind, at = body[at], at + 1
    flags, at = _unsigned(body, at)
    undefined, named = flags & 0x10, flags & 0x40
    if kind == 1:  # data
        length, at = _unsigned(body, at)
        at += length
        for _ in range(0 if undefined else 3):  # segment, offset, size
            _, at = _unsigned(body, at)
        return {}, at
    index, at = _unsigned(body, at)
    if kind == 3 or (undefined and not named):  # a section, or an import under its own name
        return {}, at
    length, at = _unsigned(body, at)
    name = body[at : at + length].decode()
    return ({name: index} if kind == 0 and not undefined else {}), at + length


def _end_of_data(body: bytes) -> int:
    """Return the end of the last segment of constants in memory."""
    count, at = _unsigned(body, 0)
    end = 0
    for _ in range(count):
        flags, at = _unsigned(body, at)
        assert (flags, body[at]) == (0, 0x41), "a segment stands at a fixed address"
        begin, at = _unsigned(body, at + 1)
        length, at = _unsigned(body, at + 1)  # behind the end of the expression
        at, end = at + length, max(end, begin + length)
    return end


def _unsigned(data: bytes, at: int) -> tuple[int, int]:
    """A number of variable length, and where it ends."""
    value = shift = 0
    while True:
        value |= (data[at] & 0x7F) << shift
        at += 1
        shift += 7
        if not data[at - 1] & 0x80:
            return value, at


def _leb(value: int) -> bytes:
    """A number of variable length."""
    out = bytearray()
    while True:
        value, low = value >> 7, value & 0x7F
        out.append(low | (0x80 if value else 0))
        if not value:
            return bytes(out)
