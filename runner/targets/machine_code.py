"""Machine code of a program: made by LLVM, kept in the user's own folder, loaded from there the next time.

The object file is named by the hash of everything that went in: the text of the module, the version
of LLVM and the processor. A damaged file is made anew; a folder that others could write to is not
read. No fast-math, no contraction to fused multiply-add, no vector library: the code computes the
same bits as plain Python.
"""

import ctypes
import ctypes.util
import hashlib
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from proofmass.runner.host.cache import keep, kept
from proofmass.runner.host.llvm_lock import AT_WORK
from proofmass.runner.host.versions import version
from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, External, Function, Program, Storage, Value
from proofmass.runner.program.lower import lower, program
from proofmass.runner.program.structure import Lowered
from proofmass.runner.targets.lane_text import LanesOf, lane_text
from proofmass.runner.targets.llvm_functions import externals
from proofmass.runner.targets.llvm_text import ENTRY, llvm_text

_C_TYPES: Mapping[Any, Any] = {FLOAT: ctypes.c_double, INTEGER: ctypes.c_int64, TRUTH: ctypes.c_bool}
_loaded: dict[str, tuple[Any, Any]] = {}  # key: engine, which owns the code, and the function


class Settings(NamedTuple):
    """Settings of LLVM's passes."""

    level: int = 1  # higher levels compile half as long again, and the code is no faster
    rows: bool = False  # gather numbers into short vectors
    loops: bool = True  # make vectors of loops
    wide: bool = False  # as wide as the processor has them
    selection: int = 3  # of instructions


ALONE = Settings()
QUICK = Settings(
    level=0, loops=False, selection=0
)  # made in a sixth of the time, takes up to five times as long to run


class LlvmModule(NamedTuple):
    """A program as LLVM is given it; numbers in `rows` are given by the addresses of rows."""

    program: Program
    text: str
    settings: Settings
    key: str
    rows: frozenset[Value] = frozenset()
    defined: frozenset[str] = frozenset()  # external functions that the text itself defines

    @classmethod
    def of(cls, program: Program, settings: Settings = ALONE) -> "LlvmModule":
        """The module of one run."""
        text = llvm_text(program)
        return cls(program, text, settings, key_of(text, settings))

    def compiled_by(self, settings: Settings) -> "LlvmModule":
        """Return the same module, compiled by other settings."""
        return self._replace(settings=settings, key=key_of(self.text, settings))


def load(program: Program, settings: Settings = ALONE) -> Callable[..., Any]:
    """The program as a function of numbers and addresses of arrays; made and kept when it is not there yet."""
    return load_module(LlvmModule.of(program, settings))


def load_python(function: Callable[..., Any], arguments: Sequence[Lowered]) -> Callable[..., Any]:
    """Return a Python function of such arguments as machine code, as `load` does."""
    return load(program(lower(function, arguments).function))


def load_lanes(program: Program, lanes: int, of_entry: LanesOf, settings: Settings) -> Callable[..., Any]:
    """The program for several runs side by side; differing numbers are addresses of rows."""
    text = lane_text(program, lanes, of_entry)
    return load_module(LlvmModule(program, text, settings, key_of(text, settings), of_entry.numbers))


def _nothing() -> None:
    """Nothing is done between the steps."""


def load_module(module: LlvmModule, between: Callable[[], None] = _nothing) -> Callable[..., Any]:
    """The function of a module; `between` is called between the steps of compiling, and may end it by raising."""
    key = module.key
    with AT_WORK:
        between()
        if key not in _loaded:
            called = externals(module.program)
            _name_externals({symbol: called[symbol] for symbol in called.keys() - module.defined})
            code = kept(f"{key}.o")
            prototype = _prototype(module.program.entry, module.rows)
            function = _linked(code, prototype) if code else None
            if function is None:
                code = object_code(module.text, module.settings, between)
                keep(f"{key}.o", code)
                function = _linked(code, prototype)
            _loaded[key] = function
    function_of_c: Callable[..., Any] = _loaded[key][1]
    return function_of_c


def _prototype(entry: Function, rows: frozenset[Value]) -> Any:
    """The type of the entry in C; what differs between lanes is given by its address."""
    by_address = (isinstance(p, Storage) or p in rows for p in entry.parameters)
    kinds = [
        ctypes.c_void_p if address else _C_TYPES[p.kind]  # type: ignore[union-attr]
        for address, p in zip(by_address, entry.parameters, strict=True)
    ]
    return ctypes.CFUNCTYPE(_C_TYPES[entry.results[0]] if entry.results else None, *kinds)


def is_cached(key: str) -> bool:
    """Return whether a program can run without compiling."""
    return key in _loaded or kept(f"{key}.o") is not None


def key_of(text: str, settings: Settings = ALONE) -> str:
    """Hash of everything that the machine code depends on."""
    made_by = [version("llvmlite"), repr(llvm.llvm_version_info), repr(settings), llvm.get_default_triple()]
    digest = hashlib.sha256()
    for part in (text, *made_by, llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()):
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()[:32]


def object_code(text: str, settings: Settings = ALONE, between: Callable[[], None] = _nothing) -> bytes:
    """Object file of a module, for the processor at hand."""
    between()
    machine = machine_of(settings)
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    between()
    optimise(module, machine, settings)
    between()
    return bytes(machine.emit_object(module))


def optimise(module: Any, machine: Any, settings: Settings = ALONE) -> None:
    """Run LLVM's passes over a module.

    Small functions are taken into their callers before all else: passes that look at the whole
    program take time with the square of its calls.
    """
    tuning = llvm.create_pipeline_tuning_options(speed_level=settings.level)
    tuning.slp_vectorization = settings.rows
    tuning.loop_vectorization = settings.loops
    passes = llvm.create_pass_builder(machine, tuning)
    first = llvm.create_new_module_pass_manager()
    first.add_always_inliner_pass()
    first.add_global_dead_code_eliminate_pass()
    first.add_sroa_pass()
    first.add_simplify_cfg_pass()
    first.run(module, passes)
    passes.getModulePassManager().run(module, passes)


def machine_of(settings: Settings = ALONE) -> Any:
    _begin()
    unlimited = ",-prefer-256-bit" if settings.wide and has_wide_vectors() else ""
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten() + unlimited,
        opt=settings.selection,
        reloc="pic",
        codemodel="jitdefault",
        jit=True,
    )


@cache
def has_wide_vectors() -> bool:
    """Return whether the processor at hand computes with vectors of 512 bits."""
    return bool(llvm.get_host_cpu_features().get("avx512f"))


@cache
def _begin() -> None:
    """Set LLVM up, once in a process.

    A second scheduler of instructions is of no use to processors of today, and takes time with the
    square of a tick's length. Other addresses for the turns of loops take a fifth of the time of an
    object file; no graph gets faster.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for option in ("-disable-post-ra", "-disable-lsr"):
        llvm.set_option("proofmass", option)


def _name_externals(called: Mapping[str, External]) -> None:
    """Tell LLVM where the functions of other libraries are; those of the C library are the ones that Python calls."""
    for symbol, external in called.items():
        llvm.add_symbol(symbol, external.address or _address_in_c(external.symbol))


@cache
def _address_in_c(name: str) -> int:
    try:
        function = getattr(ctypes.CDLL(None), name)
    except (AttributeError, TypeError, OSError):
        function = getattr(ctypes.CDLL(ctypes.util.find_library("m") or "msvcrt"), name)
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _linked(code: bytes, prototype: Any) -> tuple[Any, Callable[..., Any]]:
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine_of())  # which takes ownership of the machine
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine, prototype(engine.get_function_address(ENTRY))
