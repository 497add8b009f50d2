"""The Verilog as a compiled model: CXXRTL, which Yosys writes in C++, built by the C++ compiler of the machine.

A model is a shared library, kept by the hash of its source in the folder of compiled loops. It takes and gives 64-bit
integers, one for each port or register, whole vectors of clocks in one call.
"""

import ctypes
import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from proofmass.blocks.problem import ModelError, Problem
from proofmass.runner.engine.cache import keep, kept
from proofmass.runner.rtl.extra import need
from proofmass.runner.rtl.reference import Reference
from proofmass.runner.rtl.words import Port, Word
from proofmass.runner.rtl.yosys import run_yosys

Column = NDArray[np.int64]

_PURPOSE = "compiled models of Verilog"
_FLAGS = ("-O2", "-std=c++17", "-shared", "-fPIC")


def compiler() -> str | None:
    """The C++ compiler: what `CXX` names, or g++, or clang++."""
    return shutil.which(os.environ.get("CXX", "")) or shutil.which("g++") or shutil.which("clang++")


class Model:
    """A module of a Verilog text, made ready to run; it starts as after a reset.

    `ports` are those of the module: a reference says which it has, and which registers.
    """

    def __init__(self, reference: Reference, verilog: str) -> None:
        self.inputs, self.outputs, self.registers = reference.inputs, reference.outputs, reference.registers
        words = {each.name: each.word for each in (*reference.held, *self.outputs)}
        wide = [name for name, word in words.items() if word.width > 64]
        if wide:
            message = "the model takes and gives numbers of at most 64 bits"
            raise ModelError([Problem(message=message, key=reference.name, got=", ".join(wide))])
        self._library = _loaded(_code(reference, verilog))
        self._library.model_new.restype = ctypes.c_void_p
        self._model = ctypes.c_void_p(self._library.model_new())

    def __del__(self) -> None:
        if hasattr(self, "_model"):
            self._library.model_delete(self._model)

    def run(self, inputs: Mapping[str, Any], clocks: int) -> dict[str, Column]:
        """Outputs in so many clocks with enable, one after the other, by the names of the ports."""
        given = [np.ascontiguousarray(inputs[port.name][:clocks], dtype=np.int64) for port in self.inputs]
        found = {port.name: np.empty(clocks, np.int64) for port in self.outputs}
        self._library.model_run(self._model, ctypes.c_int64(clocks), _addresses(given), _addresses(found.values()))
        return found

    def settled(self, inputs: Sequence[int]) -> list[int]:
        """Outputs for inputs, before the clock; both in the order of the ports."""
        given = (ctypes.c_int64 * len(inputs))(*inputs)
        found = (ctypes.c_int64 * len(self.outputs))()
        self._library.model_settle(self._model, given, found)
        return list(found)

    def clock(self) -> None:
        """One clock with enable, on the inputs given last."""
        self._library.model_clock(self._model)

    @property
    def held(self) -> list[int]:
        """What the registers hold, in their order."""
        found = (ctypes.c_int64 * len(self.registers))()
        self._library.model_read(self._model, found)
        return list(found)

    @held.setter
    def held(self, values: Sequence[int]) -> None:
        self._library.model_write(self._model, (ctypes.c_int64 * len(values))(*values))


def _addresses(arrays: Any) -> Any:
    pointers = [array.ctypes.data for array in arrays]
    return (ctypes.c_void_p * len(pointers))(*pointers)


def _loaded(code: bytes) -> ctypes.CDLL:
    with NamedTemporaryFile(suffix=".so") as file:
        file.write(code)
        file.flush()
        return ctypes.CDLL(file.name)


def _code(reference: Reference, verilog: str) -> bytes:
    """The shared library, made where it is not there yet."""
    need("pyosys", _PURPOSE)
    found = compiler()
    if found is None:
        hint = "install g++ or clang++, or name one in CXX"
        raise ModelError([Problem(message=f"there is no C++ compiler: it makes {_PURPOSE}", hint=hint)])
    wrapper = "\n".join(_wrapper(reference)) + "\n"
    parts = [verilog, wrapper, version("pyosys"), found, *_FLAGS]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    code = kept(f"{key}.so")
    if code is None:
        code = _built(reference, verilog, wrapper, found)
        keep(f"{key}.so", code)
    return code


