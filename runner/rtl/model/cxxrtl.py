"""The Verilog as a compiled model: Yosys writes it in C++ (CXXRTL), and the C++ compiler of the
machine builds it.

A model is a shared library, cached by the hash of its source in the folder of compiled loops. It
exchanges 64-bit integers, one for each port or register: whole vectors of clocks in one call, or
clock by clock in a compiled loop.
"""

import ctypes
import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory
from typing import Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.host.arrays import Integers
from proofmass.runner.host.cache import keep, kept
from proofmass.runner.program.form import INTEGER, External
from proofmass.runner.rtl.machine.reference import Reference
from proofmass.runner.rtl.machine.words import VerilogPort, Word
from proofmass.runner.rtl.tools.yosys import run_yosys

_PURPOSE = "compiled models of Verilog"
_FLAGS = ("-O2", "-std=c++17", "-shared", "-fPIC")
_opened: dict[str, ctypes.CDLL] = {}  # by the hash of the source


def compiler() -> str | None:
    """The C++ compiler: what `CXX` names, or g++, or clang++."""
    return shutil.which(os.environ.get("CXX", "")) or shutil.which("g++") or shutil.which("clang++")


class VerilogModel:
    """A module of a Verilog text, made ready to run; it starts as after a reset.

    `ports` are those of the module: a reference says which it has, and which registers.
    """

    def __init__(self, reference: Reference, verilog: str) -> None:
        self._reference = reference
        words = {each.name: each.word for each in (*reference.held, *reference.outputs)}
        wide = [name for name, word in words.items() if word.width > 64]
        if wide:
            message = "the model takes and gives numbers of at most 64 bits"
            raise Problem(message=message, key=reference.name, got=", ".join(wide)).error
        self._key, self._library = _library(reference, verilog)
        self._library.model_new.restype = ctypes.c_void_p
        self.address: int = self._library.model_new()

    def __del__(self) -> None:
        if hasattr(self, "address"):
            self._library.model_delete(ctypes.c_void_p(self.address))

    def run(self, inputs: Mapping[str, Any], clocks: int) -> dict[str, Integers]:
        """Outputs in so many clocks with enable, one after the other, by the names of the ports."""
        ports = self._reference
        given = [np.ascontiguousarray(inputs[port.name][:clocks], dtype=np.int64) for port in ports.inputs]
        found = {port.name: np.empty(clocks, np.int64) for port in ports.outputs}
        model, length = ctypes.c_void_p(self.address), ctypes.c_int64(clocks)
        self._library.model_run(model, length, _addresses(given), _addresses(found.values()))
        return found

    def function(self, name: str) -> External:
        """A function that a compiled loop calls; it takes the address of the model first.

        `settle(inputs...)`, then `output(number)`; `clock(inputs...)` with enable, with or without
        `settle` before; `register(number)` and `set_register(number, value)`. Numbers count ports
        and registers in their order.
        """
        inputs = len(self._reference.inputs)
        taken = {"settle": inputs, "clock": inputs, "output": 1, "register": 1, "set_register": 2}[name]
        address = ctypes.cast(getattr(self._library, f"model_{name}"), ctypes.c_void_p).value or 0
        result = INTEGER if name in ("output", "register") else None
        return External(f"model_{name}_{self._key}", (INTEGER,) * (1 + taken), result, address, pure=False)


def _addresses(arrays: Any) -> Any:
    pointers = [array.ctypes.data for array in arrays]
    return (ctypes.c_void_p * len(pointers))(*pointers)


def _loaded(code: bytes) -> ctypes.CDLL:
    with NamedTemporaryFile(suffix=".so") as file:
        file.write(code)
        file.flush()
        return ctypes.CDLL(file.name)


def _library(reference: Reference, verilog: str) -> tuple[str, ctypes.CDLL]:
    """Return the shared library and its hash; build it if it is not in the cache."""
    need("pyosys", purpose=_PURPOSE)
    command = compiler()
    if command is None:
        hint = "install g++ or clang++, or name one in CXX"
        raise Problem(message=f"there is no C++ compiler: it makes {_PURPOSE}", hint=hint).error
    wrapper = "\n".join(_wrapper(reference)) + "\n"
    parts = [verilog, wrapper, version("pyosys"), command, *_FLAGS]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    if key not in _opened:
        code = kept(f"{key}.so")
        if code is None:
            code = _built(reference, verilog, wrapper, command)
            keep(f"{key}.so", code)
        _opened[key] = _loaded(code)
    return key, _opened[key]


