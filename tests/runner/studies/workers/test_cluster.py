"""Workers of this machine listen to the process that started them, and to nobody else."""

import asyncio
import contextlib
import multiprocessing
import socket
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import distributed
import pytest

from proofmass.runner.run.faults import RunError
from proofmass.runner.studies.workers import cluster
from proofmass.runner.studies.workers.cluster import connected


def reached(address: str, **security: Any) -> bool:
    """Whether a stranger's greeting is answered at an address."""

    async def greet() -> None:
        comm = await distributed.comm.connect(address, timeout=2, **security)
        await comm.write({"op": "identity", "reply": True})
        await asyncio.wait_for(comm.read(), 2)
        comm.abort()

    try:
        with ThreadPoolExecutor(1) as apart:
            apart.submit(asyncio.run, greet()).result()
    except (TimeoutError, OSError, RuntimeError):
        return False
    return True


@pytest.mark.exhaustive
@pytest.mark.defect("D1", before="any user of the machine could run code", after="TLS, own certificate")
def test_strangers_are_not_answered_by_local_workers() -> None:
    with connected("local:1") as client:
        assert client.submit(sum, [1, 2, 3]).result(timeout=60) == 6
        addresses = [client.scheduler.address, *client.scheduler_info()["workers"]]
        assert all(address.startswith("tls://") for address in addresses)
        for address in addresses:
            plain = "tcp://" + address.removeprefix("tls://")
            assert not reached(plain)
            own = distributed.Security.temporary().get_connection_args("client")
            assert not reached(address, **own)
        known = client.security.get_connection_args("client")
        assert reached(addresses[0], **known)


@contextlib.contextmanager
def killed_as_they_start(most: int, delay: float) -> Iterator[list[int]]:
    """Kill the first `most` worker processes so many seconds after they begin; yields their numbers."""
    killed, end = list[int](), threading.Event()

    def kill() -> None:
        while not end.wait(0.005):
            for process in multiprocessing.active_children():
                if process.pid and process.pid not in killed and len(killed) < most:
                    time.sleep(delay)
                    process.kill()
                    killed.append(process.pid)

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        yield killed
    finally:
        end.set()
        thread.join()


@pytest.mark.exhaustive
@pytest.mark.parametrize("delay", [0.0, 0.2])
@pytest.mark.defect("C201", before="an error inside proofmass: Nanny failed to start", after="another worker starts")
def test_a_worker_that_dies_as_it_starts_is_replaced(delay: float) -> None:
    with killed_as_they_start(2, delay) as killed, connected("local:1") as client:
        assert client.submit(sum, [1, 2, 3]).result(timeout=60) == 6
        assert len(killed) == 2


@pytest.mark.defect("C202", before="an error inside proofmass: Nanny failed to start", after="says what happened")
def test_workers_that_die_each_time_they_start() -> None:
    refused = pytest.raises(RunError, match="local workers do not start")
    with killed_as_they_start(100, 0.0), refused, connected("local:1"):
        pass


@pytest.mark.defect("C6", before="RuntimeError of asyncio, in a notebook", after="no Dask scheduler answers")
def test_in_a_notebook_whose_thread_has_a_running_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.2)

    async def cell() -> None:
        with socket.create_server(("127.0.0.1", 0)) as silent:
            place = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
            with pytest.raises(RunError, match="no Dask scheduler answers"), connected(place):
                pass

    with ThreadPoolExecutor(1) as apart:
        apart.submit(asyncio.run, cell()).result()
