"""WebRTC on this machine: a sender that is received (WHIP), a server that is asked (WHEP), and strangers at the door.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import av
import pytest

from kit.sending import Pictures, Sender, Server, ask, post
from kit.streams import Handler, pictures, prototype, served, watched
from moireid.errors import MediaError
from moireid.sandbox.seal import MEANS
from moireid.verifier import Claim, Frame, Verifier
from moireid.verifier.video import picture_of
from moireid_studio.watch.feeding import MOST_SDP_BYTES
from moireid_studio.watch.order import Patience, Signal, StreamEnd, WatchOrder
from moireid_studio.watch.source import source_of
from moireid_studio.watch.watching import Terms, watch
from moireid_studio.watch.whip import WhipServer

TOKEN = "a-token-of-the-test"
SDP = "v=0\r\no=- 1 1 IN IP4 0.0.0.0\r\ns=-\r\nt=0 0\r\nm=video 9 UDP/TLS/RTP/SAVPF 96\r\n"


class Kept:
    """A judge's place at the door: it keeps what it is sent, and answers each description."""

    def __init__(self) -> None:
        import queue

        self.sent: list[Any] = []
        self.described: queue.SimpleQueue[str] = queue.SimpleQueue()

    def send(self, message: Any) -> None:
        self.sent.append(message)
        if isinstance(message, Signal):
            self.described.put("v=0 the answer")


@pytest.fixture
def door() -> Iterator[tuple[WhipServer, Kept]]:
    kept = Kept()
    with WhipServer(source_of("whip://127.0.0.1:0/in"), TOKEN, kept) as opened:  # type: ignore[arg-type]
        yield opened, kept


def test_the_door_keeps_strangers_out(door: tuple[WhipServer, Kept]) -> None:
    """Catches: a sender without the token, a description of a megabyte, a second sender, what is no description."""
    opened, kept = door
    for token in (None, "", "wrong", TOKEN + "x", TOKEN[:-1], "ä"):
        headers = token.encode("utf-8").decode("latin-1") if token else token
        assert post(opened.address, headers, SDP)[0] == 401
    assert post(opened.address, TOKEN, SDP + "a=x\r\n" * 200_000)[0] == 413
    assert post(opened.address, TOKEN, b"v=0" + b"\xff" * MOST_SDP_BYTES)[0] == 413
    assert ask("POST", opened.address, TOKEN, SDP, kind="text/plain")[0] == 415
    assert post(opened.address, TOKEN, "hello")[0] == 400
    assert ask("DELETE", opened.address, TOKEN, "", "/in/session")[0] == 404
    assert ask("GET", opened.address, TOKEN, "")[0] == 405
    assert kept.sent == []
    status, answer, place = post(opened.address, TOKEN, SDP)
    assert (status, answer, place) == (201, "v=0 the answer", "/in/session")
    assert post(opened.address, TOKEN, SDP)[0] == 409
    assert ask("DELETE", opened.address, "wrong", "", place)[0] == 401
    assert ask("DELETE", opened.address, TOKEN, "", place)[0] == 200
    assert kept.sent == [Signal(SDP), StreamEnd("source")] and opened.here and opened.token is None


def test_a_token_is_drawn_where_none_is_given() -> None:
    """Catches: a door that is open to every sender; one token for all."""
    source, drawn = source_of("whip://127.0.0.1:0/"), set()
    for _ in range(2):
        with WhipServer(source, None, Kept()) as opened:  # type: ignore[arg-type]
            assert opened.token is not None and post(opened.address, None, SDP)[0] == 401
            assert post(opened.address, opened.token, SDP)[0] == 201
            drawn.add(opened.token)
    assert len(drawn) == 2 and min(map(len, drawn)) >= 20


#: Less than a program for streaming sends: sender and judge share two processors here.
FPS, SIZE = 15, (960, 540)


@pytest.fixture(scope="module")
def shots() -> list[av.VideoFrame]:
    """The film there and back: its four seconds have too few pictures for a verdict."""
    there = pictures(size=SIZE)[::2]
    return there + there[-2::-1]


