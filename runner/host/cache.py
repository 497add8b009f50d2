"""Machine code in the user's own folder, read only if nobody else could have written it and it is undamaged."""

import hashlib
import os
import stat
import tempfile
from pathlib import Path


def cache_folder() -> Path:
    """Return the folder of compiled loops: `PROOFMASS_CACHE`, or in the user's cache folder."""
    named = os.environ.get("PROOFMASS_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "proofmass"


def kept(name: str) -> bytes | None:
    """Return the code stored under a name, if it exists, belongs to the user and is undamaged."""
    folder = cache_folder()
    try:
        if not _is_ours(folder):
            return None
        data = (folder / name).read_bytes()
    except OSError:
        return None
    digest, code = data[:32], data[32:]
    return code if hashlib.sha256(code).digest() == digest else None


def keep(name: str, code: bytes) -> None:
    """Write code; a folder that cannot be written to is not an error."""
    folder = cache_folder()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if _is_ours(folder):
            _publish(folder / name, hashlib.sha256(code).digest() + code)
    except OSError:
        return


def _publish(path: Path, data: bytes) -> None:
    """Write a file that is there whole or not at all, but for a machine that loses power: then its hash tells."""
    handle, temporary = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _is_ours(folder: Path) -> bool:
    """Return whether nobody else can put machine code there."""
    facts = folder.stat()
    mine = not hasattr(os, "getuid") or facts.st_uid == os.getuid()
    return mine and not facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
