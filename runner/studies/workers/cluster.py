"""A Dask cluster for a study: an existing one, by the address of its scheduler, or workers of this machine."""

import asyncio
import contextlib
import logging
import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from proofmass.blocks.declaration.libraries import cure
from proofmass.blocks.declaration.problem import Problem, shown
from proofmass.runner.run.faults import RunError

LOCAL = "local"
CONNECT_SECONDS = 5
MOST_WORKERS = 1024
STARTS = 4  # of a worker that dies as it starts, one after the other
_ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?[^/\s]+:\d+")


@contextlib.contextmanager
def connected(where: str) -> Iterator[Any]:
    """A client of the cluster: `local`, `local:4`, or an address such as `tcp://10.0.0.5:8786`.

    Raises `ModelError` for any other text, `RunError` if no scheduler answers or Dask is not
    installed.
    """
    count = local_workers(where)
    distributed = _distributed()
    with contextlib.ExitStack() as open_:
        place: Any = where
        if count is None:
            _refuse_silent(distributed, where)
        else:
            place = open_.enter_context(_local_cluster(distributed, count))
        try:
            client = distributed.Client(place, timeout=CONNECT_SECONDS, set_as_default=False)
        except OSError as error:
            raise _no_scheduler(where, error) from None
        yield open_.enter_context(client)


def local_workers(where: str) -> int | None:
    """Return the number of local workers, 0 for as many as processors; None for an address."""
    name, _, number = where.partition(":")
    if name != LOCAL and _ADDRESS.fullmatch(where):
        return None
    if where == LOCAL:
        return 0
    if name == LOCAL and number.isdecimal() and 1 <= int(number) <= MOST_WORKERS:
        return int(number)
    expected = f"local, local:1 to local:{MOST_WORKERS}, or tcp://HOST:PORT"
    raise Problem(message="is not a cluster", key="dask", got=shown(where), expected=expected).error


def _local_cluster(distributed: Any, count: int) -> Any:
    """Start workers that talk to this process alone, over TLS, with a certificate that is never written to disk.

    Otherwise anyone who reaches the scheduler's port, even another user of this machine, can run
    code as its owner. Raises `RunError` if a worker dies each time it starts.
    """
    try:
        security = distributed.Security.temporary()
    except ImportError:
        message = "cryptography is not installed; local workers need it to refuse strangers"
        raise RunError(Problem(message=message, key="dask", hint=cure("cryptography"))) from None
    try:
        return distributed.LocalCluster(
            security=security,
            n_workers=count or None,
            threads_per_worker=1,
            worker_class=_persistent_nanny(distributed),
            dashboard_address="127.0.0.1:0",  # of its pages; any free port
            worker_dashboard_address=None,
            silence_logs=logging.CRITICAL,  # failures of workers are reported here
            preload="proofmass.runner.studies.workers.worker",
        )
    except RuntimeError as error:
        message, got = "local workers do not start", f"{STARTS} tries; {error}"
        hint = "something ends new processes, such as a limit of memory; take fewer workers, or none: leave out --dask"
        raise RunError(Problem(message=message, key="dask", got=got, hint=hint)) from None


def _persistent_nanny(distributed: Any) -> type:
    """Return the nanny of a worker which starts another where that dies as it starts; Dask's own gives up."""

    async def instantiate(self: Any) -> Any:
        known, status = distributed.Status, None
        for _ in range(STARTS):
            status = await distributed.Nanny.instantiate(self)
            if status == known.running or self.status not in (known.init, known.starting, known.running):
                break
        return status

    return type("PersistentNanny", (distributed.Nanny,), {"instantiate": instantiate})


def _refuse_silent(distributed: Any, address: str) -> None:
    """Raise `RunError` if no Dask server answers: a client would wait forever for a server of another kind."""

    async def ask() -> None:
        security = distributed.Security().get_connection_args("client")
        comm = await distributed.comm.connect(address, timeout=CONNECT_SECONDS, **security)
        comm.abort()

    async def ask_in_time() -> None:
        await asyncio.wait_for(ask(), CONNECT_SECONDS + 1)

    try:
        with ThreadPoolExecutor(1) as apart:  # a notebook's thread has a running loop already
            apart.submit(asyncio.run, ask_in_time()).result()
    except OSError as error:
        raise _no_scheduler(address, error) from None


def _distributed() -> Any:
    try:
        # start-up time: distributed takes 0.2 s
        import distributed
    except ImportError:
        raise RunError(Problem(message="Dask is not installed", key="dask", hint=cure("distributed"))) from None
    return distributed


def _no_scheduler(where: str, error: Exception) -> RunError:
    hint = "start one with: dask scheduler; it prints its address, such as tcp://10.0.0.5:8786"
    reason = (str(error) or type(error).__name__).splitlines()[0]
    return RunError(Problem(message=f"no Dask scheduler answers: {reason}", key="dask", got=shown(where), hint=hint))
