"""Machine code of a generated loop: made once by Numba, kept in the user's own folder, loaded without Numba.

The object file is named by the hash of everything that went in: the generated source, every function that it calls
as this process holds it, the versions of Python, Numba and llvmlite, and the processor. A damaged file is made anew;
a folder that others could write to is not read. No fast-math, no contraction to fused multiply-add, no vector
library: the code computes the same bits as plain Python.
"""

import ctypes
import ctypes.util
import dis
import hashlib
import os
import re
import sys
import threading
import types
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from typing import Any

import llvmlite.binding as llvm

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.language import arithmetic
from proofmass.blocks.language.arithmetic import OF_C
from proofmass.runner.host.cache import keep, kept
from proofmass.runner.host.versions import version
from proofmass.runner.program.c_function import CFunction
from proofmass.runner.program.generate import Generated

SYMBOL = "proofmass_loop"
_DESTRUCTOR = "NRT_MemInfo_call_dtor"  # of arrays that own their memory: the loop has none
_nothing_to_destroy = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(lambda _: None)
_ALONE, _WITH_NUMBA = b"A", b"N"  # whether the code calls functions of Numba's own, such as that for math.frexp
_OPTIONS = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # nothing but LLVM calls them
_loaded: dict[str, tuple[Any, Any]] = {}  # key: engine, which owns the code, and the function
Functions = dict[
    tuple[Any, ...], tuple[dict[str, Any], Any]
]  # by function and settings: what it reads; as Numba has it
_functions: Functions = {}
_loading = threading.Lock()  # Numba's settings are those of the process


def key_of(generated: Generated, argument_kinds: tuple[str, ...]) -> str:
    """Hash of everything that the machine code depends on, how it is made included."""
    made_by = [*_described("made by", _compiled, {}), repr(argument_kinds), sys.version, sys.platform]
    versions = [version("numba"), version("llvmlite"), llvm.get_host_cpu_name()]
    parts = [content_of(generated), *made_by, *versions, llvm.get_host_cpu_features().flatten()]
    return _digest(parts)[:32]


def content_of(generated: Generated) -> str:
    """Hash of what the loop computes: its source and all functions that it calls, whatever file they come from."""
    seen: dict[types.FunctionType, int] = {}
    called = (line for name, value in sorted(generated.names.items()) for line in _described(name, value, seen))
    return _digest([generated.source, *called])


def is_cached(key: str) -> bool:
    """Whether the loop can run without compiling."""
    return key in _loaded or kept(f"{key}.o") is not None


def load(generated: Generated, argument_kinds: tuple[str, ...]) -> Any:
    """The compiled loop as a C function; compiles and keeps it when it is not there yet.

    `argument_kinds` are "int", "int*", "bool*" or "float*", one per argument.
    """
    key = key_of(generated, argument_kinds)
    with _loading:
        if key not in _loaded:
            for value in generated.names.values():
                if isinstance(value, CFunction):
                    llvm.add_symbol(value.symbol, value.address)
            _name_c_functions()
            code = kept(f"{key}.o")
            function = _linked(code, argument_kinds) if code else None
            if function is None:
                code = _compiled(generated, argument_kinds, _functions)
                keep(f"{key}.o", code, {f"{key}.py": generated.listing})
                function = _linked(code, argument_kinds)
            _loaded[key] = function
    return _loaded[key][1]


@cache
def _name_c_functions() -> None:
    """Tell LLVM where the functions are that Python calls, under names of which it knows nothing: it would put others
    in the place of a power with a constant exponent."""
    try:
        library = ctypes.CDLL(None)
        addresses = {name: ctypes.cast(getattr(library, name), ctypes.c_void_p).value for name in OF_C.values()}
    except (AttributeError, TypeError, OSError):
        library = ctypes.CDLL(ctypes.util.find_library("m") or "msvcrt")
        addresses = {name: ctypes.cast(getattr(library, name), ctypes.c_void_p).value for name in OF_C.values()}
    for name, address in addresses.items():
        llvm.add_symbol(_own_symbol(name), address or 0)


def _own_symbol(name: str) -> str:
    return f"proofmass_{name}"


def _digest(parts: list[str]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part.encode("utf-8", "surrogatepass") + b"\0")
    return digest.hexdigest()


