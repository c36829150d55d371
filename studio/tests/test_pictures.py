"""Logos and portraits that strangers send: what is read of them, and by whom.  Each test names the wrong
implementation it catches.
"""

from __future__ import annotations

import io
import struct
import threading
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from kit.webbing import OpenStudio, Visit, studio
from moireid.artwork.pictures import load_picture
from moireid.errors import SpecError
from moireid.sandbox.process import sealed_here
from moireid_studio import forms, pictures
from moireid_studio.auth.guard import Visitor
from moireid_studio.picture_work import MOST_BYTES, MOST_SIDE_PX, encoded
from moireid_studio.pictures import Reader, read_picture, read_pictures
from moireid_studio.settings import Limits
from moireid_studio.store.stored_pictures import StoredPicture

LIMITS = Limits()
NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
LOGO = f'<svg {NS} viewBox="0 0 60 20"><path d="M0 0h60v20H0z" fill="#ff00ff"/></svg>'.encode()


def svg(inside: str, box: str = "0 0 200 200") -> bytes:
    return f'<svg {NS} viewBox="{box}">{inside}</svg>'.encode()


def picture(kind: str, size: tuple[int, int] = (60, 80), colour: str = "#ff00ff", **more: object) -> bytes:
    made = io.BytesIO()
    Image.new("RGB", size, colour).save(made, kind, **more)
    return made.getvalue()


