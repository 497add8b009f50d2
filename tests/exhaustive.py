"""What `@pytest.mark.exhaustive` marks is left out of a run, unless `--exhaustive` asks for it (`make test-all`).

    @pytest.mark.exhaustive                    the test, with all its cases
    @pytest.mark.exhaustive("noise", "worst")  its cases that have such a word in their name
    @pytest.mark.exhaustive(but=3)             its cases but three, evenly spaced

The last line of a run says how many tests were left out, and how to run them.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

import pytest

OUTPUT = "exhaustive_left_out"  # under this name a process of xdist reports its count


def left_out(items: Sequence[pytest.Item]) -> Iterator[pytest.Item]:
    """Tests that only an exhaustive run has."""
    spaced: dict[tuple[str, int], list[pytest.Item]] = defaultdict(list)
    for item in items:
        marks = list(item.iter_markers("exhaustive"))
        name = item.nodeid.partition("[")[2]
        if any(not mark.kwargs and (not mark.args or any(word in name for word in mark.args)) for mark in marks):
            yield item
            continue
        for mark in marks:
            if mark.kwargs:
                spaced[item.nodeid.partition("[")[0], mark.kwargs["but"]].append(item)
    for (_, stay), cases in spaced.items():
        kept = {len(cases) * n // stay for n in range(stay)}
        yield from (case for place, case in enumerate(cases) if place not in kept)


class Exhaustive:
    """Leaves marked tests out, and counts them."""

    def __init__(self, wanted: bool) -> None:
        self.wanted = wanted
        self.count = 0

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Keep what is not marked, and what is if it is wanted."""
        if self.wanted:
            return
        marked = list(left_out(items))
        out = set(marked)
        items[:] = [item for item in items if item not in out]
        if marked:
            config.hook.pytest_deselected(items=marked)
        self.count = len(marked)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Report the count of a process of xdist to the one that prints."""
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput[OUTPUT] = self.count

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take the count of a process that ended; every one of them collects everything."""
        self.count = getattr(node, "workeroutput", {}).get(OUTPUT, self.count)

    @pytest.hookimpl(trylast=True)
    def pytest_unconfigure(self, config: pytest.Config) -> None:
        """Print the line, in the process that reports."""
        reporter = config.pluginmanager.get_plugin("terminalreporter")
        if reporter is None or hasattr(config, "workerinput") or not self.count:
            return
        reporter.ensure_newline()
        reporter.write_line(f"left out: {self.count:,} exhaustive (make test-all)", yellow=True)


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--exhaustive` runs what is marked too."""
    parser.addoption("--exhaustive", action="store_true", help="run what is marked as exhaustive too")


def pytest_configure(config: pytest.Config) -> None:
    """Give this run its counter."""
    config.pluginmanager.register(Exhaustive(config.getoption("--exhaustive")))
