"""The server of a page beside the robot: it shows a state as it changes, and can stop the robot.

It answers under an unguessable token only: the page, its stream of states, Stop, and what else its
buttons do. Host and Origin are checked, so that no other page in the same browser reaches it.
"""

from __future__ import annotations

import json
import secrets
import socket
import socketserver
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from ...model.errors import BadInput, SerpenoidError
from . import filled

BEAT_S = 1.0  # a stream that is silent for three of these is lost, the page says
MOST_STREAMS = 16
MOST_SILENT = 32  # connections without a request that is allowed; one more ends the oldest
LAST_WORD_S = 0.5
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'nonce-{nonce}'; connect-src 'self'"
)
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
State = dict[str, Any]


class Page:
    """Serve one page while `with Page(...) as page:` lasts; publish() sends it a new state.

    html: the page, with @NONCE@ in its script's tag, @STYLE@ and @LIVE@ where page.css and live.js
    belong. stop: stops
    the robot now, from any thread; None where there is no robot. lan: reachable from other
    machines, too. buttons: what other buttons do, by their names; each returns what to show.
    """

    def __init__(
        self,
        html: str,
        stop: Callable[[], None] | None = None,
        *,
        lan: bool = False,
        port: int = 0,
        buttons: Mapping[str, Callable[[], str]] | None = None,
    ):
        self.buttons = dict(buttons or {})
        self.token = secrets.token_urlsafe(18)
        self.html, self.stop = filled(html, STYLE="page.css", LIVE="live.js"), stop
        self.nonce = secrets.token_urlsafe(12)
        self.streams = threading.BoundedSemaphore(MOST_STREAMS)
        self._changed = threading.Condition()
        self._state = "{}"
        self._version = 0
        self._closed = False
        try:
            self._server = _Server(self, lan, port)
        except (OSError, OverflowError) as error:
            why = getattr(error, "strerror", None) or error
            raise BadInput(f"port {port} cannot be served: {why}") from error
        self.port: int = self._server.server_address[1]
        names = ["127.0.0.1", "localhost"]
        self.name = names[0]
        if lan:
            names += [*lan_addresses(), socket.gethostname()]
            self.name = names[2]
        self.hosts = frozenset(f"{name}:{self.port}".lower() for name in names)
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    def __enter__(self) -> Page:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        # the open pages hear the last state; a phone out of reach is not waited for
        end_s = time.monotonic() + LAST_WORD_S
        free = [
            self.streams.acquire(timeout=max(0.0, end_s - time.monotonic()))
            for _ in range(MOST_STREAMS)
        ]
        for _ in filter(None, free):
            self.streams.release()
        self._server.shutdown()
        self._server.server_close()

    @property
    def url(self) -> str:
        """Return the address to open; whoever knows it can look, stop and press its buttons."""
        return f"http://{self.name}:{self.port}/{self.token}/"

    def publish(self, state: State) -> None:
        """Show a new state on every open page."""
        with self._changed:
            self._state = json.dumps(state, allow_nan=False)
            self._version += 1
            self._changed.notify_all()

    def next_state(self, seen: int) -> tuple[int, str | None] | None:
        """Return version and state once newer than `seen`, the state None after a beat without.

        Return None when the page is closed, and its last state seen.
        """
        with self._changed:
            if self._version == seen and not self._closed:
                self._changed.wait(BEAT_S)
            if self._closed and self._version == seen:
                return None
            return self._version, None if self._version == seen else self._state


def lan_addresses() -> list[str]:
    """Return this machine's addresses in the local net, as a URL has them; nothing is sent.

    At least one name comes back: of a machine without a net it is 127.0.0.1.
    """
    names = []
    for family, far in (  # addresses of documentation, RFC 5737 and RFC 3849
        (socket.AF_INET, "192.0.2.1"),
        (socket.AF_INET6, "2001:db8::1"),
    ):
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as probe:
                probe.connect((far, 9))
                own = str(probe.getsockname()[0])
        except OSError:
            continue
        names.append(f"[{own}]" if family == socket.AF_INET6 else own)
    return names or ["127.0.0.1"]


