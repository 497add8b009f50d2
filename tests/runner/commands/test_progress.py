"""The progress bar: what a terminal of any width shows of it, and that nothing of it is left."""

import io
import os
import re
import shutil
import sys
import time

import pytest

from proofmass.runner.commands import progress
from proofmass.runner.commands.progress import PREPARING, ProgressBar, Working

NOTE = "bias 6553.69(77), noise 81.2(24) mV, settled 0.471(14) s, a_rather_long_name_of_a_measure 1.5(2)"


class Screen(io.StringIO):
    """A terminal that knows the codes of the bar: rows of letters, and a place to write at."""

    def __init__(self) -> None:
        super().__init__()
        self.rows, self.row, self.most = [""], 0, 0

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        for up, erase, plain in re.findall(r"\x1b\[(\d+)A|(\x1b\[J)|([^\x1b])", text):
            if up:
                self.row -= int(up)
            elif erase:
                self.rows[self.row :] = [""]
            elif plain == "\n":
                self.row += 1
                self.rows[self.row :] = [""]
            elif plain != "\r":
                self.rows[self.row] += plain
            assert self.row >= 0
        self.most = max(self.most, *map(len, self.rows))
        return len(text)


@pytest.mark.parametrize("columns", [200, 100, 60, 20])
@pytest.mark.friendly(23, "a bar with the time left, erased at the end")
def test_what_is_drawn_and_left(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    screen, clock = Screen(), iter(range(100))
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(shutil, "get_terminal_size", lambda **_: os.terminal_size((columns, 30)))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(clock)))
    screen.write("$ proofmass montecarlo\n")
    with ProgressBar("run") as bar:
        bar(1000, 6000, "")
        for done in (2000, 3000):
            bar(done, 6000, NOTE)
            first, shown, *known = screen.rows
            assert first == "$ proofmass montecarlo"
            assert shown.startswith(f"{100 * done / 6000:3.0f} %")
            assert ", ".join(known) == NOTE if columns > 50 else len(known) == 4
            if columns > 50:
                assert f"{done:,} of 6,000 runs" in shown
                assert " s left" in shown
                assert ("#" in shown) == (columns > 70)
            assert screen.most < max(columns, len(first) + 1)
        bar(6000, 6000, NOTE)
    assert screen.rows == ["$ proofmass montecarlo", ""]


def shown_within(screen: Screen, text: str) -> bool:
    """Whether a text comes to the screen within a few seconds."""
    ends = time.monotonic() + 10.0
    while time.monotonic() < ends and text not in screen.rows[-1]:
        time.sleep(0.01)
    return text in screen.rows[-1]


def test_what_takes_long_is_named_and_erased(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(progress, "PATIENCE", 0.01)
    with Working("writing the report") as line:
        assert shown_within(screen, "writing the report")
        line("study.nc, 2 of 5")
        assert screen.rows == ["study.nc, 2 of 5"]
    assert screen.rows == [""]
    with ProgressBar("tick") as bar:
        assert shown_within(screen, PREPARING[:40])
        bar(0, 10)
        assert screen.rows == [""]


def test_what_is_soon_done_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    with Working("writing the report"):
        pass
    assert screen.most == 0
