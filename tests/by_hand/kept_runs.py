"""What a ledger holds on disk, read without the code that wrote it."""

import sqlite3
from pathlib import Path


def kept(path: Path) -> dict[int, bytes]:
    """Numbers of each run in the ledger as they are on disk; none before there is one."""
    if not path.exists():
        return {}
    data = sqlite3.connect(path)
    try:
        found: dict[int, bytes] = {}
        for first, runs, held in data.execute("SELECT first, runs, numbers FROM stretches"):
            length = len(held) // runs
            for place in range(runs):
                assert first + place not in found, "a run twice"
                found[first + place] = held[place * length : (place + 1) * length]
        return found
    except sqlite3.OperationalError:
        return {}
    finally:
        data.close()
