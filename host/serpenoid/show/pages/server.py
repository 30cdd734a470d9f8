"""The server of a page beside the robot: it shows a state as it changes, and can stop the robot.

It answers under an unguessable token only: the page, its stream of states, Stop, and what else its
buttons do. Host and Origin are checked, so that no other page in the same browser reaches it.
"""

from __future__ import annotations

import json
import secrets
import socket
import threading
import time
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from ...model.errors import BadInput, SerpenoidError

BEAT_S = 1.0  # a stream that is silent for three of these is lost, the page says
MOST_STREAMS = 16
LAST_WORD_S = 0.5
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'nonce-{nonce}'; connect-src 'self'"
)
State = dict[str, Any]


class Page:
    """Serve one page while `with Page(...) as page:` lasts; publish() sends it a new state.

    html: the page, with @NONCE@ in its script's tag. stop: stops the robot now, from any thread;
    None where there is no robot. lan: reachable from other machines, too. buttons: what other
    buttons do, by their names; each returns what to show.
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
        self.html, self.stop = html, stop
        self.nonce = secrets.token_urlsafe(12)
        self.streams = threading.BoundedSemaphore(MOST_STREAMS)
        self._changed = threading.Condition()
        self._state = "{}"
        self._version = 0
        self._closed = False
        address = "0.0.0.0" if lan else "127.0.0.1"
        try:
            self._server = _Server((address, port), _Request)
        except OSError as error:
            raise BadInput(f"port {port} cannot be served: {error.strerror}") from error
        self._server.page = self
        self._server.daemon_threads = True
        self.port: int = self._server.server_address[1]
        names = ["127.0.0.1", "localhost"]
        self.name = names[0]
        if lan:
            self.name = lan_address()
            names += [self.name, socket.gethostname()]
        self.hosts = frozenset(f"{name}:{self.port}".lower() for name in names)
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    def __enter__(self) -> Page:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._wait_for_streams()
        self._server.shutdown()
        self._server.server_close()

    def _wait_for_streams(self) -> None:
        """Let the open pages hear the last state; a phone out of reach is not waited for."""
        end_s = time.monotonic() + LAST_WORD_S
        free = [
            self.streams.acquire(timeout=max(0.0, end_s - time.monotonic()))
            for _ in range(MOST_STREAMS)
        ]
        for _ in filter(None, free):
            self.streams.release()

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


def lan_address() -> str:
    """Return this machine's address in the local net; nothing is sent to find it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address of documentation, RFC 5737
            return str(probe.getsockname()[0])
        except OSError:
            return "127.0.0.1"


class _Server(ThreadingHTTPServer):
    page: Page


class _Request(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: _Server  # pyright: ignore[reportIncompatibleVariableOverride]
    timeout = 30.0

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
        if name != "stop":
            return self._press(page.buttons[name])
        if page.stop is None:
            return self._send(409, json.dumps({"error": "no robot: it is set by hand"}))
        try:
            page.stop()
        except SerpenoidError as error:
            return self._send(500, json.dumps({"error": str(error)}))
        return self._send(200, json.dumps({"stopped": True}))

    def _press(self, button: Callable[[], str]) -> None:
        try:
            return self._send(200, json.dumps({"shown": button()}))
        except SerpenoidError as error:
            return self._send(500, json.dumps({"error": str(error)}))

    def log_message(self, format: str, *args: object) -> None:
        """Stay silent: the terminal belongs to the dialogue."""

    def _allowed(self) -> bool:
        page = self.server.page
        token = self.path.split("/")[1] if "/" in self.path else ""
        told = secrets.compare_digest(token.encode(), page.token.encode())
        return told and self.headers.get("Host", "").lower() in page.hosts

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
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("X-Frame-Options", "DENY")
        policy = POLICY.format(nonce=self.server.page.nonce)
        self.send_header("Content-Security-Policy", policy)

    def _stream(self) -> None:
        page = self.server.page
        if not page.streams.acquire(blocking=False):
            return self._send(503, "too many pages are open", "text/plain")
        try:
            self.close_connection = True
            self.send_response(200)
            self._headers("text/event-stream")
            self.end_headers()
            self._follow(page)
        except OSError:
            pass  # the page was closed, or the phone went out of reach
        finally:
            page.streams.release()
        return None

    def _follow(self, page: Page) -> None:
        seen = -1
        while (told := page.next_state(seen)) is not None:
            seen, state = told
            text = "event: beat\ndata: 1\n\n" if state is None else f"data: {state}\n\n"
            self.wfile.write(text.encode())
            self.wfile.flush()