def pixel_bomb() -> bytes:
    """A PNG of a few bytes whose head promises 3.6 thousand million pixels."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", 60_000, 60_000, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"0" * 99)) + chunk(b"IEND", b"")


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio(form_bytes=200_000, picture_bytes=3_000_000, pictures_bytes=5_000_000)


def test_a_picture_is_read_as_by_the_command_and_nothing_of_its_file_is_handed_on(tmp_path: Path) -> None:
    """Catches: another reader than the command's, a file that is passed through with what hides in it, colours lost."""
    result = PngImagePlugin.PngInfo()
    result.add_text("secret", "of the file")
    files = {"a.svg": LOGO, "b.png": picture("PNG", pnginfo=result), "c.jpg": picture("JPEG", exif=b"Exif\0\0secret")}
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
        made = read_picture("logo", StoredPicture(name, data), LIMITS)
        assert made.suffix in (".png", ".jpg") and b"secret" not in made.data and made.name == name
        ours, theirs = Image.open(io.BytesIO(made.data)).convert("RGB"), load_picture(tmp_path / name, "logo")
        assert abs(ours.width / ours.height - theirs.width / theirs.height) < 0.01
        middle = ours.getpixel((ours.width // 2, ours.height // 2))
        assert np.allclose(middle, (255, 0, 255), atol=3)


def test_what_is_no_picture_is_refused_in_the_command_s_sentence(tmp_path: Path) -> None:
    """Catches: rules of the studio's own, a fault that spoils the pictures after it."""
    copies = "".join(f'<g id="a{k + 1}">' + f'<use href="#a{k}"/>' * 9 + "</g>" for k in range(9))
    bad = {
        "script.svg": svg("<script>alert(1)</script>"),
        "outside.svg": svg('<image href="file:///etc/passwd"/>'),
        "letters.svg": svg("<text>Ada</text>"),
        "copies.svg": svg('<g id="a0"><rect width="9" height="9"/></g>' + copies),
        "entities.svg": b'<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + svg("<title>&b;</title>"),
        "bomb.png": pixel_bomb(),
        "list.csv": b"name\nAda\n",
        "cut.png": picture("PNG")[:60],
    }
    sent = [("logo", StoredPicture(name, data)) for name, data in bad.items()] + [
        ("logo", StoredPicture("a.svg", LOGO))
    ]
    *faults, last = read_pictures(sent, LIMITS)
    assert isinstance(last, StoredPicture)
    for (name, data), fault in zip(bad.items(), faults, strict=True):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(SpecError) as result:
            load_picture(tmp_path / name, "logo")
        assert isinstance(fault, SpecError) and str(fault) == str(result.value).replace(f"{tmp_path}/", "")


@pytest.mark.slow
def test_an_svg_that_takes_memory_or_time_ends_its_own_process_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a drawing in the server itself, one without limits, a reader that is lost for the next visitor."""
    deep = svg('<g opacity=".5">' * 90 + '<rect width="200" height="200"/>' + "</g>" * 90)
    slow = svg('<g opacity=".5"><rect width="9" height="9"/></g>' * 4000, "0 0 9 9")
    monkeypatch.setattr(pictures, "MOST_SECONDS", 2.0)
    begun = time.monotonic()
    sent = [("logo", StoredPicture(name, data)) for name, data in (("deep", deep), ("slow", slow), ("a.svg", LOGO))]
    memory, late, good = read_pictures(sent, LIMITS)
    assert time.monotonic() - begun < 20
    assert isinstance(memory, SpecError) and "memory" in str(memory)
    assert isinstance(late, SpecError) and "to draw; simplify it" in str(late)
    assert isinstance(good, StoredPicture)


def test_who_reads_pictures_is_sealed() -> None:
    """Catches: a reader that could open the server's files, or reach the network, once a picture has it in hand."""
    reader = Reader(LIMITS)
    try:
        assert isinstance(reader.read("logo", StoredPicture("a.svg", LOGO)), StoredPicture)
        assert reader._child is not None and reader._child.sealed == sealed_here()
    finally:
        reader.end()


def test_no_picture_is_handed_on_larger_than_is_said() -> None:
    """Catches: noise that fills the memory of those who print, a transparent picture that becomes black."""
    noise = np.random.default_rng(0).integers(0, 255, (2000, 1500, 4), dtype=np.uint8)
    for alpha in (None, 255):
        noise[..., 3] = noise[..., 3] if alpha is None else alpha
        data = encoded(Image.fromarray(noise, "RGBA"))
        made = Image.open(io.BytesIO(data))
        assert len(data) <= MOST_BYTES and max(made.size) <= MOST_SIDE_PX and made.height > made.width
        assert made.mode == ("RGBA" if alpha is None else "RGB")


def test_a_picture_is_kept_for_its_visitor_alone(visit: Visit) -> None:
    """Catches: one token's portrait on another's badge, an id that is taken for a path, pictures that stay for ever."""
    sent = {"files": {"picture": ("../../../x/ada.svg", LOGO)}}
    answer = visit.ask("POST", "/api/badges/pictures", "issuer", **sent)
    assert answer.status_code == 201, answer.text
    kept = answer.json()["id"]
    assert [name for name in visit.left() if "ada" in name or "x" in name.split("/")] == []
    visitor = Visitor(visit.studio.tokens.find(visit.tokens["issuer"]).id, "issuer")  # type: ignore[union-attr]
    assert next(iter(pictures.kept_pictures(visit.studio, visitor, kept, "it").values())).name == "ada.svg"
    wish = {"name": "Ada", "mount": "none", "format": "a7"}
    assert visit.ask("POST", "/api/badges/check", "issuer", json=wish | {"logo": kept}).status_code == 200
    for role, other in (("admin", kept), ("issuer", "0" * 32)):
        result = visit.ask("POST", "/api/badges/check", role, json=wish | {"logo": other})
        assert result.status_code == 422 and "choose it again" in result.json()["text"]
        page = visit.ask("POST", "/issue", role, data={"name": "Ada", "kept": other, "do": "check"})
        assert page.status_code == 422 and "choose it again" in page.text
    for path in ("/etc/passwd", "../" * 9 + "etc/passwd", kept + "/../" + kept):
        assert visit.ask("POST", "/api/badges/check", "issuer", json=wish | {"logo": path}).status_code == 422
        assert (
            visit.ask("POST", "/issue", "issuer", data={"name": "Ada", "kept": path, "do": "check"}).status_code == 422
        )
    # It ends as results do.
    visit.rewrite(kept, ended=0.0)
    visit.studio.jobs.workers.sweep()
    gone = visit.ask("POST", "/api/badges/check", "issuer", json=wish | {"logo": kept})
    assert gone.status_code == 422 and not [name for name in visit.left() if kept in name]


def test_uploads_have_limits_and_leave_nothing(visit: Visit) -> None:
    """Catches: a form without an end, pictures that count for no limit, a place that is never given back."""
    large = picture("JPEG", (60, 80)) + b"\0" * 2_000_000
    taken = visit.ask("POST", "/api/badges/pictures", "issuer", files={"picture": ("a.jpg", large)})
    assert taken.status_code == 201 and taken.json()["bytes"] < 100_000
    held = visit.studio.jobs.ledger.stored()
    assert sum(held.values()) < 200_000
    too_large = large + b"\0" * 1_500_000
    result = visit.ask("POST", "/api/badges/pictures", "issuer", files={"picture": ("a.jpg", too_large)})
    assert result.status_code == 422 and "picture a.jpg is larger than 3 MB" in result.json()["text"]
    whole = [("pictures", (f"{k}.jpg", large)) for k in range(3)]
    assert visit.ask("POST", "/issue/event", "issuer", data={"people": "name\nA\n"}, files=whole).status_code == 413
    many = [("logo", (f"{k}.svg", LOGO)) for k in range(3)]
    assert visit.ask("POST", "/issue", "issuer", data={"name": "Ada"}, files=many).status_code == 413
    text = visit.ask("POST", "/issue", "issuer", data={"name": "x" * 300_000}, files={"logo": ("a.svg", LOGO)})
    assert text.status_code in (400, 413)
    assert visit.ask("POST", "/api/badges/pictures", "issuer", data={"no": "file"}).status_code in (400, 422)
    for role in (None, "verifier"):
        refused = visit.ask("POST", "/api/badges/pictures", role, files={"picture": ("a.jpg", large)})
        assert refused.status_code == (401 if role is None else 403)
    assert visit.studio.jobs.ledger.counts()["receiving"] == 0 and visit.studio.jobs.ledger.stored() == held


def test_what_all_pictures_of_a_form_take_is_limited(visit: Visit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: small drawings that become pictures without end or take hours, forms that fill the memory together."""
    data = np.random.default_rng(0).integers(0, 255, (900, 900, 3), dtype=np.uint8)
    made = io.BytesIO()
    Image.fromarray(data).save(made, "JPEG", quality=30)
    sent = [("picture", StoredPicture(f"{k}.jpg", made.getvalue())) for k in range(4)]
    first, *_, last = read_pictures(sent, Limits(pictures_bytes=2_500_000))
    assert isinstance(first, StoredPicture) and isinstance(last, SpecError) and "too large together" in str(last)
    monkeypatch.setattr(pictures, "FORM_SECONDS", -1.0)
    assert "send fewer at a time" in str(read_pictures(sent, LIMITS)[0])
    monkeypatch.setattr(forms, "_large", threading.BoundedSemaphore(1))
    forms._large.acquire()
    large = {"files": {"picture": ("a.jpg", made.getvalue() + b"\0" * 300_000)}}
    result = visit.ask("POST", "/api/badges/pictures", "issuer", **large)
    assert result.status_code == 503 and result.headers["retry-after"] == "60"


def test_the_disk_s_share_holds_for_pictures_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: pictures that fill the disk next to the films."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    with studio(tmp_path, form_bytes=1000, disk_bytes=1_000_000) as visit:
        result = visit.ask("POST", "/api/badges/pictures", "issuer", files={"picture": ("a", b"\0" * 1_200_000)})
        assert result.status_code == 503 and result.json()["code"] == "disk" and visit.left() == []
