"""`moireid watch` as it is typed.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from kit.places import FILMS
from kit.streams import pictures, write_stream
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.registry import open_registry
from moireid.verifier.report.live_receipt import film_asked, load_receipt
from moireid_studio.commands.watch_display import line_of, live_display, plain
from moireid_studio.watch.order import WatchOrder

BADGE = ["--badge", str(FILMS / "badge.json")]
PROGRAM = [str(Path(sys.executable).parent / "moireid"), "watch"]


def test_what_a_live_check_measured_is_enrolled(tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: figures that are shown and not kept, or kept of a check that was not accepted or had no prompts; figures
    that replace others without a reason; a registry that a receipt is written over."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    url = f"sqlite:///{tmp_path / 'people.sqlite3'}"
    with open_registry(url, create=True) as registry:
        registry.enroll(ada)
    found = AsBuilt(str(ada.id), -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.03, witnessed=True)
    end = {
        "challenged": True,
        "verdict": "accept",
        "sealed": ["calls"],
        "input": {"decoder": "OpenCV 5"},
        "identity": {"verdict": "match", "decoded_id": ada.id},
    }

    def enrolled(verdict: str, figures: AsBuilt | None, *more: str) -> tuple[int, str]:
        def watch(order: WatchOrder, *rest: Any) -> dict[str, Any]:
            assert order.prompts and order.claim.enrolling == ("--enroll" in more)
            assert not order.claim.enrolling or order.claim.as_built is None
            return end | {"verdict": verdict} | ({"as_built": json.loads(figures.to_json())} if figures else {})

        monkeypatch.setattr("moireid_studio.watch.watching.watch", watch)
        typed = ["watch", "0", "--claim", "Ada Lovelace", "--registry", url, "--challenge", "--json", *more]
        done = CliRunner().invoke(moireid, typed)
        return done.exit_code, done.stderr

    for verdict, figures in (("reject", None), ("reject", found), ("inconclusive", found)):
        code, words = enrolled(verdict, figures, "--enroll")
        assert code != 0 and words.endswith("note: nothing was enrolled, as the live check was not accepted\n")
    end["challenged"] = False
    assert "nothing was enrolled" in enrolled("accept", found, "--enroll")[1]
    end["challenged"] = True
    assert "measured in a live check" in enrolled("accept", found, "--enroll")[1]
    code, words = enrolled("accept", replace(found, offset_rad=1.0), "--enroll")
    assert code == 2 and "offset" in words and "is refused" in words
    with open_registry(url, create=False) as registry:
        assert json.loads(registry.find(str(ada.id)).as_built or "")["offset_rad"] == 3.0
    reason = ["--replace", "--reason", "new sheet"]
    assert enrolled("accept", replace(found, offset_rad=1.0), "--enroll", *reason)[0] == 0
    code, words = enrolled("accept", None, "--receipt", str(tmp_path / "people.sqlite3"), "--overwrite")
    assert code == 2 and "read here" in words
    film, receipt = FILMS / "badge.json", tmp_path / "receipt.json"
    assert enrolled("inconclusive", None, "--receipt", str(receipt), "--about", str(film))[0] == 3
    written = load_receipt(receipt)
    assert (written.claim, written.verdict, written.challenged) == ("Ada Lovelace", "inconclusive", True)
    assert written.film == film_asked(film) and written.registry is not None
    assert (written.sealed, written.decoder) == (("calls",), "OpenCV 5")


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_stream(tmp_path_factory.mktemp("film") / "film.ts", pictures()).read_bytes()


@pytest.mark.slow
def test_each_event_is_a_line_and_the_exit_code_that_of_the_last(film: bytes, tmp_path: Path) -> None:
    """Catches: lines that come at the end alone; talk among them; an exit code of another verdict."""
    done = subprocess.run([*PROGRAM, "-", *BADGE, "--json"], input=film, capture_output=True, timeout=120, check=False)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0 and lines[0]["event"] == "begun" and lines[-1]["event"] == "verdict"
    assert lines[-1]["verdict"] == "accept" and lines[-1]["claim_source"] == "file" and done.stderr == b""
    forged = write_stream(tmp_path / "forged.ts", pictures("forged_drift_1.0m"))
    done = subprocess.run([*PROGRAM, str(forged), *BADGE], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1 and done.stdout.startswith("REJECT: ")


@pytest.mark.slow
def test_an_interrupt_gives_the_verdict_so_far(film: bytes) -> None:
    """Catches: an interrupt that loses what was seen, or is answered with 130."""
    with subprocess.Popen(
        [*PROGRAM, "-", *BADGE, "--json"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        assert running.stdin is not None and running.stdout is not None and running.stderr is not None
        running.stdin.write(film)
        running.stdin.flush()
        assert json.loads(running.stdout.readline())["event"] == "begun"
        time.sleep(4)
        running.send_signal(signal.SIGINT)
        last = json.loads(running.stdout.read().splitlines()[-1])
        assert running.wait(30) == 0 and last["verdict"] == "accept" and last["end"]["why"] == "asked"
        assert b"Traceback" not in running.stderr.read()


def test_lines_for_people_are_whole_and_harmless(capsys: pytest.CaptureFixture[str]) -> None:
    """Catches: a prompt that is not shown; words of a stranger's stream that steer the terminal."""
    assert plain("a\x1b[2J\nb\x9bc") == r"a\u001b[2J\nb\u009bc"
    prompt = {"event": "prompt", "number": 2, "of": 6, "move": "left", "text": "Move it 20 cm to your left."}
    assert line_of(prompt) == "2 of 6: Move it 20 cm to your left."
    status: dict[str, Any] = {"event": "status", "verdict": "reject", "badge": True, "tracked": 3}
    with live_display("a source") as show:
        for reasons in ([{"level": "fail", "text": "first\x1b[2J"}], [{"level": "fail", "text": "second"}]):
            show(status | {"reasons": reasons})
        show(status | {"verdict": "accept", "reasons": []})
    lines = capsys.readouterr().err.splitlines()
    assert [line.split("  ")[-1] for line in lines] == [r"reject: first\u001b[2J", "accept: "]
