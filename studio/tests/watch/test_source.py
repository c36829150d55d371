"""What a source is, from what was typed.  Each test names the wrong implementation it catches."""

from __future__ import annotations

from pathlib import Path

import pytest

from moireid.errors import SpecError
from moireid_studio.watch.source import check_prompts, source_of


@pytest.mark.parametrize(
    ("text", "kind", "shown", "live"), [("0", "camera", "camera 0", True), ("-", "pipe", "standard input", False)]
)
def test_each_kind_is_known_by_its_text(text: str, kind: str, shown: str, live: bool) -> None:
    """Catches: a pipe held against our clock, though a film may be poured into it; a camera that is not."""
    found = source_of(text)
    assert (found.kind, found.shown, found.live(challenged=False)) == (kind, shown, live)
    assert found.text == text and found.live(challenged=True)


@pytest.mark.parametrize(
    "text",
    [
        *("rtsp://me:secret@camera.example/1", "https://host/a.m3u8?key=secret", "WHIP://[::1]:8080", "wheps://host/1"),
        *("file:///etc/passwd", "concat://a|b", "http://host/\nsecret", "screen", "screen:0x3a00007"),
    ],
)
def test_an_address_or_a_screen_goes_by_a_pipe(text: str) -> None:
    """Catches: an address handed on to the decoder's library, or one said to be a file that does not exist; a password
    in a message; a message without what to use instead."""
    with pytest.raises(SpecError) as refused:
        source_of(text)
    said = str(refused.value)
    assert "ffmpeg -i ADDRESS -c copy -f matroska - | moireid watch -" in said and "secret" not in said


def test_prompts_need_somebody_who_can_answer(tmp_path: Path) -> None:
    """Catches: a challenge to a film; one that is refused to a camera or to a pipe, by which a camera may come."""
    (tmp_path / "film.ts").write_bytes(b"x")
    with pytest.raises(SpecError, match="challenge="):
        check_prompts(source_of(str(tmp_path / "film.ts")))
    for text in ("0", "-"):
        check_prompts(source_of(text))
