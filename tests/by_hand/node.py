"""Runs WebAssembly modules of programs by Node."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from proofmass.runner.targets.llvm_text import ENTRY
from proofmass.runner.targets.wasm import WasmModule

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs Node")
_STACK_BYTES = 1 << 20
_PAGE = 1 << 16
_SCRIPT = """
import fs from 'fs';
const {module, memory, base, pages, stack, numbers, places, entry} = JSON.parse(fs.readFileSync(process.argv[2]));
const room = new WebAssembly.Memory({initial: pages});
const env = {__linear_memory: room, __stack_pointer: new WebAssembly.Global({value: 'i32', mutable: true}, stack)};
const made = new WebAssembly.Module(fs.readFileSync(module));
for (const wanted of WebAssembly.Module.imports(made))
  if (wanted.kind === 'function') env[wanted.name] = Math[wanted.name.replace('proofmass_', '')];
const {exports} = new WebAssembly.Instance(made, {env});
const bytes = fs.readFileSync(memory);
new Uint8Array(room.buffer).set(bytes, base);
exports[entry](...numbers.map(BigInt), ...places);
fs.writeFileSync(memory, new Uint8Array(room.buffer, base, bytes.length));
"""


def run_in_node(module: WasmModule, numbers: list[int], arrays: list[Any], folder: Path) -> None:
    """Call the entry of a module with integers and arrays."""
    base = module.constants + -module.constants % 64 + 64
    data, places = bytearray(), []
    for array in arrays:
        data += bytes(-len(data) % 64)
        places.append(base + len(data))
        data += array.tobytes()
    stack = base + len(data) + _STACK_BYTES
    stack += -stack % 64
    (folder / "module.wasm").write_bytes(module.code)
    (folder / "memory").write_bytes(data)
    (folder / "run.mjs").write_text(_SCRIPT)
    told = {
        "module": str(folder / "module.wasm"), "memory": str(folder / "memory"), "base": base, "entry": ENTRY,
        "pages": stack // _PAGE + 1, "stack": stack, "numbers": [str(n) for n in numbers], "places": places,
    }  # fmt: skip
    (folder / "told.json").write_text(json.dumps(told))
    command = [NODE or "", str(folder / "run.mjs"), str(folder / "told.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    behind = (folder / "memory").read_bytes()
    for array, place in zip(arrays, places, strict=True):
        array.reshape(-1).view("u1")[:] = bytearray(behind[place - base : place - base + array.nbytes])
