"""Hash of what a program computes: the same in every process and on every machine."""

import hashlib

from proofmass.runner.program.form import Program
from proofmass.runner.targets.llvm_text import llvm_text


def content_of(program: Program) -> str:
    """Hash of everything that a program computes, whatever files its functions come from."""
    return hashlib.sha256(llvm_text(program).encode()).hexdigest()
