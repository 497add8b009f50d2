"""Workers of this machine listen to the process that started them, and to nobody else."""

import asyncio
import socket
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
