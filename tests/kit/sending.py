"""A WebRTC sender and a WebRTC server on this machine, by aiortc: what OBS, a browser or a media server would be."""

from __future__ import annotations

import asyncio
import http.client
import threading
import time
from fractions import Fraction
from typing import Any
from urllib.parse import urlsplit

import av
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription, VideoStreamTrack
from aiortc.codecs import h264, vpx

#: Bits a second, as a program for streaming sends; the library's own are those of a call in the country.
RATE = 6_000_000
CLOCK = 90_000


class Pictures(VideoStreamTrack):
    """Pictures to and fro, at their rate; `begun_s`: when the first was sent, by this machine's clock."""

    def __init__(self, shots: list[av.VideoFrame], fps: int, *, still_s: float = 0.0) -> None:
        super().__init__()
        self._shots = [one.to_ndarray() for one in shots]
        self._fps, self._still, self._count = fps, round(still_s * fps), 0
        self.begun_s: float | None = None

    async def recv(self) -> av.VideoFrame:
        if self.begun_s is None:
            self.begun_s = time.monotonic()
        k, self._count = self._count, self._count + 1
        await asyncio.sleep(max(self.begun_s + k / self._fps - time.monotonic(), 0))
        place = max(k - self._still, 0) % (2 * len(self._shots) - 2)
        place = min(place, 2 * len(self._shots) - 2 - place)
        sent = av.VideoFrame.from_ndarray(self._shots[place], format="yuv420p")
        sent.pts, sent.time_base = k * CLOCK // self._fps, Fraction(1, CLOCK)
        return sent


class Sender:
    """Sends a track to a WHIP address until `end`; `status` is what the address answered."""

    def __init__(self, address: str, token: str, track: VideoStreamTrack, *, codec: str = "VP8") -> None:
        self._address, self._token, self._track, self._codec = address, token, track, codec
        vpx.DEFAULT_BITRATE = vpx.MAX_BITRATE = h264.DEFAULT_BITRATE = h264.MAX_BITRATE = RATE
        self.status, self._session = 0, ""
        self._ended = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._send()), daemon=True)
        self._thread.start()

    def end(self) -> None:
        self._ended.set()
        self._thread.join(20)

    async def _send(self) -> None:
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        peer.addTrack(self._track)
        codecs = [one for one in RTCRtpSender.getCapabilities("video").codecs if self._codec in one.mimeType]
        peer.getTransceivers()[0].setCodecPreferences(codecs)
        await peer.setLocalDescription(await peer.createOffer())
        self.status, answer, place = await asyncio.to_thread(
            post, self._address, self._token, peer.localDescription.sdp
        )
        self._session = place
        if self.status == 201:
            await peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
            await asyncio.to_thread(self._ended.wait, 60)
            await asyncio.to_thread(ask, "DELETE", self._address, self._token, "", self._session)
        await peer.close()


def post(address: str, token: str | None, sdp: str | bytes) -> tuple[int, str, str]:
    """Status, content and session of the answer to an offer."""
    return ask("POST", address, token, sdp)


def ask(
    method: str, address: str, token: str | None, content: str | bytes, path: str = "", kind: str = "application/sdp"
) -> tuple[int, str, str]:
    parts = urlsplit(address)
    asked = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=30)
    headers = {"Content-Type": kind} | ({"Authorization": f"Bearer {token}"} if token is not None else {})
    asked.request(method, path or parts.path, content, headers)
    answer = asked.getresponse()
    body = answer.read().decode()
    asked.close()
    return answer.status, body, answer.getheader("Location") or ""


class Server:
    """A WHEP server of one track: answers an offer as a media server does."""

    def __init__(self, track: VideoStreamTrack) -> None:
        self._track, self._loop = track, asyncio.new_event_loop()
        self.peers: list[Any] = []
        threading.Thread(target=self._loop.run_forever, daemon=True).start()

    def answer(self, offer: str) -> str:
        return asyncio.run_coroutine_threadsafe(self._answer(offer), self._loop).result(20)

    async def _answer(self, offer: str) -> str:
        vpx.DEFAULT_BITRATE = vpx.MAX_BITRATE = RATE
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.peers.append(peer)
        await peer.setRemoteDescription(RTCSessionDescription(offer, "offer"))
        peer.addTrack(self._track)
        await peer.setLocalDescription(await peer.createAnswer())
        return str(peer.localDescription.sdp)

    def end(self) -> None:
        for peer in self.peers:
            asyncio.run_coroutine_threadsafe(peer.close(), self._loop).result(20)
        self._loop.call_soon_threadsafe(self._loop.stop)
