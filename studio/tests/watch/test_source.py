"""What a source is, from what was typed.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from moireid.errors import MediaError, SpecError
from moireid_studio.watch.source import check_prompts, source_of


@pytest.mark.parametrize(
    ("text", "kind", "shown", "live", "ports"),
    [
        ("0", "camera", "camera 0", True, None),
        ("-", "pipe", "standard input", False, None),
        ("screen", "screen", "screen", True, None),
        ("screen:0x3a00007", "screen", "screen:0x3a00007", True, None),
        ("rtsp://me:secret@camera.example/1", "rtsp", "rtsp://camera.example/1", True, (554,)),
        ("rtsp://camera.example:8554/1", "rtsp", "rtsp://camera.example:8554/1", True, (8554,)),
        ("https://me:secret@host/a.m3u8?key=secret#secret", "http", "https://host/a.m3u8?…", False, None),
        ("HTTP://host/a.ts", "http", "http://host/a.ts", False, None),
        ("wheps://host/room", "whep", "wheps://host/room", True, ()),
        ("whip://[::1]:8080", "whip", "whip://[::1]:8080", True, ()),
    ],
)
def test_each_kind_is_known_by_its_text(text: str, kind: str, shown: str, live: bool, ports: object) -> None:
    """Catches: a password in a report; a decoder that gets the network, or more of it, where it needs none."""
    found = source_of(text)
    assert (found.kind, found.shown, found.live(challenged=False), found.ports) == (kind, shown, live, ports)
    assert "secret" not in found.shown and found.text == text


def test_a_path_is_a_file_or_a_pipe(tmp_path: Path) -> None:
    """Catches: a folder or a device that is opened; a file named like a camera that cannot be reached."""
    (tmp_path / "0").write_bytes(b"x")
    os.mkfifo(tmp_path / "pipe")
    assert source_of(str(tmp_path / "0")).kind == "file"
    assert source_of(str(tmp_path / "pipe")).kind == "pipe"
    for wrong in (str(tmp_path), "/dev/null", str(tmp_path / "none"), "a\0b", ""):
        with pytest.raises(MediaError):
            source_of(wrong)


@pytest.mark.parametrize(
    "text",
    [
        *("file:///etc/passwd", "ftp://host/x", "concat://a|b", "rtsps://host/1", "http://", "whip://:8080"),
        *("http://h:x/", "http://ho st/", "http://host/\nHost: other", "pipe://0"),
    ],
)
def test_other_addresses_are_refused(text: str) -> None:
    """Catches: a scheme of the decoder's library that is handed on; an address that writes into a request."""
    with pytest.raises(SpecError):
        source_of(text)


def test_prompts_need_somebody_who_can_answer(tmp_path: Path) -> None:
    """Catches: a challenge to a film, or to a stream that comes half a minute late."""
    (tmp_path / "film.ts").write_bytes(b"x")
    for text in (str(tmp_path / "film.ts"), "https://host/a.m3u8"):
        with pytest.raises(SpecError, match="--challenge"):
            check_prompts(source_of(text))
    for text in ("0", "-", "rtsp://host/1", "whip://127.0.0.1", "whep://host/1", "screen"):
        check_prompts(source_of(text))
    assert source_of("-").live(challenged=True)
