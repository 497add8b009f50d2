"""Machine code of a generated loop: made once by Numba, kept in the user's own folder, loaded without Numba.

The object file is named by the hash of everything that went in: the generated source, the source of every module it
calls, the versions of Python, Numba and llvmlite, and the processor. A damaged file is made anew; a folder that
others could write to is refused. No fast-math, no contraction to fused multiply-add, no vector library: the code
computes the same bits as plain Python.
"""

import ctypes
import dis
import hashlib
import os
import stat
import sys
import tempfile
import types
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from proofmass.runner.generate import Generated

SYMBOL = "proofmass_loop"
_loaded: dict[str, tuple[Any, Any]] = {}  # key: engine, which owns the code, and the function


def cache_folder() -> Path:
    """The folder of compiled loops: `PROOFMASS_CACHE`, or `proofmass` in the user's cache folder."""
    named = os.environ.get("PROOFMASS_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "proofmass"


def key_of(generated: Generated, argument_kinds: tuple[str, ...]) -> str:
    """Hash of everything that the machine code depends on."""
    digest = hashlib.sha256()
    parts = [generated.source, repr(argument_kinds), sys.version, version("numba"), version("llvmlite")]
    parts += [llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), sys.platform]
    for part in parts:
        digest.update(part.encode() + b"\0")
    for source in sorted(_sources(generated.names)):
        digest.update(source + b"\0")
    return digest.hexdigest()[:32]


def is_cached(key: str) -> bool:
    """Whether the loop can run without compiling."""
    return key in _loaded or (cache_folder() / f"{key}.o").exists()


def load(generated: Generated, argument_kinds: tuple[str, ...]) -> Any:
    """The compiled loop as a C function; compiles and keeps it when it is not there yet.

    `argument_kinds` are "int", "int*", "bool*" or "float*", one per argument.
    """
    key = key_of(generated, argument_kinds)
    if key not in _loaded:
        code = _read(key)
        function = _linked(code, argument_kinds) if code else None
        if function is None:
            code = _compiled(generated, argument_kinds)
            _keep(key, code, generated.source)
            function = _linked(code, argument_kinds)
        _loaded[key] = function
    return _loaded[key][1]


def _sources(names: Mapping[str, Any]) -> set[bytes]:
    """Source text of every module that the functions come from, helpers included."""
    found: set[bytes] = set()
    todo, seen = list(names.values()), set()
    while todo:
        value = todo.pop()
        if not isinstance(value, types.FunctionType) or value in seen:
            if isinstance(value, type):
                found.add(repr((value.__qualname__, value.__annotations__)).encode())
            continue
        seen.add(value)
        file = value.__code__.co_filename
        found.add(Path(file).read_bytes() if Path(file).exists() else value.__code__.co_code)
        todo += [value.__globals__.get(name) for name in _globals_read(value)]
    return found


def _compiled(generated: Generated, argument_kinds: tuple[str, ...]) -> bytes:
    os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"
    import numba
    from numba.core import config

    config.USING_SVML = False
    config.SLP_VECTORIZE = 1  # correlation cells and other short rows side by side
    jitted: dict[Any, Any] = {}
    names = {name: _jit(value, jitted) for name, value in generated.names.items()}
    namespace: dict[str, Any] = {"carray": numba.carray, **names}
    exec(compile(generated.source, "<generated loop>", "exec"), namespace)
    kinds = {
        "int": numba.int64,
        "int*": numba.types.CPointer(numba.int64),
        "bool*": numba.types.CPointer(numba.boolean),
        "float*": numba.types.CPointer(numba.float64),
    }
    signature = numba.void(*(kinds[kind] for kind in argument_kinds))
    options = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    loop = numba.njit(signature, **options)(namespace["loop"])
    module = llvm.parse_assembly(loop.inspect_llvm(loop.signatures[0]))
    return _object_code(module)


def _jit(value: Any, jitted: dict[Any, Any]) -> Any:
    """A function compiled with everything that it calls; other values as they are."""
    import numba

    if not isinstance(value, types.FunctionType):
        return value
    if value not in jitted:
        globals_ = dict(value.__globals__)
        for name in _globals_read(value):
            if isinstance(globals_.get(name), types.FunctionType):
                globals_[name] = _jit(globals_[name], jitted)
        copied = types.FunctionType(value.__code__, globals_, value.__name__, value.__defaults__)
        jitted[value] = numba.njit(copied, error_model="numpy", forceinline=True, no_cpython_wrapper=True)
    return jitted[value]


def _globals_read(function: types.FunctionType) -> set[str]:
    return {step.argval for step in dis.get_instructions(function) if step.opname == "LOAD_GLOBAL"}


def _object_code(module: Any) -> bytes:
    """Object file with the loop alone, under a name of our own."""
    for function in module.functions:
        if not function.is_declaration:
            if "loop" in function.name and not function.name.startswith(("cfunc.", "cpython.")):
                function.name = SYMBOL
            else:
                function.linkage = "internal"
    machine = _machine()
    passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options())
    manager = llvm.create_new_module_pass_manager()
    manager.add_global_dead_code_eliminate_pass()
    manager.run(module, passes)
    return bytes(machine.emit_object(module))


def _machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=3,
        reloc="pic",
        codemodel="jitdefault",
        jit=True,
    )


def _linked(code: bytes, argument_kinds: tuple[str, ...]) -> tuple[Any, Callable[..., Any]]:
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
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


def _read(key: str) -> bytes | None:
    """Object file of a key, when it is there, the user's own, and undamaged."""
    folder = cache_folder()
    try:
        if not _is_ours(folder):
            return None
        data = (folder / f"{key}.o").read_bytes()
    except OSError:
        return None
    digest, code = data[:32], data[32:]
    return code if hashlib.sha256(code).digest() == digest else None


def _keep(key: str, code: bytes, source: str) -> None:
    """Write the object file and, for readers, the source beside it; a folder that cannot be written is no error."""
    folder = cache_folder()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if _is_ours(folder):
            _publish(folder / f"{key}.py", source.encode())
            _publish(folder / f"{key}.o", hashlib.sha256(code).digest() + code)
    except OSError:
        return


def _publish(path: Path, data: bytes) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can put machine code there."""
    facts = folder.stat()
    mine = not hasattr(os, "getuid") or facts.st_uid == os.getuid()
    return mine and not facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
