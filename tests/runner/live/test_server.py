"""The guards of the live server, without a browser: whom it answers, and what it makes of hostile requests."""

import contextlib
import hashlib
import hmac
import socket
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from proofmass.runner.live.server import NONCE, TOKEN
from tests.by_hand.chromium import Process

GRAPH = """
name = "one source"
rate = "1 kHz"
samples = 100
probes = ["push.output"]

[blocks.push]
kind = "Step"
amplitude = "2 uN"
unit = "N"
"""
LARGEST = 1 << 20  # bytes of a request


@pytest.fixture(scope="module")
def process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Process]:
    file = tmp_path_factory.mktemp("live") / "graph.toml"
    file.write_text(GRAPH)
    made = Process(file)
    yield made
    made.kill()


BODY = b'{"state": {"values": {}, "seed": "1", "duration": "1"}}'


def asked(url: str, method: str, path: str, body: bytes = BODY, **headers: str) -> int:
    """Status of the answer to a request."""
    parts = urlsplit(url)
    with contextlib.closing(HTTPConnection("127.0.0.1", parts.port or 0, timeout=10)) as connection:
        connection.putrequest(method, path, skip_host="Host" in headers)
        body = body if method == "POST" else b""
        for name, value in {"Content-Length": str(len(body)), **headers}.items():
            connection.putheader(name, value)
        connection.endheaders(body)
        return connection.getresponse().status


@pytest.mark.exhaustive
def test_others_are_refused(process: Process) -> None:
    """Foreign hosts, origins and tokens; nothing is told to anyone who has no token."""
    parts = urlsplit(process.url)
    host, key = f"127.0.0.1:{parts.port}", {TOKEN: parts.fragment}
    origin = {"Origin": f"http://{host}"}
    assert asked(process.url, "GET", "/", Host=host) == 200
    assert asked(process.url, "POST", "/state", Host=host, **key, **origin) == 204
    assert asked(process.url, "GET", "/", Host="example.org") == 403
    assert asked(process.url, "GET", "/", Host=host, Origin="http://example.org") == 403
    assert asked(process.url, "GET", "/events", Host=host) == 403
    assert asked(process.url, "GET", "/proof", Host="example.org", **{NONCE: "1"}) == 403
    assert asked(process.url, "GET", "/proof", Host=host) == 400
    assert asked(process.url, "GET", "/proof", Host=host, **{NONCE: "1" * 65}) == 400
    assert asked(process.url, "GET", "/proof", Host=host, **{NONCE: "1"}) == 200
    assert asked(process.url, "GET", "/events", Host=host, **{TOKEN: "guess"}) == 403
    assert asked(process.url, "GET", "/etc/passwd", Host=host, **key) == 404
    assert asked(process.url, "POST", "/state", Host=host, **key) == 403
    assert asked(process.url, "POST", "/state", Host=host, **origin) == 403
    assert asked(process.url, "POST", "/change", Host=host, **origin) == 403
    assert asked(process.url, "POST", "/diagram", Host=host, **origin) == 403
    assert asked(process.url, "POST", "/long", Host=host, **origin) == 403
    assert asked(process.url, "POST", "/save", Host=host, **origin) == 403
    assert asked(process.url, "POST", "/undo", Host=host, **origin) == 403
    assert asked(process.url, "POST", "/save", Host=host, **key, **origin) == 400
    assert asked(process.url, "POST", "/undo", Host=host, **key, **origin) == 400
    assert asked(process.url, "POST", "/verdicts", Host=host, **key, **origin) == 200
    assert asked(process.url, "POST", "/long", Host=host, **key, **origin) == 400
    assert asked(process.url, "POST", "/change", Host=host, **key, **origin) == 400
    assert asked(process.url, "POST", "/state", Host="localhost.example.org", **key, **origin) == 403
    assert asked(process.url, "POST", "/__import__", Host=host, **key, **origin) == 400


def raw(process: Process, lines: list[str]) -> int:
    """Status of the answer to a request of these lines."""
    parts = urlsplit(process.url)
    with socket.create_connection(("127.0.0.1", parts.port or 0), timeout=10) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        return int(connection.recv(100).split()[1])


def test_a_header_given_twice_is_refused(process: Process) -> None:
    parts = urlsplit(process.url)
    host, origin = f"Host: 127.0.0.1:{parts.port}", f"Origin: http://127.0.0.1:{parts.port}"
    assert raw(process, ["GET / HTTP/1.1", host]) == 200
    assert raw(process, ["GET / HTTP/1.1", host, origin]) == 200
    assert raw(process, ["GET / HTTP/1.1", host, host]) == 403
    assert raw(process, ["GET / HTTP/1.1"]) == 403
    assert raw(process, ["GET / HTTP/1.1", host, origin, origin]) == 403
    assert raw(process, ["GET / HTTP/1.1", host, origin, "Origin: http://example.org"]) == 403


@pytest.mark.parametrize(("length", "status"), [(LARGEST, 204), (LARGEST + 1, 400)])
def test_a_request_has_a_mebibyte_at_most(process: Process, length: int, status: int) -> None:
    parts = urlsplit(process.url)
    host = f"127.0.0.1:{parts.port}"
    headers = {"Host": host, "Origin": f"http://{host}", TOKEN: parts.fragment}
    assert asked(process.url, "POST", "/state", BODY.ljust(length), **headers) == status


@pytest.mark.parametrize("length", ["-1", "1e3", "", "9" * 10, "0x10"])
def test_lengths_that_are_none_are_refused(process: Process, length: str) -> None:
    parts = urlsplit(process.url)
    host = f"127.0.0.1:{parts.port}"
    headers = {"Host": host, "Origin": f"http://{host}", TOKEN: parts.fragment, "Content-Length": length}
    assert asked(process.url, "POST", "/state", b"", **headers) == 400


@pytest.mark.exhaustive
def test_the_server_proves_that_it_has_the_token_and_tells_it_to_nobody(process: Process) -> None:
    parts = urlsplit(process.url)
    connection = HTTPConnection("127.0.0.1", parts.port or 0, timeout=10)
    connection.request("GET", "/proof", headers={NONCE: "a question"})
    proof = connection.getresponse().read().decode()
    connection.close()
    assert proof == hmac.new(parts.fragment.encode(), b"a question", hashlib.sha256).hexdigest()
    assert parts.fragment not in proof


@pytest.mark.exhaustive
@pytest.mark.defect("S562", before="the next start has the same port and token", after="a new token at each start")
def test_each_start_has_a_token_of_its_own(process: Process, tmp_path: Path) -> None:
    file = tmp_path / "graph.toml"
    file.write_text(GRAPH)
    first = Process(file)
    first.kill()
    second = Process(file)
    second.kill()
    assert len({urlsplit(each.url).fragment for each in (process, first, second)}) == 3