def _described(name: str, value: Any, seen: dict[types.FunctionType, int]) -> Iterator[str]:
    """A function as text with everything that it calls or reads; other values by what a compiler sees of them.

    The functions as they are in memory count, not their files: a file may have been edited since it was imported.
    """
    value = getattr(value, "py_func", value)  # compiled by Numba already, by its author
    if hasattr(value, "cache_info"):  # what `functools` keeps results of
        value = value.__wrapped__
    if isinstance(value, types.FunctionType):
        known = value in seen
        yield f"{name} is function {seen.setdefault(value, len(seen))}"
        if not known:
            yield _code_described(value.__code__)
            yield repr((value.__defaults__, value.__kwdefaults__))
            for other, read in sorted(_read_by(value).items()):
                yield from _described(other, read, seen)
    elif isinstance(value, types.ModuleType):
        yield f"{name} is {value.__name__}"
    elif isinstance(value, type):
        fields = getattr(value, "__annotations__", {}), getattr(value, "_field_defaults", {})
        yield f"{name} is {value.__qualname__} {fields}"
    elif hasattr(value, "tobytes"):
        yield f"{name} is {type(value).__name__} {value.dtype} {value.shape} {value.tobytes().hex()}"
    else:
        yield f"{name} is {value!r}"


@lru_cache(maxsize=4096)
def _code_described(code: types.CodeType) -> str:
    parts = [repr((code.co_code, code.co_exceptiontable, code.co_argcount, code.co_names, code.co_varnames))]
    parts.append(repr((code.co_freevars, code.co_cellvars)))
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            parts.append(_code_described(constant))
        else:
            parts.append(repr(sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant))
    return "\0".join(parts)


def _read_by(function: types.FunctionType) -> dict[str, Any]:
    """Global values and values of enclosing functions that a function reads, by name."""
    names = _global_names(function.__code__)
    found = {name: function.__globals__[name] for name in names if name in function.__globals__}
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    return found | {name: cell.cell_contents for name, cell in cells}