def _built(reference: Reference, verilog: str, wrapper: str, compiler: str) -> bytes:
    import pyosys

    runtime = Path(pyosys.__file__).parent / "share" / "include" / "backends" / "cxxrtl" / "runtime"
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "module.v").write_text(verilog)
        (folder / "model.cc").write_text(wrapper)
        commands = ["read_verilog module.v", f"hierarchy -check -top {reference.name}"]
        run_yosys(folder, [*commands, "write_cxxrtl -O6 -g0 module.cc"])
        arguments = [compiler, *_FLAGS, f"-I{runtime}", "model.cc", "-o", "model.so"]
        ended = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)
        if ended.returncode:
            errors = [line for line in ended.stderr.splitlines() if "error" in line]
            got = errors[0] if errors else ended.stderr[-200:]
            raise ModelError([Problem(message="the C++ compiler refuses the model", key=reference.name, got=got)])
        return (folder / "model.so").read_bytes()


def _wrapper(reference: Reference) -> Iterator[str]:
    """C functions around the class that Yosys writes."""
    bits = [*(("clock", "enable", "reset") if reference.clocked else ())]
    yield '#include "module.cc"'
    yield f"typedef cxxrtl_design::{_member(reference.name)} model;"
    yield "static int64_t signed_of(uint64_t bits, int width) {"
    yield "    return (int64_t)(bits << (64 - width)) >> (64 - width);"
    yield "}"
    yield "static void rise(model *m) {"
    yield from ("    m->p_clock.set<bool>(true); m->step(); m->p_clock.set<bool>(false); m->step();",) * bool(bits)
    yield "}"
    yield 'extern "C" {'
    yield "model *model_new() {"
    yield "    model *m = new model;"
    if bits:
        yield "    m->p_enable.set<bool>(true); m->p_reset.set<bool>(true); m->p_clock.set<bool>(false); m->step();"
        yield "    rise(m); m->p_reset.set<bool>(false); m->step();"
    yield "    return m;"
    yield "}"
    yield "void model_delete(model *m) { delete m; }"
    yield "void model_settle(model *m, const int64_t *in, int64_t *out) {"
    yield from (f"    {_put(port, f'in[{i}]')}" for i, port in enumerate(reference.inputs))
    yield "    m->step();"
    yield from (f"    out[{i}] = {_got(_member(port.name), port.word)};" for i, port in enumerate(reference.outputs))
    yield "}"
    yield "void model_clock(model *m) { rise(m); }"
    yield "void model_run(model *m, int64_t clocks, const int64_t *const *in, int64_t *const *out) {"
    yield "    for (int64_t t = 0; t < clocks; t++) {"
    yield from (f"        {_put(port, f'in[{i}][t]')}" for i, port in enumerate(reference.inputs))
    yield from ("        m->p_clock.set<bool>(false);",) * bool(bits)
    yield "        m->step();"
    yield from (
        f"        out[{i}][t] = {_got(_member(port.name), port.word)};" for i, port in enumerate(reference.outputs)
    )
    yield from ("        m->p_clock.set<bool>(true); m->step();",) * bool(bits)
    yield "    }"
    yield "}"
    yield "void model_read(model *m, int64_t *held) {"
    registers = list(enumerate(reference.registers))
    yield from (f"    held[{i}] = {_got(f'{_member(each.name)}.curr', each.word)};" for i, each in registers)
    yield "}"
    yield "void model_write(model *m, const int64_t *held) {"
    for i, each in registers:
        name = f"m->{_member(each.name)}"
        yield f"    {name}.curr.set<uint64_t>({_bits(each.word, f'held[{i}]')}); {name}.next = {name}.curr;"
    yield "}"
    yield "}"


def _put(port: Port, value: str) -> str:
    return f"m->{_member(port.name)}.set<uint64_t>({_bits(port.word, value)});"


def _bits(word: Word, value: str) -> str:
    return f"(uint64_t){value} & {(1 << word.width) - 1:#x}ull"


def _got(member: str, word: Word) -> str:
    bits = f"m->{member}.get<uint64_t>()"
    return f"signed_of({bits}, {word.width})" if word.signed else f"(int64_t){bits}"


def _member(name: str) -> str:
    """How CXXRTL calls a name.

    >>> _member("cell_.total")
    'p_cell___2e_total'
    """
    return "p_" + "".join("__" if c == "_" else c if c.isalnum() else f"_{ord(c):x}_" for c in name)
