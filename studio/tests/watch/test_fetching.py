"""Which addresses are opened for a playlist.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Any

import pytest

from kit.streams import Handler, address, served
from moireid.errors import MediaError
from moireid_studio.watch.fetching import Addresses, public


class Moved(Handler):
    """Leads to `server.to`, and notes what it is sent."""

    def do_GET(self) -> None:
        self.server.asked.append((self.path, self.headers["Authorization"]))
        self.send_response(302)
        self.send_header("Location", self.server.to)
        self.end_headers()


def test_the_own_host_is_read_wherever_it_lies(tmp_path: Path) -> None:
    """Catches: a camera in one's own network that cannot be named; a query or a password that is lost or shown."""
    (tmp_path / "a.ts").write_bytes(b"content" * 1000)
    with served(tmp_path) as server:
        own = address(server, "a.ts")
        stream = Addresses(own).open(own)
        content = b""
        while piece := stream.read(100):
            assert len(piece) <= 100
            content += piece
        stream.close()
        assert content == b"content" * 1000
        Addresses(own).open(f"{own}?key=1")
        assert server.asked == ["/a.ts", "/a.ts?key=1"]  # type: ignore[attr-defined]
        with pytest.raises(MediaError, match="404"):
            Addresses(own).open(address(server, "none.ts"))


def test_nothing_else_within_this_machine_or_its_network_is_asked(tmp_path: Path) -> None:
    """Catches: a playlist or a redirect that makes us ask a router, a cloud's own address, or another port here."""
    with served(tmp_path) as other, served(tmp_path, Moved) as server:
        own = Addresses(address(server, "a.m3u8"))
        inner = ["192.168.1.1", "10.0.0.1", "169.254.169.254", "[::1]", "[::ffff:127.0.0.1]", "0.0.0.0", "localhost"]
        for named in (address(other, "a.ts"), *(f"http://{host}:{other.server_address[1]}/a.ts" for host in inner)):
            with pytest.raises(MediaError, match=r"within this machine|cannot be reached"):
                own.open(named)
            server.to = named  # type: ignore[attr-defined]
            with pytest.raises(MediaError, match=r"within this machine|cannot be reached"):
                own.open(address(server, "a.ts"))
        server.to = "/again"  # type: ignore[attr-defined]
        with pytest.raises(MediaError, match="leads on and on"):
            own.open(address(server, "a.ts"))
        assert other.asked == []  # type: ignore[attr-defined]


@pytest.mark.parametrize("named", ["file:///etc/passwd", "ftp://host/a", "data:,x", "gopher://host", "http:///x", "x"])
def test_only_http_is_opened(named: str) -> None:
    """Catches: another way of the same library, by which a file would be read."""
    with pytest.raises(MediaError):
        Addresses("http://127.0.0.1/a.m3u8").open(named)


def test_encryption_is_not_given_up() -> None:
    """Catches: a playlist with encryption whose pieces come without."""
    with pytest.raises(MediaError, match="without encryption"):
        Addresses("https://host.example/a.m3u8").open("http://host.example/a.ts")


def test_a_password_is_sent_to_its_own_host_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a password that follows a redirect, or that a server of pieces gets."""
    monkeypatch.setattr("moireid_studio.watch.fetching.public", lambda host: True)
    with served(tmp_path, Moved) as other, served(tmp_path, Moved) as server:
        server.to, other.to = address(other, "b"), address(other, "b")  # type: ignore[attr-defined]
        own = address(server, "a").replace("//", "//me:s%20t@")
        with pytest.raises(MediaError):
            Addresses(own).open(own)
        assert server.asked == [("/a", "Basic bWU6cyB0")]  # type: ignore[attr-defined]
        assert {secret for _, secret in other.asked} == {None}  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("host", "known"),
    [
        *(("93.184.216.34", True), ("2606:2800:220:1::1", True), ("127.0.0.1", False), ("::1", False)),
        *(("10.1.2.3", False), ("fe80::1%eth0", False), ("::ffff:10.0.0.1", False), ("224.0.0.1", False)),
        *(("100.64.0.1", False), ("169.254.1.1", False), ("2002:7f00:1::", False), ("0.0.0.0", False)),
        ("fc00::1", False),
    ],
)
def test_what_is_public(host: str, known: bool) -> None:
    """Catches: an inner address in the clothes of another family."""
    assert public(host) is known


def test_a_name_is_looked_up_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Catches: a name that is public when it is checked, and inner when it is connected to."""
    with served(tmp_path) as server:
        port = server.server_address[1]
        answers = [[(socket.AF_INET, socket.SOCK_STREAM, 6, "", ("127.0.0.1", port))]]
        asked: list[Any] = []

        def look_up(host: str, *rest: Any, **more: Any) -> Any:
            asked.append(host)
            return answers[0]

        monkeypatch.setattr(socket, "getaddrinfo", look_up)
        with pytest.raises(MediaError, match="within this machine"):
            Addresses("http://first.example/a.m3u8").open(f"http://other.example:{port}/a.ts")
        assert asked == ["other.example"] and server.asked == []  # type: ignore[attr-defined]


def test_a_public_host_leads_nowhere_inside_later(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Catches: the own host's name that is led to this machine once its playlist was read (DNS rebinding)."""
    (tmp_path / "a.ts").write_bytes(b"content")
    with served(tmp_path) as server:
        own = address(server, "a.ts")
        stream = Addresses(own)
        with monkeypatch.context() as outside:
            outside.setattr("moireid_studio.watch.fetching.public", lambda host: True)
            stream.open(own).close()
        with pytest.raises(MediaError, match="within this machine"):
            stream.open(own)
        assert server.asked == ["/a.ts"]  # type: ignore[attr-defined]