@lru_cache(maxsize=4096)
def _global_names(code: types.CodeType) -> frozenset[str]:
    """Names that code, and code within it, reads from outside of itself."""
    found = {step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
    within = (_global_names(constant) for constant in code.co_consts if isinstance(constant, types.CodeType))
    return frozenset(found.union(*within))


def _compiled(generated: Generated, argument_kinds: tuple[str, ...], functions: Functions) -> bytes:
    mode = bool(generated.vectors), bool(generated.lanes)
    with _settings_of_numba(*mode):
        numba = _numba()
        kinds = {
            "int": numba.int64,
            "int*": numba.types.CPointer(numba.int64),
            "bool*": numba.types.CPointer(numba.boolean),
            "float*": numba.types.CPointer(numba.float64),
        }
        signature = numba.void(*(kinds[kind] for kind in argument_kinds))
        try:
            jitted: dict[types.FunctionType, Any] = {}
            names = {name: _jit(value, mode, functions, jitted) for name, value in generated.names.items()}
            namespace: dict[str, Any] = {"carray": numba.carray, **names}
            exec(compile(generated.source, "<generated loop>", "exec"), namespace)
            for name in generated.functions:
                inlined = name in generated.inlined
                own = numba.njit(namespace[name], forceinline=inlined, **_OPTIONS)
                namespace[name] = own
            loop = numba.njit(signature, **_OPTIONS)(namespace["loop"])
        except Exception as error:
            raise ModelError([_not_compiled(error)]) from error
        made = loop.overloads[loop.signatures[0]]
        module = llvm.parse_assembly(made.library.get_llvm_str())
        return _object_code(module, made.fndesc.llvm_func_name)


def _numba() -> Any:
    """Numba, imported late; its own types know neither all its options nor all its names."""
    import numba

    return numba


@contextmanager
def _settings_of_numba(rows: bool, lanes: bool) -> Iterator[None]:
    """Numba as the loop wants it, whatever the user set for code of their own; as it was afterwards.

    Only with `rows` are numbers gathered into short vectors (SLP): it makes correlation cells fast, and the chain of
    operations round a loop of scalars slow. Only with `lanes` are vectors as wide as the processor has them: rows are
    too short for it.
    """
    own = {name: value for name, value in os.environ.items() if name.startswith("NUMBA_")}
    for name in own:
        del os.environ[name]
    os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"
    os.environ["NUMBA_SLP_VECTORIZE"] = "1" if rows else "0"
    config = _numba().core.config
    config.reload_config()
    vector_library, config.USING_SVML = config.USING_SVML, False
    codegen = _numba().core.registry.cpu_target.target_context.codegen()
    machine, codegen._tm = codegen._tm, _machine(wide=lanes)
    try:
        yield
    finally:
        del os.environ["NUMBA_DISABLE_INTEL_SVML"], os.environ["NUMBA_SLP_VECTORIZE"]
        os.environ.update(own)
        config.reload_config()
        config.USING_SVML, codegen._tm = vector_library, machine


def _jit(value: Any, mode: tuple[bool, bool], functions: Functions, jitted: dict[types.FunctionType, Any]) -> Any:
    """A function compiled with everything that it calls, in one of the settings of Numba; other values as they are.

    A function of a module is kept for later loops, and made anew when what it calls or reads has been changed.
    """
    value = getattr(value, "py_func", value)
    if isinstance(value, CFunction):
        return _external(value)
    if getattr(value, "__module__", "") == arithmetic.__name__ and value.__name__ in OF_C:
        numba, given = _numba(), value.__code__.co_argcount
        return numba.types.ExternalFunction(_own_symbol(OF_C[value.__name__]), numba.float64(*[numba.float64] * given))
    if not isinstance(value, types.FunctionType):
        return value
    if value not in jitted:
        read = {name: _jit(other, mode, functions, jitted) for name, other in _read_by(value).items()}
        before, kept = functions.get((value, *mode), ({}, None))
        if kept is None or before.keys() != read.keys() or any(before[name] is not read[name] for name in read):
            kept = _compiled_later(value, read)
            if getattr(sys.modules.get(value.__module__), value.__name__, None) is value:
                functions[value, *mode] = read, kept
        jitted[value] = kept
    return jitted[value]


def _external(function: CFunction) -> Any:
    """A function in C as Numba has it."""
    numba = _numba()
    returned = numba.int64 if function.returns else numba.void
    return numba.types.ExternalFunction(function.symbol, returned(*[numba.int64] * function.arguments))


def _compiled_later(function: types.FunctionType, read: dict[str, Any]) -> Any:
    """The function with these values in the place of what it reads; Numba compiles it when its types are known."""
    cells = tuple(types.CellType(read[name]) for name in function.__code__.co_freevars)
    globals_ = function.__globals__ | read
    copied = types.FunctionType(function.__code__, globals_, function.__name__, function.__defaults__, cells)
    small = not function.__module__.startswith("proofmass.runner.continuous")  # solvers are large and called often
    return _numba().njit(copied, forceinline=small, **_OPTIONS)


def _not_compiled(error: Exception) -> Problem:
    """What Numba could not compile, with the innermost line of a block that it names."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", str(error))
    places = [place for place in re.findall(r'File "([^"\n]+)", line (\d+)', text) if not place[0].startswith("<")]
    file, line = places[-1] if places else ("", "0")
    told = (row.strip() for row in text.splitlines())
    skipped = ("Failed in", "During:", "- ", "File ")
    reason = next((row for row in told if row and not row.startswith(skipped)), type(error).__name__)
    return Problem(
        message="a function of a block cannot be compiled",
        file=file,
        line=int(line),
        got=reason,
        expected="arithmetic, math, if, for and while on numbers",
        hint="rewrite it, or run in plain Python: --engine python",
    )


def _object_code(module: Any, entry: str) -> bytes:
    """Object file with the loop alone, under a name of our own, behind a letter that says what it needs beside it."""
    for function in module.functions:
        if function.name == entry:
            function.name = SYMBOL
        elif not function.is_declaration:
            function.linkage = "internal"
    machine = _machine()
    passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options())
    manager = llvm.create_new_module_pass_manager()
    manager.add_global_dead_code_eliminate_pass()
    manager.run(module, passes)
    called = {f.name for f in module.functions if f.is_declaration} - {_DESTRUCTOR}
    helped = any(name.startswith(("numba_", "NRT_")) for name in called)
    return (_WITH_NUMBA if helped else _ALONE) + bytes(machine.emit_object(module))


def _machine(wide: bool = False) -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten() + (",-prefer-256-bit" if wide and _has_wide_vectors() else ""),
        opt=3,
        reloc="pic",
        codemodel="jitdefault",
        jit=True,
    )


def _has_wide_vectors() -> bool:
    """Whether vectors of 512 bits exist, which LLVM uses on such processors only when it is told to."""
    return bool(llvm.get_host_cpu_features().get("avx512f"))


def _linked(code: bytes, argument_kinds: tuple[str, ...]) -> tuple[Any, Callable[..., Any]]:
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
    if code.startswith(_WITH_NUMBA):
        from numba.core.registry import cpu_target

        assert cpu_target.target_context  # once made, it has told LLVM where Numba's helpers are
    else:
        llvm.add_symbol(_DESTRUCTOR, ctypes.cast(_nothing_to_destroy, ctypes.c_void_p).value or 0)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code[1:]))
    engine.finalize_object()
    kinds = [ctypes.c_int64 if kind == "int" else ctypes.c_void_p for kind in argument_kinds]
    # Numba's convention: a status is returned; the first two arguments take a return value and an exception.
    prototype = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *kinds)
    function = prototype(engine.get_function_address(SYMBOL))
    nothing = (ctypes.c_void_p * 2)()
    addresses = (ctypes.addressof(nothing), ctypes.addressof(nothing) + ctypes.sizeof(ctypes.c_void_p))

    def call(*arguments: Any) -> None:
        status = function(*addresses, *arguments)
        if status != 0:
            raise RuntimeError(f"the compiled loop returned status {status}")

    return (engine, nothing), call
