"""A process of xdist tells how a test went in one message, not in six: they took a tenth of all time.

Left out is that a test begins and ends, and that its set-up and its end went well. Who asks how long
these took is told all.
"""

import pytest
from _pytest.runner import runtestprotocol


def is_enough(config: pytest.Config) -> bool:
    """Return whether this is a process of xdist, and none asks for the parts of a test."""
    parts = config.getoption("durations") is not None or config.getoption("xmlpath") is not None
    return hasattr(config, "workerinput") and not parts and not config.pluginmanager.has_plugin("tests.coverage")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool:
    """Run a test, and report its call and what went wrong."""
    for report in runtestprotocol(item, log=False, nextitem=nextitem):
        if report.when == "call" or not report.passed:
            item.ihook.pytest_runtest_logreport(report=report)
    return True
