"""Pictures of a WebRTC sender, received in the judge's process by aiortc, which decodes them, too.

No outside server is asked for this machine's address: both ends must reach each other.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any

from moireid.errors import MediaError
from moireid.extras import missing_extra
from moireid_studio.watch.order import Signal, StreamEnd
from moireid_studio.watch.readers import Inbox, TimedPicture, small_enough

#: Media of a description: sound and picture of a sender, and some more that are not received.
MOST_MEDIA = 8


class Peer:
    """One end of a WebRTC session, on a thread of its own; only its first video track is received.

    Parameters
    ----------
    send
        Sends our descriptions.
    offers
        Whether we make the offer (WHEP) or answer one (WHIP).

    Raises
    ------
    MissingExtraError
        Without aiortc.
    """

    def __init__(self, inbox: Inbox, send: Callable[[dict[str, Any]], None], *, offers: bool) -> None:
        try:
            import aiortc
        except ImportError as missing:
            raise missing_extra("WebRTC", "aiortc", "webrtc", "moireid-studio") from missing
        self._rtc, self._inbox, self._send, self._offers = aiortc, inbox, send, offers
        self._loop = asyncio.new_event_loop()
        self._tasks = set[asyncio.Task[None]]()
        self._connection: Any = None
        self._seen = False
        threading.Thread(target=self._loop.run_forever, daemon=True).start()
        if offers:
            self._do(self._offer())

    def hear(self, signal: Signal) -> None:
        """Take the other end's description; a second one changes nothing."""
        self._do(self._take(signal.sdp) if self._offers else self._answer(signal.sdp))

    def _do(self, work: Coroutine[Any, Any, None]) -> None:
        """Let the loop do it; what goes wrong ends the stream with a sentence."""

        async def safely() -> None:
            try:
                await work
            except MediaError as error:
                self._inbox.put(StreamEnd("failed", str(error)))
            # Whatever a stranger's description makes of the library ends this session alone.
            except Exception as error:  # noqa: BLE001
                words = " ".join(str(error).split())[:160]
                self._inbox.put(
                    StreamEnd("failed", f"the WebRTC session cannot be made ({type(error).__name__}: {words})")
                )

        asyncio.run_coroutine_threadsafe(safely(), self._loop)

    def _begin(self) -> Any:
        # Without this the library would ask a server of its maker's choice for our address.
        connection = self._rtc.RTCPeerConnection(self._rtc.RTCConfiguration(iceServers=[]))
        connection.on("track", self._on_track)
        connection.on("connectionstatechange", self._on_state)
        self._connection = connection
        return connection

    async def _offer(self) -> None:
        connection = self._begin()
        connection.addTransceiver("video", direction="recvonly")
        await connection.setLocalDescription(await connection.createOffer())
        self._send({"offer": connection.localDescription.sdp})

    async def _take(self, sdp: str) -> None:
        if self._connection.signalingState == "have-local-offer":
            await self._connection.setRemoteDescription(self._described(sdp, "answer"))

    async def _answer(self, sdp: str) -> None:
        if self._connection is not None:
            return
        connection = self._begin()
        await connection.setRemoteDescription(self._described(sdp, "offer"))
        self._receive_one()
        await connection.setLocalDescription(await connection.createAnswer())
        self._send({"answer": connection.localDescription.sdp})

    def _described(self, sdp: str, kind: str) -> Any:
        if sdp.count("\nm=") > MOST_MEDIA:
            raise MediaError(f"the sender describes more than {MOST_MEDIA} media; send one picture")
        return self._rtc.RTCSessionDescription(sdp, kind)

    def _receive_one(self) -> None:
        """Receive the first video alone: what is received and not read would fill the memory."""
        videos = [one for one in self._connection.getTransceivers() if one.kind == "video"]
        if not videos:
            raise MediaError("the sender offers no video; send one")
        for one in self._connection.getTransceivers():
            if one is not videos[0]:
                one.direction = "inactive"

    def _on_track(self, track: Any) -> None:
        if track.kind == "video" and not self._seen:
            self._seen = True
            task = self._loop.create_task(self._receive(track))
            self._tasks.add(task)

    async def _receive(self, track: Any) -> None:
        try:
            while True:
                decoded = await track.recv()
                arrival_s = time.monotonic()
                # The sender's clock: it says when the picture was taken, whatever the network does with it.
                claimed_s = float(decoded.pts * decoded.time_base)
                self._inbox.put_picture(TimedPicture(small_enough(decoded), claimed_s, arrival_s))
        except self._rtc.mediastreams.MediaStreamError:
            self._inbox.put(StreamEnd("source"))
        except MediaError as error:
            self._inbox.put(StreamEnd("failed", str(error)))

    def _on_state(self) -> None:
        state = self._connection.connectionState
        if state in ("failed", "closed"):
            words = "no way between the two ends was found, or it was lost"
            self._inbox.put(StreamEnd("failed", words) if state == "failed" else StreamEnd("source"))
