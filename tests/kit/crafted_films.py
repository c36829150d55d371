"""Files made to harm who reads them as films: lists that name other files, and films of far too many streams.

A pipe notes its readers, so that a test sees who opens what a list names.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import av
import numpy as np

#: Lists under a film's name; each names OTHER, which FFmpeg opens only under a name that is usual there.
LISTS = {
    "hls": "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nOTHER\n#EXT-X-ENDLIST\n",
    "hls_key": '#EXTM3U\n#EXT-X-KEY:METHOD=AES-128,URI="OTHER"\n#EXTINF:1,\nother.ts\n#EXT-X-ENDLIST\n',
    "hls_map": '#EXTM3U\n#EXT-X-VERSION:7\n#EXT-X-MAP:URI="OTHER"\n#EXTINF:1,\nother.m4s\n#EXT-X-ENDLIST\n',
    "concat": "ffconcat version 1.0\nfile OTHER\n",
    "dash": '<?xml version="1.0"?><MPD xmlns="urn:mpeg:dash:schema:mpd:2011" type="static" '
    'mediaPresentationDuration="PT1S"><Period><AdaptationSet mimeType="video/mp4"><Representation id="1" '
    'bandwidth="1"><BaseURL>OTHER</BaseURL><SegmentList duration="1"><Initialization sourceURL="OTHER"/>'
    '<SegmentURL media="OTHER"/></SegmentList></Representation></AdaptationSet></Period></MPD>',
    "sdp": "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 5004 RTP/AVP 96\n"
    "a=rtpmap:96 H264/90000\n",
    "svg": '<svg xmlns="http://www.w3.org/2000/svg" xmlns:x="http://www.w3.org/1999/xlink" width="99" height="99">'
    '<image x:href="OTHER" width="99" height="99"/></svg>',
}


def list_of(kind: str, folder: Path) -> tuple[Path, Path]:
    """A list of that kind, and the other file that it names, which is not there yet; FFmpeg minds both names."""
    own, other = ("film.m3u8", "other.ts") if kind.startswith("hls") else ("film.mp4", "other.mp4")
    path, named = folder / own, folder / other
    path.write_text(LISTS[kind].replace("OTHER", other), encoding="utf-8")
    return path, named


def streams_of(path: Path, count: int, size: tuple[int, int], frames: int = 3) -> Path:
    """A film of so many equal streams; each one's pictures are all of one grey, so the file is small."""
    once = path.with_name(f"once{path.suffix}")
    with av.open(str(once), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height = size
        stream.pix_fmt, stream.options = "yuv420p", {"preset": "ultrafast", "threads": "1"}
        for number in range(frames):
            grey = np.full((size[1] * 3 // 2, size[0]), 90 + number, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(grey, format="yuv420p")))
        container.mux(stream.encode(None))
    with av.open(str(once)) as given, av.open(str(path), "w") as made:
        streams = [made.add_stream_from_template(given.streams.video[0]) for _ in range(count)]
        for packet in given.demux(video=0):
            for stream in streams if packet.dts is not None else ():
                copied = av.Packet(bytes(packet))
                copied.pts, copied.dts, copied.time_base = packet.pts, packet.dts, packet.time_base
                copied.is_keyframe, copied.stream = packet.is_keyframe, stream
                made.mux(copied)
    once.unlink()
    return path


@contextmanager
def readers_of(pipe: Path) -> Iterator[list[str]]:
    """A pipe, and a note of every program that opens it to read; each gets its end at once."""
    os.mkfifo(pipe)
    seen: list[str] = []
    done = threading.Event()

    def watch() -> None:
        while not done.wait(0.002):
            with suppress(OSError):
                os.close(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))
                seen.append(pipe.name)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        yield seen
    finally:
        done.set()
        watcher.join()
