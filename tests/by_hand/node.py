"""Runs WebAssembly modules of programs by Node."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from proofmass.runner.contract.foreign import WebAssembly
from proofmass.runner.targets.wasm import WasmModule

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs Node")


def run_in_node(module: WasmModule, numbers: list[int], arrays: list[Any], folder: Path) -> None:
    """Call the entry of a module with integers and arrays."""
    WebAssembly().run_module(module, [(numbers, arrays)], folder)
