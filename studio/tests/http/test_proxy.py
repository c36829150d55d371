"""The proxy of `deploy/` in front of a server, which leaves silent and slow connections to it.  Each test names the
wrong implementation it catches."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

ASK = b"GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
CADDYFILE = Path(__file__).parents[3] / "deploy" / "Caddyfile"


class Upstream(BaseHTTPRequestHandler):
    """Stands for the studio: counts who reaches it."""

    reached = 0

    def setup(self) -> None:
        super().setup()
        Upstream.reached += 1

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Length", "0")
        self.end_headers()


@pytest.fixture
def upstream() -> Iterator[int]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Upstream) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.server_address[1]
        server.shutdown()


def connected(port: int) -> socket.socket:
    """A connection, as soon as something listens."""
    for _ in range(200):
        with contextlib.suppress(OSError):
            return socket.create_connection(("127.0.0.1", port), timeout=20)
        time.sleep(0.05)
    raise AssertionError("the proxy does not start")


def test_the_proxy_takes_silence_on_itself(upstream: int, tmp_path: Path) -> None:
    """Catches: a directive that the proxy does not know; one that hands each connection on, or keeps silent ones for
    ever; what workers ask, reached from outside.
    """
    if shutil.which("caddy") is None:
        pytest.skip("caddy is not installed")
    text = CADDYFILE.read_text(encoding="utf-8")
    assert text.count("studio:8000") == text.count("read_header 10s") == 1
    text = text.replace("studio:8000", f"127.0.0.1:{upstream}").replace("read_header 10s", "read_header 1s")
    (tmp_path / "Caddyfile").write_text(text.replace("{\n", "{\n\tadmin off\n", 1))
    with socket.create_server(("127.0.0.1", 0)) as one:
        front = one.getsockname()[1]
    command = ["caddy", "run", "--config", str(tmp_path / "Caddyfile"), "--adapter", "caddyfile"]
    environment = os.environ | {"SITE": f"http://127.0.0.1:{front}", "HOME": str(tmp_path)}
    with (
        subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL) as proxy,
        contextlib.ExitStack() as stack,
    ):
        stack.callback(proxy.terminate)
        flood = [stack.enter_context(connected(front)) for _ in range(60)]
        for path, status in ((b"/", b"200"), (b"/metrics", b"404"), (b"/work/film", b"404")):
            asker = stack.enter_context(connected(front))
            asker.sendall(ASK.replace(b"x", f"127.0.0.1:{front}".encode()).replace(b" / ", b" " + path + b" "))
            assert asker.recv(15).split()[1] == status
        # Until the proxy ends it.
        assert flood[0].recv(1) == b"" and Upstream.reached == 1
