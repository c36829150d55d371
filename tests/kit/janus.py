"""Janus, an open conferencing server, with one room on this machine; and somebody who sends a film into it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import secrets
import socket
import subprocess
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from aiortc.contrib.media import MediaPlayer

from kit.programs import needs
from kit.sending import RATE

ROOM = 1234
FILES = {
    "janus.jcfg": 'general: {{ configs_folder = "{folder}"\n server_name = "test" }}\nmedia: {{ rtp_port_range = '
    '"40000-41000" }}\nplugins: {{ disable = "{plugins}" }}\ntransports: {{ disable = "{transports}" }}\n',
    "janus.transport.http.jcfg": 'general: {{ http = true\n port = {port}\n ip = "127.0.0.1"\n https = false }}\n'
    "admin: {{ admin_http = false }}\n",
    "janus.plugin.videoroom.jcfg": 'room-{room}: {{ description = "test"\n publishers = 6\n bitrate = {rate}\n '
    'videocodec = "h264" }}\n',
}
PLUGINS = "audiobridge duktape echotest lua nosip recordplay sip streaming textroom videocall voicemail"
TRANSPORTS = "mqtt nanomsg pfunix rabbitmq websockets"


@contextlib.contextmanager
def janus(folder: Path) -> Iterator[str]:
    """The address of a running server."""
    program = needs("janus")
    with socket.create_server(("127.0.0.1", 0)) as asked:
        port = asked.getsockname()[1]
    words = {
        "folder": folder,
        "port": port,
        "room": ROOM,
        "rate": RATE,
        "plugins": ",".join(f"libjanus_{name}.so" for name in PLUGINS.split()),
        "transports": ",".join(f"libjanus_{name}.so" for name in TRANSPORTS.split()),
    }
    for name, text in FILES.items():
        (folder / name).write_text(text.format(**words))
    command = [program, "-F", str(folder), "-C", str(folder / "janus.jcfg"), "-d", "3"]
    with (folder / "log.txt").open("wb") as log, subprocess.Popen(command, stdout=log, stderr=log) as server:
        try:
            _wait(f"http://127.0.0.1:{port}/janus/info", server)
            yield f"http://127.0.0.1:{port}/janus"
        finally:
            server.kill()


def _wait(address: str, server: subprocess.Popen[bytes]) -> None:
    last = time.monotonic() + 20
    while server.poll() is None and time.monotonic() < last:
        with contextlib.suppress(urllib.error.URLError), urllib.request.urlopen(address, timeout=2):
            return
        time.sleep(0.1)
    raise AssertionError("the server does not answer")


class Participant:
    """Somebody in the room, who sends a film until `end`: H.264 of a transport stream, as it is, in time."""

    def __init__(self, address: str, name: str, film: Path) -> None:
        self._address, self._name, self._film, self._ended = address, name, film, threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._send()), daemon=True)
        self._thread.start()

    def end(self) -> None:
        self._ended.set()
        self._thread.join(20)

    async def _send(self) -> None:
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        peer.addTrack(MediaPlayer(str(self._film), decode=False).video)
        codecs = [one for one in RTCRtpSender.getCapabilities("video").codecs if "H264" in one.mimeType]
        peer.getTransceivers()[0].setCodecPreferences(codecs)
        await peer.setLocalDescription(await peer.createOffer())
        answer = await asyncio.to_thread(self._join, peer.localDescription.sdp)
        await peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        await asyncio.to_thread(self._ended.wait, 120)
        await peer.close()

    def _join(self, offer: str) -> str:
        def ask(place: str, **content: Any) -> dict[str, Any]:
            body = json.dumps(content | {"transaction": secrets.token_hex(4)}).encode()
            with urllib.request.urlopen(urllib.request.Request(place, body), timeout=20) as answer:
                return dict(json.loads(answer.read()))

        session = f"{self._address}/{ask(self._address, janus='create')['data']['id']}"
        handle = f"{session}/{ask(session, janus='attach', plugin='janus.plugin.videoroom')['data']['id']}"
        body = {"request": "joinandconfigure", "ptype": "publisher", "room": ROOM, "display": self._name}
        ask(handle, janus="message", body=body, jsep={"type": "offer", "sdp": offer})
        while True:
            with urllib.request.urlopen(f"{session}?maxev=1", timeout=40) as answer:
                event = json.loads(answer.read())
            if "jsep" in event:
                return str(event["jsep"]["sdp"])
