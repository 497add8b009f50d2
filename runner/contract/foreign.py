"""Programs compiled by gcc as C99 and run by Node as WebAssembly, where these are installed."""

import ctypes
import json
import shutil
import subprocess
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from proofmass.runner.program.form import Program
from proofmass.runner.targets.c99 import c99_text
from proofmass.runner.targets.llvm_functions import externals
from proofmass.runner.targets.llvm_text import ENTRY
from proofmass.runner.targets.wasm import WasmModule, wasm_module

_Call = tuple[Sequence[int], Sequence[Any]]  # integers, and arrays the entry changes


class ForeignError(RuntimeError):
    """A compiler or machine that does not take the program: its words."""


class Foreign(ABC):
    """A compiler that is not ours, or a machine that is not this one."""

    name: str
    command: str

    def lacks(self, program: Program) -> str:
        """Return why the bits of a program cannot be compared there, or ""."""
        return "" if shutil.which(self.command) else f"there is no {self.command} here"

    @abstractmethod
    def run(self, program: Program, calls: Sequence[_Call], folder: Path) -> None:
        """Call the entry once for each of the calls. Raises `ForeignError`."""


class C99(Foreign):
    """The printed C, compiled by gcc without contraction."""

    name, command = "C99", "gcc"

    def run(self, program: Program, calls: Sequence[_Call], folder: Path) -> None:
        entry = self.compiled(program, folder)
        for numbers, arrays in calls:
            entry(*map(ctypes.c_int64, numbers), *(ctypes.c_void_p(array.ctypes.data) for array in arrays))

    def compiled(self, program: Program, folder: Path, flags: Sequence[str] = ("-O1",)) -> Any:
        """Return the entry of a program as a function of C."""
        (folder / "program.c").write_text(c99_text(program, "entry"), encoding="utf-8")
        files = ["-o", str(folder / "program.so"), str(folder / "program.c")]
        _done([self.command, "-std=c99", "-ffp-contract=off", "-fPIC", "-shared", *flags, *files, "-lm"])
        return ctypes.CDLL(str(folder / "program.so")).entry


class WebAssembly(Foreign):
    """The module, run by Node."""

    name, command = "WebAssembly", "node"

    def lacks(self, program: Program) -> str:
        called = sorted({external.symbol for external in externals(program).values()} - _EXACT)
        if called:
            return f"a browser brings its own {', '.join(called)}, with other last bits"
        return super().lacks(program)

    def run(self, program: Program, calls: Sequence[_Call], folder: Path) -> None:
        self.run_module(wasm_module(program), calls, folder)

    def run_module(self, module: WasmModule, calls: Sequence[_Call], folder: Path) -> None:
        """Call the entry of a module once for each of the calls."""
        base = _aligned(module.constants + 1)
        contents = [_Memory(base, arrays) for _, arrays in calls]
        (folder / "module.wasm").write_bytes(module.code)
        (folder / "run.mjs").write_text(_SCRIPT, encoding="utf-8")
        for number, content in enumerate(contents):
            (folder / f"memory_{number}").write_bytes(content.data)
        stack = _aligned(base + max(len(content.data) for content in contents) + _STACK_BYTES)
        settings = {
            "base": base,
            "entry": ENTRY,
            "pages": stack // _PAGE + 1,
            "stack": stack,
            "calls": [
                {"numbers": [str(n) for n in numbers], "places": content.places}
                for (numbers, _), content in zip(calls, contents, strict=True)
            ],
        }
        (folder / "told.json").write_text(json.dumps(settings), encoding="utf-8")
        self.execute(folder)
        for number, content in enumerate(contents):
            content.read((folder / f"memory_{number}").read_bytes())

    def execute(self, folder: Path) -> None:
        """Run the script in a folder."""
        _done([self.command, "run.mjs"], folder)


FOREIGN: tuple[Foreign, ...] = (C99(), WebAssembly())

_EXACT = {"fmod"}  # what every machine computes alike, since it is rounded to nothing
_STACK_BYTES = 1 << 20
_PAGE = 1 << 16
_LINE = 64
_SCRIPT = """
import fs from 'fs';
const {base, pages, stack, calls, entry} = JSON.parse(fs.readFileSync('told.json'));
const made = new WebAssembly.Module(fs.readFileSync('module.wasm'));
const functions = {fmod: (a, b) => a % b};
for (const name of Object.getOwnPropertyNames(Math)) functions[name] = Math[name];
calls.forEach(({numbers, places}, number) => {
  const room = new WebAssembly.Memory({initial: pages});
  const env = {__linear_memory: room, __stack_pointer: new WebAssembly.Global({value: 'i32', mutable: true}, stack)};
  for (const wanted of WebAssembly.Module.imports(made))
    if (wanted.kind === 'function') env[wanted.name] = functions[wanted.name.replace('proofmass_', '')];
  const {exports} = new WebAssembly.Instance(made, {env});
  const bytes = fs.readFileSync(`memory_${number}`);
  new Uint8Array(room.buffer).set(bytes, base);
  exports[entry](...numbers.map(BigInt), ...places);
  fs.writeFileSync(`memory_${number}`, new Uint8Array(room.buffer, base, bytes.length));
});
"""


class _Memory:
    """Arrays one after the other, as the module finds them."""

    def __init__(self, base: int, arrays: Sequence[Any]) -> None:
        self.base, self.arrays, self.data = base, arrays, bytearray()
        self.places: list[int] = []
        for array in arrays:
            self.data += bytes(-len(self.data) % _LINE)
            self.places.append(base + len(self.data))
            self.data += array.tobytes()

    def read(self, data: bytes) -> None:
        """Put what the module has left into the arrays."""
        for array, place in zip(self.arrays, self.places, strict=True):
            first = place - self.base
            array.reshape(-1).view("u1")[:] = bytearray(data[first : first + array.nbytes])


def _aligned(size: int) -> int:
    return size + -size % _LINE


def _done(command: list[str], folder: Path | None = None) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    if done.returncode:
        raise ForeignError(f"{command[0]} fails: {done.stderr.strip()[:400]}")
