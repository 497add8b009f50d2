"""Rows of a table in an SQLite file, read from its pages: each row on whole pages, whatever is damaged beside.

SQLite itself finds a row by the pages above it: one of them damaged hides thousands of whole rows.
Form: https://sqlite.org/fileformat2.html, sections 1.6 (pages), 2.1 (records) and 4.1 (the log of
pages that are not yet in the file).
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

PAGE = 4096  # bytes
_LEAF = 13  # first byte of a page with rows
_FILE_HEAD, _LOG_HEAD, _FRAME_HEAD = 100, 32, 24
_INTEGERS = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 6: 8}  # bytes by type
_MOST, _LEAST = PAGE - 35, (PAGE - 12) * 32 // 255 - 23  # bytes of a row on its own page


def stored_rows(path: Path) -> Iterator[list[Any]]:
    """Yield the rows of all tables of a file, the number of each before its columns; damaged ones may be anything."""
    pages, log = _pages(path.read_bytes()), Path(f"{path}-wal")
    yield from _rows(pages)
    if log.exists():  # it may have been cut off while it was written: the file has its rows too
        yield from _rows(pages | _logged(log.read_bytes()))


def _rows(pages: Mapping[int, bytes]) -> Iterator[list[Any]]:
    for number, page in pages.items():
        head = _FILE_HEAD if number == 1 else 0
        if page[head] != _LEAF:
            continue
        for place in range(_number(page, head + 3, 2)):
            with suppress(IndexError, KeyError, ValueError):
                yield _row(pages, page, _number(page, head + 8 + 2 * place, 2))


def _pages(data: bytes) -> dict[int, bytes]:
    """Return whole pages by their numbers, from 1."""
    return {at // PAGE + 1: data[at : at + PAGE] for at in range(0, len(data) - PAGE + 1, PAGE)}


def _logged(log: bytes) -> dict[int, bytes]:
    """Return the last form of each page in a log, but of earlier logs in the same file."""
    frames = (log[at : at + _FRAME_HEAD + PAGE] for at in range(_LOG_HEAD, len(log), _FRAME_HEAD + PAGE))
    whole = (frame for frame in frames if len(frame) == _FRAME_HEAD + PAGE and frame[8:16] == log[16:24])
    return {_number(frame, 0, 4): frame[_FRAME_HEAD:] for frame in whole}


def _row(pages: Mapping[int, bytes], page: bytes, at: int) -> list[Any]:
    """Return number and columns of a row; raises `KeyError`, `ValueError`, `IndexError` where it has no form."""
    size, at = _varint(page, at)
    number, at = _varint(page, at)
    if size > PAGE * len(pages):
        raise ValueError(size)
    here = size if size <= _MOST else _LEAST + (size - _LEAST) % (PAGE - 4)
    here = _LEAST if here > _MOST else here
    parts, left = [page[at : at + here]], size - here
    following = _number(page, at + here, 4) if left else 0
    while left:
        page = pages[following]
        parts.append(page[4 : 4 + left])
        left -= len(parts[-1])
        following = _number(page, 0, 4)
    return [number, *_columns(b"".join(parts))]


def _columns(record: bytes) -> Iterator[Any]:
    end, place = _varint(record, 0)
    at = end
    while place < end:
        kind, place = _varint(record, place)
        size = _INTEGERS.get(kind, 0) if kind < 12 else (kind - 12) // 2
        entry = record[at : at + size]
        at += size
        if kind >= 12:
            yield entry.decode() if kind % 2 else entry
        else:
            yield {0: None, 8: 0, 9: 1}.get(kind, int.from_bytes(entry, signed=True))


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """Return an integer of one to nine bytes, and the place behind it."""
    value = 0
    for place in range(at, at + 8):
        value = value << 7 | data[place] & 127
        if data[place] < 128:
            return value, place + 1
    return value << 8 | data[at + 8], at + 9


def _number(data: bytes, at: int, size: int) -> int:
    return int.from_bytes(data[at : at + size])
