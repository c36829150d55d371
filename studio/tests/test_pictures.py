"""Logos and portraits that strangers send: what is read of them, and by whom.  Each test names the wrong
implementation it catches.
"""

from __future__ import annotations

import io

import pytest
from PIL import Image

from kit.webbing import OpenStudio, Visit
from moireid.errors import SpecError
from moireid.sandbox.process import sealed_here
from moireid_studio import pictures
from moireid_studio.auth.guard import Visitor
from moireid_studio.pictures import Reader, read_pictures
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


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio(form_bytes=200_000, picture_bytes=3_000_000, pictures_bytes=5_000_000)


@pytest.mark.slow
def test_an_svg_that_takes_memory_or_time_ends_its_own_process_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a drawing in the server itself, one without limits, a reader that is lost for the next visitor."""
    deep = svg('<g opacity=".5">' * 90 + '<rect width="200" height="200"/>' + "</g>" * 90)
    slow = svg('<g opacity=".5"><rect width="9" height="9"/></g>' * 4000, "0 0 9 9")
    monkeypatch.setattr(pictures, "MOST_SECONDS", 2.0)
    sent = [("logo", StoredPicture(name, data)) for name, data in (("deep", deep), ("slow", slow), ("a.svg", LOGO))]
    memory, late, good = read_pictures(sent, LIMITS)
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


def test_a_picture_is_kept_for_its_visitor_alone(visit: Visit) -> None:
    """Catches: one token's portrait on another's badge, an id that is taken for a path, pictures that stay for ever."""
    sent = {"files": {"picture": ("../../../x/ada.svg", LOGO)}}
    answer = visit.ask("POST", "/api/badges/pictures", "issuer", **sent)
    assert answer.status_code == 201, answer.text
    kept = answer.json()["id"]
    assert [name for name in visit.left() if "ada.svg" in name or "x" in name.split("/")] == []
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
