"""Runs WebAssembly modules of programs by Node, all in one process: starting it takes as long as running a module."""

import atexit
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from proofmass.runner.contract.foreign import ForeignError, WebAssembly
from proofmass.runner.targets.wasm import WasmModule

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs Node")
_SERVER = """
import {createInterface} from 'node:readline';
import {pathToFileURL} from 'node:url';
for await (const folder of createInterface({input: process.stdin})) {
  process.chdir(folder);
  const said = await import(pathToFileURL(`${folder}/run.mjs`)).then(() => 'done', String);
  console.log(JSON.stringify(said));
}
"""


def run_in_node(module: WasmModule, numbers: list[int], arrays: list[Any], folder: Path) -> None:
    """Call the entry of a module with integers and arrays."""
    _OneNode().run_module(module, [(numbers, arrays)], folder)


class _OneNode(WebAssembly):
    def execute(self, folder: Path) -> None:
        """Run the script in a folder, by the process that ran those before."""
        node = _node()
        assert node.stdin is not None
        assert node.stdout is not None
        node.stdin.write(f"{folder.resolve()}\n")
        node.stdin.flush()
        if (said := node.stdout.readline()) != '"done"\n':
            raise ForeignError(f"node fails: {said or 'it ended'}")


@cache
def _node() -> "subprocess.Popen[str]":
    command = [str(NODE), "--input-type=module", "--eval", _SERVER]
    node = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(node.communicate)
    return node