def enough_s(shots: list[av.VideoFrame]) -> float:
    """Seconds of the film that are enough: the first, in quarters, on which a film's verdict is to accept."""
    for count in range(FPS // 4, len(shots), FPS // 4):
        verifier = Verifier(Claim(prototype()), running=False)
        for k, shot in enumerate(shots[:count]):
            verifier.push(Frame(k, k / FPS, picture_of(shot)))
        if {chapter.invariant.verdict for chapter in verifier.finish()} == {"accept"}:
            return count / FPS
    raise AssertionError("the film is too short")


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.parametrize("codec", ["VP8", "H264"])
def test_a_sender_is_judged_as_soon_as_it_moved_enough(shots: list[av.VideoFrame], codec: str) -> None:
    """Catches: a verdict that waits, a receiver that loses pictures, one that asks a server of anybody's for addresses.

    The badge lies still while the session is made and the clock settles, and then moves.  All times are the sender's,
    whose pictures carry them: a slow machine sends later, and is judged later.
    """
    still_s, enough = 3.0, enough_s(shots)
    track, events, sender = Pictures(shots, FPS, still_s=still_s), list[dict[str, Any]](), list[Sender]()

    def heed(event: dict[str, Any]) -> None:
        events.append(event)
        if event["event"] == "waiting":
            sender.append(Sender(event["address"], event["token"], track, codec=codec))
        elif event["event"] == "status" and event["verdict"] == "accept":
            threading.Thread(target=sender[0].end, daemon=True).start()

    # A busy machine may need seconds for the first pictures.
    found = watched("whip://127.0.0.1:0/in", notify=heed, patience=Patience(20.0, 8.0, 1.0))
    assert sender[0].status == 201
    accepted_s = [one["time_s"] for one in events if one["event"] == "status" and one["verdict"] == "accept"]
    assert accepted_s and accepted_s[0] <= still_s + enough + 2.0, (accepted_s, found["reasons"])
    assert found["end"]["why"] == "source" and found["sealed"] == list(MEANS)


@pytest.mark.slow
@pytest.mark.alone
def test_a_sender_that_never_comes_through_is_a_sentence() -> None:
    """Catches: a wait without end for one that describes itself and sends nothing; a description that breaks it."""
    for sdp in (SDP, SDP + "m=video 9 UDP/TLS/RTP/SAVPF 96\r\n" * 100):

        def heed(event: dict[str, Any], sdp: str = sdp) -> None:
            if event["event"] == "waiting":
                threading.Thread(target=post, args=(event["address"], event["token"], sdp), daemon=True).start()

        with pytest.raises(MediaError):
            watched("whip://127.0.0.1:0/in", notify=heed)


class Whep(Handler):
    """Answers as the draft of WHEP says; `asked` has methods and tokens."""

    def do_POST(self) -> None:
        offer = self.rfile.read(int(self.headers["Content-Length"])).decode()
        self.server.asked.append(("POST", self.headers["Authorization"]))
        if self.headers["Authorization"] != f"Bearer {TOKEN}":
            self.send_response(401)
            self.end_headers()
            return
        answer = self.server.rtc.answer(offer).encode()
        self.send_response(201)
        self.send_header("Content-Type", "application/sdp")
        self.send_header("Location", "/room/1")
        self.end_headers()
        self.wfile.write(answer)

    def do_DELETE(self) -> None:
        self.server.asked.append(("DELETE", self.path))
        self.send_response(200)
        self.end_headers()


@pytest.mark.slow
@pytest.mark.alone
def test_a_stream_is_asked_for(shots: list[av.VideoFrame], tmp_path: Any) -> None:
    """Catches: a token that is not sent, a session that is left open, an answer of 401 that is no sentence."""
    server = Server(Pictures(shots, FPS))
    with served(tmp_path, Whep) as web:
        web.rtc = server  # type: ignore[attr-defined]
        order = WatchOrder(source_of(f"whep://127.0.0.1:{web.server_address[1]}/room"), Claim(prototype()))
        with pytest.raises(MediaError, match="answers 401"):
            watch(order, Terms(5.0), threading.Event(), lambda event: None)
        found = watch(order, Terms(5.0, TOKEN), threading.Event(), lambda event: None)
        assert web.asked == [("POST", None), ("POST", f"Bearer {TOKEN}"), ("DELETE", "/room/1")]  # type: ignore[attr-defined]
    server.end()
    assert found["verdict"] == "accept" and found["end"]["why"] == "asked", found["reasons"]
