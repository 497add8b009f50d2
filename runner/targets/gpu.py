"""A program as PTX for GPUs of NVIDIA: a kernel that goes through the program with a thread for each run.

Every operation is rounded by itself: no instruction is fused, so the bits are those of machine
code. There is no libm.
"""

from collections.abc import Iterator

import llvmlite.binding as llvm

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.program.form import Call, External, Function, Program, Value
from proofmass.runner.program.walk import statements
from proofmass.runner.targets.lane_text import LanesOf
from proofmass.runner.targets.llvm_operations import TYPES
from proofmass.runner.targets.llvm_text import ENTRY, STORED, llvm_text
from proofmass.runner.targets.machine_code import ALONE, optimise

KERNEL = "proofmass_kernel"
_TRIPLE, _OLDEST = "nvptx64-nvidia-cuda", "sm_70"
_THREAD = """\
declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.ntid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()"""
_RUN = """\
  %block = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
  %threads = call i32 @llvm.nvvm.read.ptx.sreg.ntid.x()
  %thread = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %block.wide = zext i32 %block to i64
  %threads.wide = zext i32 %threads to i64
  %thread.wide = zext i32 %thread to i64
  %before = mul i64 %block.wide, %threads.wide
  %number = add i64 %before, %thread.wide
  %exists = icmp ult i64 %number, %runs
  br i1 %exists, label %run, label %end
run:"""


def ptx_text(program: Program, of_entry: LanesOf, processor: str = _OLDEST) -> str:
    """The kernel of a program, `KERNEL`: the number of runs, then for each parameter of the entry

    - a number that is the same in all runs: the number; one that differs: the address of one for each run
    - an array that all runs share: its address; another one: its address, and the entries from one
    run to the next
    """
    refused = list(_without_libm(program))
    if refused:
        raise ModelError(refused)
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(_TRIPLE).create_target_machine(cpu=processor, opt=3)
    text = llvm_text(program, _TRIPLE, str(machine.target_data))
    module = llvm.parse_assembly("\n".join([text, _kernel(program.entry, of_entry)]))
    optimise(module, machine, ALONE)
    return str(machine.emit_assembly(module))


def _without_libm(program: Program) -> Iterator[Problem]:
    """Yield a problem for each function that the program calls and a GPU lacks."""
    for function in program.functions.values():
        for s in statements(function.body):
            if isinstance(s, Call) and isinstance(s.function, External):
                yield Problem(
                    message=f"a GPU has no function {s.function.symbol}",
                    file=s.line.file if s.line else "",
                    line=s.line.number if s.line else 0,
                    key=function.origin,
                    hint="use the functions of proofmass.blocks.arithmetic.elementary",
                )


def _kernel(entry: Function, of_entry: LanesOf) -> str:
    """The kernel, which calls the entry."""
    parameters, lines, arguments = ["i64 %runs"], [], []
    for number, parameter in enumerate(entry.parameters):
        if isinstance(parameter, Value):
            kind = TYPES[parameter.kind]
            if parameter in of_entry.numbers:
                parameters.append(f"ptr %p{number}")
                lines.append(f"  %at{number} = getelementptr inbounds {kind}, ptr %p{number}, i64 %number")
                lines.append(f"  %a{number} = load {kind}, ptr %at{number}")
                arguments.append(f"{kind} %a{number}")
            else:
                parameters.append(f"{kind} %p{number}")
                arguments.append(f"{kind} %p{number}")
        elif parameter in of_entry.shared:
            parameters.append(f"ptr %p{number}")
            arguments.append(f"ptr %p{number}")
        else:
            parameters += [f"ptr %p{number}", f"i64 %s{number}"]
            lines.append(f"  %o{number} = mul i64 %s{number}, %number")
            entry_type = STORED[parameter.entry]
            lines.append(f"  %a{number} = getelementptr inbounds {entry_type}, ptr %p{number}, i64 %o{number}")
            arguments.append(f"ptr %a{number}")
    head = f"define ptx_kernel void @{KERNEL}({', '.join(parameters)}) {{"
    call = f"  call void @{ENTRY}({', '.join(arguments)})"
    return "\n".join([_THREAD, head, _RUN, *lines, call, "  br label %end", "end:", "  ret void", "}", ""])
