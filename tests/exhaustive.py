"""What `@pytest.mark.exhaustive` marks is left out of a run, unless `--exhaustive` asks for it (`make test-all`).

The last line of a run says how many tests were left out, and how to run them.
"""

from typing import Any

import pytest

OUTPUT = "exhaustive_left_out"  # under this name a process of xdist reports its count


class Exhaustive:
    """Leaves marked tests out, and counts them."""

    def __init__(self, wanted: bool) -> None:
        self.wanted = wanted
        self.count = 0

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Keep what is not marked, and what is if it is wanted."""
        if self.wanted:
            return
        marked = [item for item in items if item.get_closest_marker("exhaustive") is not None]
        items[:] = [item for item in items if item.get_closest_marker("exhaustive") is None]
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
