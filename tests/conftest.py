"""What all tests share: a cache of compiled loops for the run, no deadlines, last lines on what did not run."""

import gc
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

from tests import exhaustive, one_message, skips
from tests.defects import DefectTable
from tests.derivations import DerivationTable
from tests.friendliness import FriendlinessTable

hypothesis.settings.register_profile("sample", deadline=None, max_examples=50)
hypothesis.settings.register_profile("exhaustive", deadline=None, max_examples=500)


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--defects`, `--derivations`, `--friendliness`: tables of marks; `--exhaustive`: what takes minutes too."""
    exhaustive.pytest_addoption(parser)
    parser.addoption("--defects", action="store_true", help="print defect, test, before and after as a table")
    parser.addoption("--derivations", action="store_true", help="print what each block of physics is compared with")
    parser.addoption("--friendliness", action="store_true", help="print what a person does and expects, with points")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Keep the garbage collector from looking through thousands of tests again and again: a fifth of all time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()
        gc.set_threshold(100_000, 50, 100)


@pytest.hookimpl(tryfirst=True)
def pytest_unconfigure() -> None:
    """Collect what a session leaves once, before pytest looks for errors in it five times."""
    gc.collect()
    gc.freeze()


def pytest_configure(config: pytest.Config) -> None:
    """Before anything is collected, and for every process that a test starts or that runs tests beside this one."""
    sys.dont_write_bytecode = False  # or 800 files of tests would be compiled anew, a third of a collection
    hypothesis.settings.load_profile("exhaustive" if config.getoption("--exhaustive") else "sample")
    config.pluginmanager.register(exhaustive.Exhaustive(config.getoption("--exhaustive")))
    config.pluginmanager.register(skips)
    if config.getoption("--defects"):
        config.pluginmanager.register(DefectTable())
    if config.getoption("--derivations"):
        config.pluginmanager.register(DerivationTable())
    if config.getoption("--friendliness"):
        config.pluginmanager.register(FriendlinessTable())
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as of what a shell starts in the background
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if one_message.is_enough(config):
        config.pluginmanager.register(one_message)
    if hasattr(config, "workerinput"):  # such a process: the folder is there
        return
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # matrices of tests are small: more threads would wait for each other
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # or hundreds of processes would each compile the package anew
    folder = tempfile.mkdtemp(prefix="proofmass-tests-")
    os.environ["PROOFMASS_CACHE"] = str(Path(folder) / "cache")
    config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
