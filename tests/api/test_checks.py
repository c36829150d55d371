"""`mo.verify` and `mo.identify` find what the commands find."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import threading
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

import moireid as mo
from kit.coded_films import first_frames
from kit.places import FILMS
from moireid.designer import Order, design_badge
from moireid.idcodes import specimen_of
from moireid.reading.answers import FilmAnswer
from moireid.reading.film_reader import Reader
from moireid.registry import open_registry
from moireid.sandbox.seal import MEANS

GENUINE, FORGED, BADGE = FILMS / "genuine_1.0m.mp4", FILMS / "forged_reversed_1.0m.mp4", FILMS / "badge.json"
#: What differs from call to call, and the parts of the seal, which the two ways of reading must differ in.
VARIES = ("timing", "sealed")


@pytest.fixture(autouse=True)
def own_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return first_frames(GENUINE, tmp_path_factory.mktemp("film") / "short.mp4", 60)


@pytest.fixture(scope="module")
def genuine() -> mo.FilmCheck:
    return mo.verify(str(GENUINE), badge=str(BADGE))


def without(document: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in document.items() if name not in names}


def test_the_document_is_what_the_command_prints(genuine: mo.FilmCheck) -> None:
    """Catches: a check that leaves out what the command adds to a report, or adds what it does not have."""
    command = [shutil.which("moireid", path=str(Path(sys.executable).parent)) or "", "verify", str(GENUINE)]
    done = subprocess.run([*command, "--badge", str(BADGE), "--json"], capture_output=True, text=True, check=True)
    printed = json.loads(done.stdout)
    assert without(json.loads(json.dumps(genuine.to_json())), *VARIES) == without(printed, *VARIES)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such seal")
def test_a_film_is_read_in_a_sealed_process_unless_it_is_said_otherwise(genuine: mo.FilmCheck, short: Path) -> None:
    """Catches: a film of a stranger that is decoded with the rights of a notebook, unasked."""
    assert set(genuine.document["sealed"]) == set(mo.verify(short, badge=BADGE, pictures=False).document["sealed"])
    assert set(genuine.document["sealed"]) <= set(MEANS) and genuine.document["sealed"]
    loaded = "import sys, moireid as mo; mo.verify(sys.argv[1], badge=sys.argv[2], pictures=False); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", loaded, short, BADGE], capture_output=True, text=True, check=True)
    assert "av" not in done.stdout.split()
    assert mo.verify(short, badge=BADGE, pictures=False, unsealed=True).document["sealed"] == []


def test_checks_run_in_threads_and_without_a_main_file(short: Path) -> None:
    """Catches: a process that is made by running the caller's program again, as a notebook has none."""
    found: list[str] = []
    threads = [
        threading.Thread(target=lambda: found.append(mo.verify(short, badge=BADGE, pictures=False).verdict))
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 3
    assert len(set(found)) == 1


def test_the_outcome_in_words_page_arrays_and_plot(genuine: mo.FilmCheck, tmp_path: Path) -> None:
    """Catches: an outcome that is long at the prompt, or whose page, arrays or plot are missing."""
    assert (genuine.verdict, genuine.accepted) == ("accept", True)
    assert repr(genuine) == f"FilmCheck(accept: {genuine.headline.title})"
    html = genuine._repr_html_()
    assert genuine.headline.title in html
    assert "data:image/svg+xml;base64," in html
    assert len(genuine.signals()["time_s"]) > 60
    assert genuine.plot()._repr_png_().startswith(b"\x89PNG")
    assert [path.name for path in genuine.write(tmp_path / "pages")] == ["report.html", "report.json", "signals.csv"]
    with pytest.raises(mo.SpecError, match="exists already"):
        genuine.write(str(tmp_path / "pages"))


@pytest.mark.slow
def test_a_claim_is_looked_up_in_a_registry_by_path_url_or_object(tmp_path: Path, short: Path) -> None:
    """Catches: a plain path that is taken for a URL; an open registry that is closed; one made by a verify."""
    badge = design_badge(Order("Ada Lovelace", lens="50lpi"), bytes(range(8)))
    with mo.Registry(tmp_path / "people.sqlite3", create=True) as registry:
        registry.enroll(badge)
        for place in (registry, tmp_path / "people.sqlite3", str(tmp_path / "people.sqlite3"), registry.shown_url):
            check = mo.verify(short, claim="Ada Lovelace", registry=place, pictures=False)
            assert check.document["badge"]["name"] == "Ada Lovelace"
            assert (check.document["claim_source"], check.accepted) == ("registry", False)
            assert check.document["registry"]["fingerprint"] == registry.fingerprint
        assert registry.find("Ada Lovelace").badge == badge
        by_file = mo.verify(short, badge=badge, registry=registry, pictures=False)
        assert by_file.document["claim_source"] == "registry"
        with pytest.raises(mo.RegistryError, match="Grace"):
            mo.verify(short, claim="Grace Hopper", registry=registry)
        found = mo.identify(short, registry=registry)
        assert (found.accepted, found.found_id, found.found_name) == (False, None, None)
    with pytest.raises(mo.RegistryError):
        mo.verify(short, claim="Ada Lovelace", registry=tmp_path / "absent.sqlite3")
    assert not (tmp_path / "absent.sqlite3").exists()


def test_a_bundle_is_asked_in_place_of_a_registry(tmp_path: Path, short: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a bundle that is taken and not asked; its first sight that goes without a warning."""
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as registry:
        registry.enroll(design_badge(Order("Ada Lovelace", lens="50lpi"), bytes(range(8))))
        registry.publish(tmp_path / "people.bundle", specimen_of, days=30)
    # Another user's memory.
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "other.sqlite3"))
    with pytest.warns(UserWarning, match="is seen for the first time"):
        check = mo.verify(short, claim="Ada Lovelace", bundle=str(tmp_path / "people.bundle"), pictures=False)
    assert check.document["claim_source"] == "bundle"
    assert mo.identify(short, bundle=tmp_path / "people.bundle").verdict in ("nobody", "inconclusive")


@pytest.mark.parametrize(
    "result", [{"finding": "found", "found_id": 5, "reasons": []}, {"finding": "found"}, [1], None]
)
def test_an_answer_that_no_film_shows_is_refused(
    tmp_path: Path, short: Path, monkeypatch: pytest.MonkeyPatch, result: Any
) -> None:
    """Catches: `mo.identify` that passes on what a taken-over process answers, or ends in a traceback by it."""

    class Hostile(Reader):
        def read(self, order: Any, progress: Any) -> FilmAnswer:
            return super().read(lambda _: iter([{"result": result}]), progress)

    monkeypatch.setattr("moireid.api.checks.film_reader", lambda films, unsealed: nullcontext(Hostile()))
    with mo.Registry(tmp_path / "people.sqlite3", create=True) as registry, pytest.raises(mo.MediaError):
        mo.identify(short, registry=registry)