class _Server(ThreadingHTTPServer):
    """Listen; connections that never show the token cannot use up this program's files."""

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, page: Page, lan: bool, port: int):
        self.page = page
        self._silent: dict[socket.socket, None] = {}  # the oldest first
        self._lock = threading.Lock()
        both = lan and socket.has_dualstack_ipv6()
        self.address_family = socket.AF_INET6 if both else socket.AF_INET
        address = "::" if both else "0.0.0.0" if lan else "127.0.0.1"
        super().__init__((address, port), _Request)

    def server_bind(self) -> None:
        """Bind, and ask no name server for this machine's name, as HTTPServer does."""
        if self.address_family == socket.AF_INET6:
            self.socket.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
        socketserver.TCPServer.server_bind(self)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Count a new connection as silent, and give it a thread."""
        self.silent(request)
        super().process_request(request, client_address)

    def silent(self, connection: socket.socket) -> None:
        """Count a connection as silent; of too many the oldest is ended."""
        with self._lock:
            self._silent[connection] = None
            extra = list(self._silent)[:-MOST_SILENT]
            for oldest in extra:
                del self._silent[oldest]
        for oldest in extra:
            with suppress(OSError):  # it is closed already
                oldest.shutdown(socket.SHUT_RDWR)  # its thread sees the end and closes it

    def heard(self, connection: socket.socket) -> None:
        """Count a connection as silent no longer: its request is allowed, or it ends."""
        with self._lock:
            self._silent.pop(connection, None)

    def shutdown_request(self, request: Any) -> None:
        """Forget a connection that ends."""
        self.heard(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Stay silent about a connection that broke: the terminal belongs to the dialogue."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


class _Request(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: _Server  # pyright: ignore[reportIncompatibleVariableOverride]
    timeout = 30.0

    def handle_one_request(self) -> None:
        """Wait for a request, as a silent connection."""
        self.server.silent(self.connection)
        super().handle_one_request()

    def do_GET(self) -> None:
        """Answer for the page or its stream."""
        page = self.server.page
        if not self._allowed():
            return self._refuse()
        if self.path == f"/{page.token}/":
            return self._send(200, page.html.replace("@NONCE@", page.nonce), "text/html")
        if self.path == f"/{page.token}/states":
            return self._stream()
        return self._refuse()

    def do_POST(self) -> None:
        """Stop the robot or do what a button does, if the request comes from the page itself."""
        page = self.server.page
        origin = self.headers.get("Origin", "")
        own = origin.lower() == f"http://{self.headers.get('Host', '')}".lower()
        name = self.path.removeprefix(f"/{page.token}/")
        if not (self._allowed() and own and (name == "stop" or name in page.buttons)):
            return self._refuse()
        status, answer = 200, {}
        try:
            if name != "stop":
                answer["shown"] = page.buttons[name]()
            elif page.stop is None:
                status, answer["error"] = 409, "no robot: it is set by hand"
            else:
                page.stop()
                answer["stopped"] = True
        except SerpenoidError as error:
            status, answer["error"] = 500, str(error)
        return self._send(status, json.dumps(answer))

    def log_message(self, format: str, *args: object) -> None:
        """Stay silent: the terminal belongs to the dialogue."""

    def _allowed(self) -> bool:
        page = self.server.page
        token = self.path.split("/")[1] if "/" in self.path else ""
        told = secrets.compare_digest(token.encode(), page.token.encode())
        allowed = told and self.headers.get("Host", "").lower() in page.hosts
        if allowed:
            self.server.heard(self.connection)
        return allowed

    def _refuse(self) -> None:
        self.close_connection = True
        self._send(404, "not here", "text/plain")

    def _send(self, status: int, text: str, kind: str = "application/json") -> None:
        data = text.encode()
        self.send_response(status)
        self._headers(kind)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def _headers(self, kind: str) -> None:
        policy = POLICY.format(nonce=self.server.page.nonce)
        kinds = {"Content-Type": f"{kind}; charset=utf-8", "Content-Security-Policy": policy}
        for name, value in (HEADERS | kinds).items():
            self.send_header(name, value)

    def _stream(self) -> None:
        page = self.server.page
        if not page.streams.acquire(blocking=False):
            return self._send(503, "too many pages are open", "text/plain")
        try:
            self.close_connection = True
            self.send_response(200)
            self._headers("text/event-stream")
            self.end_headers()
            seen = -1
            while (told := page.next_state(seen)) is not None:
                seen, state = told
                text = "event: beat\ndata: 1\n\n" if state is None else f"data: {state}\n\n"
                self.wfile.write(text.encode())
                self.wfile.flush()
        except OSError:
            pass  # the page was closed, or the phone went out of reach
        finally:
            page.streams.release()
        return None