def _built(reference: Reference, verilog: str, wrapper: str, compiler: str) -> bytes:
    # optional: `need` has said how to install it
    import pyosys

    runtime = Path(pyosys.__file__).parent / "share" / "include" / "backends" / "cxxrtl" / "runtime"
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "module.v").write_text(verilog)
        (folder / "model.cc").write_text(wrapper)
        commands = ["read_verilog module.v", f"hierarchy -check -top {reference.name}"]
        run_yosys(folder, [*commands, "write_cxxrtl -O6 -g0 module.cc"])
        once = "bool converged = true;" in (folder / "module.cc").read_text()
        assert once  # without combinational loops one evaluation settles everything, and `model_clock` does one
        arguments = [compiler, *_FLAGS, f"-I{runtime}", "model.cc", "-o", "model.so"]
        ended = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)
        if ended.returncode:
            errors = [line for line in ended.stderr.splitlines() if "error" in line]
            got = errors[0] if errors else ended.stderr[-200:]
            raise Problem(message="the C++ compiler refuses the model", key=reference.name, got=got).error
        return (folder / "model.so").read_bytes()


def _wrapper(reference: Reference) -> Iterator[str]:
    """C functions around the class that Yosys writes."""
    inputs, outputs = list(enumerate(reference.inputs)), list(enumerate(reference.outputs))
    registers = [(i, _member(each.name), each.word) for i, each in enumerate(reference.registers)]
    arguments = ", ".join(["model *m", *(f"int64_t in_{i}" for i, _ in inputs)])
    yield '#include "module.cc"'
    yield f"typedef cxxrtl_design::{_member(reference.name)} model;"
    yield "static int64_t signed_of(uint64_t bits, int width) {"
    yield "    return (int64_t)(bits << (64 - width)) >> (64 - width);"
    yield "}"
    yield "static void rise(model *m) {"
    if reference.clocked:
        yield "    m->p_clock.set<bool>(true); m->step(); m->p_clock.set<bool>(false); m->commit();"
    yield "}"
    yield 'extern "C" {'
    yield "model *model_new() {"
    yield "    model *m = new model;"
    if reference.clocked:
        yield "    m->p_enable.set<bool>(true); m->p_reset.set<bool>(true); m->step();"
        yield "    rise(m); m->p_reset.set<bool>(false);"
    yield "    return m;"
    yield "}"
    yield "void model_delete(model *m) { delete m; }"
    yield f"void model_settle({arguments}) {{"
    yield from (f"    {_put(port, f'in_{i}')}" for i, port in inputs)
    yield "    m->step();"
    yield "}"
    yield f"void model_clock({arguments}) {{"
    yield from (f"    {_put(port, f'in_{i}')}" for i, port in inputs)
    yield "    rise(m);"
    yield "}"
    yield "int64_t model_output(model *m, int64_t number) {"
    yield "    switch (number) {"
    yield from (f"        case {i}: return {_got(_member(port.name), port.word)};" for i, port in outputs)
    yield "    }"
    yield "    return 0;"
    yield "}"
    yield "int64_t model_register(model *m, int64_t number) {"
    yield "    switch (number) {"
    yield from (f"        case {i}: return {_got(f'{name}.curr', word)};" for i, name, word in registers)
    yield "    }"
    yield "    return 0;"
    yield "}"
    yield "void model_set_register(model *m, int64_t number, int64_t value) {"
    yield "    switch (number) {"
    for i, name, word in registers:
        bits = _bits(word, "value")
        yield f"        case {i}: m->{name}.curr.set<uint64_t>({bits}); m->{name}.next = m->{name}.curr; break;"
    yield "    }"
    yield "}"
    yield "void model_run(model *m, int64_t clocks, const int64_t *const *in, int64_t *const *out) {"
    yield "    for (int64_t t = 0; t < clocks; t++) {"
    yield from (f"        {_put(port, f'in[{i}][t]')}" for i, port in inputs)
    yield "        m->step();"
    yield from (f"        out[{i}][t] = {_got(_member(port.name), port.word)};" for i, port in outputs)
    yield "        rise(m);"
    yield "    }"
    yield "}"
    yield "}"


def _put(port: VerilogPort, value: str) -> str:
    return f"m->{_member(port.name)}.set<uint64_t>({_bits(port.word, value)});"


def _bits(word: Word, value: str) -> str:
    return f"(uint64_t){value} & {(1 << word.width) - 1:#x}ull"


def _got(member: str, word: Word) -> str:
    bits = f"m->{member}.get<uint64_t>()"
    return f"signed_of({bits}, {word.width})" if word.signed else f"(int64_t){bits}"


def _member(name: str) -> str:
    """Name in CXXRTL.

    >>> _member("cell_.total")
    'p_cell___2e_total'
    """
    return "p_" + "".join("__" if c == "_" else c if c.isalnum() else f"_{ord(c):x}_" for c in name)
