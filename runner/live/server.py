"""Serves the windows of a session on this machine alone.

Only 127.0.0.1 is listened to. A request must name this server as its host, and as its origin where
it has one; all but the empty page need a token that only the address in the terminal has, anew at
each start. A page has the server prove that it has the token before it sends it: after this process
has ended, another one may listen to its port. Nothing that a browser sends is evaluated, and the
page may load nothing from elsewhere. With `--edit` the numbers of sliders are written into the
graph file, by names and units that the file has; without it nothing is written.
"""

import hmac
import json
import queue
import secrets
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from proofmass.runner.live.bundle import allowed, elements, styles
from proofmass.runner.live.session import Session
from proofmass.runner.output.page import LivePart, page_text

ADDRESS = "127.0.0.1"
TOKEN, NONCE = "X-Proofmass-Token", "X-Proofmass-Nonce"
_LONGEST_NONCE = 64
_LARGEST = 1 << 20  # bytes of a request
_BEAT = 2.0  # seconds between signs of life
_TIMEOUT = 30.0  # seconds for a request to arrive
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "X-Frame-Options": "DENY",
}
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; form-action 'none'; frame-ancestors 'none'"
_OPENING = "<noscript><p>This page needs scripts. <code>proofmass run --out</code> needs none.</p></noscript>"


class LiveServer(ThreadingHTTPServer):
    """A server of one session; `url` opens it."""

    daemon_threads = True

    def __init__(self, session: Session) -> None:
        self.session, self.token = session, secrets.token_urlsafe(24)
        super().__init__((ADDRESS, 0), _Handler)
        self.hosts = {f"{host}:{self.server_port}" for host in (ADDRESS, "localhost")}
        html = f'<section id="live" data-served="" hidden></section>\n{elements()}'
        more = f"{allowed()}; connect-src 'self'; base-uri 'none'"
        self.policy = _POLICY + more
        self.page = page_text(session.path.name, _OPENING, (), "", LivePart(html, styles(), more)).encode()

    @property
    def url(self) -> str:
        """The address with the token, which browsers do not send to anyone."""
        return f"http://{ADDRESS}:{self.server_port}/#{self.token}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A closed window is not a fault."""


class _Handler(BaseHTTPRequestHandler):
    timeout = _TIMEOUT

    @property
    def _live(self) -> LiveServer:
        assert isinstance(self.server, LiveServer)
        return self.server

    def do_GET(self) -> None:
        if not self._is_ours():
            return self._refuse(HTTPStatus.FORBIDDEN)
        if self.path == "/":
            return self._send(HTTPStatus.OK, self._live.page, "text/html; charset=utf-8")
        if self.path == "/proof":
            return self._prove(self.headers.get(NONCE, ""))
        if not self._has_token():
            return self._refuse(HTTPStatus.FORBIDDEN)
        if self.path == "/events":
            return self._tell()
        return self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        if not self._is_ours(origin=True) or not self._has_token():
            return self._refuse(HTTPStatus.FORBIDDEN)
        data = self._body()
        session, what = self._live.session, self.path.removeprefix("/")
        orders = {"state": session.set_state, "change": session.change, "long": session.long}
        if what in orders:
            return self._refuse(HTTPStatus.NO_CONTENT if orders[what](data) else HTTPStatus.BAD_REQUEST)
        questions = {"diagram": session.drawing, "save": session.save, "undo": session.undo}
        answer = questions[what](data) if what in questions else session.answer(what, data)
        if answer is None:
            return self._refuse(HTTPStatus.BAD_REQUEST)
        return self._send(HTTPStatus.OK, json.dumps(answer).encode(), "application/json")

    def _is_ours(self, origin: bool = False) -> bool:
        """Return whether a request comes from this server's own page; others may know the port."""
        hosts, origins = self.headers.get_all("Host", []), self.headers.get_all("Origin", [])
        if len(hosts) != 1 or hosts[0] not in self._live.hosts or len(origins) > 1:
            return False
        return origins[0] == f"http://{hosts[0]}" if origins else not origin

    def _has_token(self) -> bool:
        given = self.headers.get(TOKEN, "")
        return hmac.compare_digest(given.encode(), self._live.token.encode())

    def _prove(self, nonce: str) -> None:
        """Send what only someone with the token can make of a page's nonce."""
        if not 0 < len(nonce) <= _LONGEST_NONCE:
            return self._refuse(HTTPStatus.BAD_REQUEST)
        proof = hmac.digest(self._live.token.encode(), nonce.encode(), "sha256").hex()
        return self._send(HTTPStatus.OK, proof.encode(), "text/plain")

    def _body(self) -> object:
        """The JSON of a request; None for anything else."""
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or len(length) > 9:
            return None
        if int(length) > _LARGEST:
            self.rfile.read(min(int(length), 2 * _LARGEST))  # unread, it would reset the connection
            return None
        try:
            return json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            return None

    def _tell(self) -> None:
        """Events as they come, until the window is closed."""
        self._head(HTTPStatus.OK, "text/event-stream")
        heard = self._live.session.listen()
        try:
            while True:
                try:
                    message = json.dumps(heard.get(timeout=_BEAT))
                except queue.Empty:
                    message = "{}"
                self.wfile.write(f"data: {message}\n\n".encode())
                self.wfile.flush()
        except OSError:
            return
        finally:
            self._live.session.leave(heard)

    def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        self._head(status, kind, len(body))
        self.wfile.write(body)

    def _refuse(self, status: HTTPStatus) -> None:
        self._send(status, b"", "text/plain")

    def _head(self, status: HTTPStatus, kind: str, length: int | None = None) -> None:
        self.send_response(status)
        headers = {**_HEADERS, "Content-Type": kind, "Content-Security-Policy": self._live.policy}
        if length is not None:
            headers["Content-Length"] = str(length)
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()

    def version_string(self) -> str:
        """The name that answers carry."""
        return "proofmass"

    def log_message(self, format: str, *args: Any) -> None:
        """The terminal shows what was saved, not what was requested."""
