"""The page server under attack: connections that say nothing, break off, or come by IPv6."""

import http.client
import socket
import struct
import subprocess
import sys

from refusals import refused
from robot.patience import LONG_S, until
from serpenoid.show.pages.server import Page, lan_addresses

FEW_FILES = """
import resource, sys
resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256))
from serpenoid.show.pages.server import Page
with Page("<p>", lambda: print("stopped", flush=True)) as page:
    print(page.port, page.token, flush=True)
    sys.stdin.read()
"""


def press(name, port, token):
    """Return the status of a click on Stop."""
    connection = http.client.HTTPConnection(name, port, timeout=LONG_S)
    own = f"[{name}]" if ":" in name else name
    connection.request("POST", f"/{token}/stop", headers={"Origin": f"http://{own}:{port}"})
    status = connection.getresponse().status
    connection.close()
    return status


def test_stop_is_heard_among_400_silent_connections_with_256_files():
    server = subprocess.Popen(
        [sys.executable, "-c", FEW_FILES],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    port, token = server.stdout.readline().split()
    silent = []
    for _ in range(400):
        silent.append(socket.create_connection(("127.0.0.1", int(port)), timeout=LONG_S))
        silent[-1].sendall(b"GET /wrong")  # half a request
    assert press("127.0.0.1", int(port), token) == 200
    assert server.stdout.readline() == "stopped\n"
    for connection in silent:
        connection.close()
    _, errors = server.communicate("", timeout=LONG_S)
    assert (server.returncode, errors) == (0, "")


def test_connections_that_break_off_print_nothing(capfd):
    at_once = struct.pack("ii", 1, 0)  # SO_LINGER: close() sends a reset
    with Page("<p>" * 200_000, lambda: None) as page:
        for said in (
            b"",
            b"GET / HTT",
            f"GET /{page.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\n\r\n".encode(),
        ):
            for _ in range(10):
                connection = socket.create_connection(("127.0.0.1", page.port), timeout=LONG_S)
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, at_once)
                connection.sendall(said)
                connection.close()
        assert press("127.0.0.1", page.port, page.token) == 200
        assert until(lambda: not page._server._silent)
    assert capfd.readouterr() == ("", "")


def test_both_internet_protocols_reach_a_page_for_the_net():
    stops = []
    with Page("<p>", lambda: stops.append(1), lan=True) as page:
        names = [name.strip("[]") for name in lan_addresses()] + ["127.0.0.1"]
        for name in names:
            assert press(name, page.port, page.token) == 200
        assert page.name in lan_addresses()
    assert len(stops) == len(names)


def test_a_port_that_is_none_is_refused():
    with refused("99999"):
        Page("<p>", port=99999)
