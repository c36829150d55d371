"""What the programs do with what is wrong: exit code 2, one sentence, nothing on stdout, nothing left behind.

Most calls run `main()` in this process, with the file descriptors captured, so that also what C libraries write to
stderr counts; a few run the programs as a person would.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from moireid.badge import Badge
from moireid.cli.main import main, print_your_badge
from moireid.designer import Order, design_badge
from moireid.fabrication import package
from moireid.registry import open_registry
from moireid.verifier.video import Film

#: A warning of numpy would be one more line on a person's stderr, which pytest swallows.
pytestmark = pytest.mark.filterwarnings("error::RuntimeWarning")

BIN = Path(sys.executable).parent
REGISTRY = "sqlite:///people.sqlite3"
#: The identities of two people of one name, of either code family.
BOBS = ("0102030405060708", "0a0b0c")


@dataclass(frozen=True)
class Outcome:
    """How a program ended: exit code and all that it wrote."""

    code: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        """The one JSON object on stdout."""
        assert len(self.out.splitlines()) == 1, self.out
        return json.loads(self.out)


Run = Callable[..., Outcome]


def snapshot(folder: Path) -> dict[str, tuple[int, int] | None]:
    """Every file and folder under a folder, hidden ones too, with size and time of change."""
    return {
        str(path.relative_to(folder)): (path.stat().st_size, path.stat().st_mtime_ns) if path.is_file() else None
        for path in folder.rglob("*")
    }


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A home of its own, where the default registry and the keys of registries lie."""
    monkeypatch.delenv("MOIREID_TRACEBACK", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    """Run `moireid` (or another entry point) in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str, entry: Callable[[], None] = main) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["program", *arguments])
        # A program that leaves may put its streams away; the next call must have them all the same.
        streams = sys.stdout, sys.stderr
        capfd.readouterr()
        with pytest.raises(SystemExit) as left:
            entry()
        sys.stdout, sys.stderr = streams
        out, err = capfd.readouterr()
        code = left.value.code
        return Outcome(code if isinstance(code, int) else int(code is not None), out, err)

    return call


@pytest.fixture
def refused(run: Run, tmp_path: Path) -> Callable[..., str]:
    """Run, hold the outcome against the contract for bad input, and hand back the sentence."""

    def call(*arguments: str, entry: Callable[[], None] = main) -> str:
        before = snapshot(tmp_path)
        outcome = run(*arguments, entry=entry)
        lines = outcome.err.splitlines()
        assert (outcome.code, outcome.out) == (2, ""), outcome
        assert len(lines) == 1 and lines[0].startswith("error: "), outcome.err
        # The net under everything is for surprises; whatever is tried here ought to have been expected.
        assert "Traceback" not in outcome.err and "inside moireid" not in outcome.err, outcome.err
        assert len(lines[0]) < 700, lines[0]
        assert snapshot(tmp_path) == before, "something was left behind"
        return lines[0]

    return call


@pytest.fixture
def badge_file(tmp_path: Path, ada: Badge) -> Path:
    path = tmp_path / "ada.json"
    path.write_text(ada.to_json(), encoding="utf-8")
    return path


@pytest.fixture
def people(tmp_path: Path, ada: Badge) -> None:
    """A registry with Ada, and two people called Bob."""
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as registry:
        registry.enroll(ada)
        for payload in BOBS:
            registry.enroll(design_badge(Order("Bob", lens="50lpi"), bytes.fromhex(payload)))


# print


@pytest.mark.parametrize(
    "name",
    ["", "   ", "a\x07b", "a\nb", "x" * 1000, "\udcff\udcfe", "\u200b", "a\u2028b", "\u202eabc"],
    ids=lambda n: ascii(n[:6]),
)
def test_a_name_that_is_none_is_refused(refused: Callable[..., str], name: str) -> None:
    """Catches: a folder made before the name was looked at, a name that prints as nothing or as another."""
    assert "name" in refused(name, "--out", "new", "--mount", "none", entry=print_your_badge)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--payload", "zz"], "16 or 32 hex"),
        (["--axes", "y"], "--axes"),
        (["--range", "2.5-0.8"], "0.8-2.5"),
        (["--range", "0.8-1e308"], "range"),
        (["--size", "1x1"], "60x66"),
        (["--size", "infx160"], "146x160"),
        (["--mount", "no\nne"], "--mount"),
        (["--front", "glass"], "--front"),
        (["--mount", "none", "--mount-figure", "kerf_mm=0.1"], "--mount lanyard"),
        (["--mount", "none", "--mount-figure", "card_mm=0.5"], "--mount lanyard"),
        (["--no-such\noption"], "--no-such"),
        (["--registry", "postgresql:people"], "sqlite:///people.sqlite3"),
        (["--registry", "sqlite:///new.sqlite3", "--size", "1x1"], "60x66"),
        (["--registry", "sqlite:///new.sqlite3", "--payload", "zz"], "16 or 32 hex"),
    ],
    ids=lambda value: " ".join(value)[:30].replace("\n", "|") if isinstance(value, list) else "",
)
def test_a_wish_that_cannot_be_is_refused(refused: Callable[..., str], options: list[str], words: str) -> None:
    """Catches: a refusal that comes after the folder, or an empty registry, was made; a message without a way out."""
    mount = [] if "--mount" in options else ["--mount", "none"]
    assert words in refused("print", "Ada", "--out", "new", *mount, *options, "--json")


@pytest.mark.claim("Nothing is overwritten without --overwrite")
def test_outputs_that_cannot_be_written_are_refused(refused: Callable[..., str], tmp_path: Path) -> None:
    """Catches: work that is done before the folder is looked at.  A path below a file stops even root."""
    (tmp_path / "file").write_text("mine")
    (tmp_path / "here").mkdir()
    (tmp_path / "here/preview.png").write_text("mine")
    assert "exists already; add --overwrite" in refused("print", "Ada", "--out", "here", "--mount", "none")
    assert "cannot be made" in refused("print", "Ada", "--out", "file/x", "--mount", "none")
    issue = ("--registry", "sqlite:///new.sqlite3")
    assert "cannot be made" in refused("print", "Ada", "--out", "file/x", "--mount", "none", *issue)
    assert "exists already" in refused("print", "Ada", "--out", "here", "--mount", "none", *issue)
    assert "file" in refused("print", "Ada", "--out", "file", "--mount", "none")
    assert "too long" in refused("print", "Ada", "--out", "y" * 300, "--mount", "none")
    refused("print", "Ada")
    refused("print")


@pytest.mark.claim("An interrupt leaves nothing half done")
def test_an_interrupt_leaves_nothing(run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Catches: half the files of a badge, or a traceback, when a person presses Ctrl-C."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    (tmp_path / "new").mkdir()
    monkeypatch.setattr(package, "write_preview", interrupt)
    outcome = run("print", "Ada", "--out", "new", "--mount", "none", "--json")
    assert (outcome.code, outcome.out) == (130, "")
    assert outcome.err.splitlines()[-1].startswith("interrupted")
    assert os.listdir("new") == []


# Films


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)


def _list_of_files(path: Path, films: Path) -> None:
    shutil.copy(films / "genuine_1.0m.mp4", path.parent / "other.mp4")
    _write(path, b"ffconcat version 1.0\nfile other.mp4\n")


NO_FILMS: dict[str, Callable[[Path, Path], object]] = {
    "missing.mp4": lambda path, films: None,
    "folder.mp4": lambda path, films: path.mkdir(),
    "empty.mp4": lambda path, films: _write(path, b""),
    "cut.mp4": lambda path, films: _write(path, (films / "genuine_1.0m.mp4").read_bytes()[:60000]),
    "text.mp4": lambda path, films: _write(path, b"hello world\n"),
    "noise.mp4": lambda path, films: _write(path, bytes((i * i * 7919 >> 5) & 255 for i in range(5000))),
    "drawing.nfo": lambda path, films: _write(path, b"a badge, drawn in letters\n" * 40),
    "list.m3u8": lambda path, films: _write(path, b"#EXTM3U\n#EXTINF:1,\nother.mp4\n"),
    "list.ffconcat": _list_of_files,
    "badge.mp4": lambda path, films: shutil.copy(films / "badge.json", path),
}


@pytest.mark.claim("Wrong input ends with exit code 2 and one sentence")
@pytest.mark.parametrize("name", NO_FILMS)
def test_what_is_no_film_is_refused(
    refused: Callable[..., str], badge_file: Path, people: None, films: Path, tmp_path: Path, name: str
) -> None:
    """Catches: FFmpeg's own errors handed on; text that FFmpeg draws as a film; a list that names another film, whose
    SHA-256 would then stand in the report for what was never looked at."""
    NO_FILMS[name](tmp_path / name, films)
    assert name in refused("verify", name, "--badge", "ada.json", "--json")
    assert name in refused("identify", name, "--registry", REGISTRY, "--json")
    assert name in refused("verify", name, "--claim", "Ada Lovelace", "--registry", REGISTRY, "--report", ".")


@pytest.mark.parametrize("name", ["file:film.mp4", "http:film.mp4", "concat:a|b.mp4", "-film.mp4", "two\nlines.mp4"])
def test_a_film_is_the_file_of_its_name(
    tmp_path: Path, films: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Catches: a name that FFmpeg takes for a protocol, so that it plays another file than the one that is hashed."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(films / "genuine_1.0m.mp4", name)
    assert (Film(Path(name)).width, next(Film(Path(name)).frames()).luma.shape) == (1920, (1080, 1920))


@pytest.mark.claim("A name is matched exactly; two people of one name end with exit code 2")
def test_claims_that_nobody_answers_to_are_refused(
    refused: Callable[..., str], badge_file: Path, people: None, films: Path, ada: Badge
) -> None:
    """Catches: the first of two namesakes taken; a claim matched by its beginning, in another case, or as a pattern."""
    film = str(films / "genuine_1.0m.mp4")
    for claim in ("Nobody", "", "ada lovelace", " Ada Lovelace", "Ada", "Ada%", "0102030405", "*", "a\nb"):
        assert "no one named" in refused("verify", film, "--claim", claim, "--registry", REGISTRY, "--json")
    both = refused("verify", film, "--claim", "Bob", "--registry", REGISTRY)
    assert BOBS[0] in both and BOBS[1] in both
    assert "either" in refused("verify", film)
    assert "either" in refused("verify", film, "--badge", "ada.json", "--claim", "Ada Lovelace")
    assert "no registry" in refused("verify", film, "--claim", "Ada Lovelace", "--registry", "sqlite:///none.sqlite3")
    assert "no registry" in refused("verify", film, "--claim", "Ada Lovelace")
    assert "cannot be read" in refused("verify", film, "--badge", "none.json")


def test_a_report_in_the_way_is_seen_before_the_film(
    refused: Callable[..., str], badge_file: Path, tmp_path: Path
) -> None:
    """Catches: minutes of work that end in "exists already".  The film is absent, which only who opens it finds out."""
    (tmp_path / "old").mkdir()
    (tmp_path / "old/report.json").write_text("mine")
    assert "report.json exists" in refused("verify", "none.mp4", "--badge", "ada.json", "--report", "old")
    assert "cannot be made" in refused("verify", "none.mp4", "--badge", "ada.json", "--report", "ada.json/x")


@pytest.mark.slow
def test_a_claim_that_a_board_cannot_bear_out_is_not_accepted(
    run: Run, prototype: Badge, films: Path, tmp_path: Path
) -> None:
    """Catches: a badge with an id but no code, whose film is accepted for its motion alone: who holds *any* board of
    that kind would be whom the registry says.  Also: stdout holds one JSON object and nothing else, with a report.
    """
    (tmp_path / "b.json").write_text(replace(prototype, id="3fa20c3fa20c3fa2").to_json())
    film = str(films / "genuine_1.0m.mp4")
    outcome = run("verify", film, "--badge", "b.json", "--json", "--report", "report")
    document = outcome.document
    assert (document["identity"]["verdict"], document["verdict"]) == ("unreadable", "inconclusive")
    assert outcome.code == 3
    assert sorted(os.listdir("report")) == ["report.html", "report.json", "signals.csv"]
    assert [line.split(":")[0] for line in outcome.err.splitlines()] == ["report"]


# badge.json


def _set(*path: str | int, value: object) -> Callable[[dict[str, Any]], None]:
    def change(document: Any) -> None:
        for key in path[:-1]:
            document = document[key]
        document[path[-1]] = value

    return change


WRONG_BADGES: dict[str, Callable[[dict[str, Any]], object]] = {
    "lens.pitch_mm": _set("lens", "pitch_mm", value="0.508"),
    "NaN": _set("gratings", 0, "cells", 0, "pitch_mm", value=float("nan")),
    "markers.dictionary": _set("markers", "dictionary", value="DICT_9X9"),
    "digits": _set("markers", "centers_mm", 0, 0, value=10**400),
    "format 3": _set("format", value=3),
}


@pytest.mark.parametrize("words", WRONG_BADGES)
def test_a_badge_file_that_is_wrong_is_refused_by_every_command(
    refused: Callable[..., str], badge_file: Path, tmp_path: Path, films: Path, words: str
) -> None:
    """Catches: one command that reads badge files another way; a wrong badge entered into a registry for good."""
    document = json.loads(badge_file.read_text(encoding="utf-8"))
    WRONG_BADGES[words](document)
    (tmp_path / "wrong.json").write_text(json.dumps(document))
    assert words in refused("verify", str(films / "genuine_1.0m.mp4"), "--badge", "wrong.json")
    assert words in refused("enroll", "wrong.json", "--registry", "sqlite:///new.sqlite3", "--json")
    assert words in refused("simulate", "wrong.json", "--out", "new.mp4", "--frames", "2")


def test_a_badge_that_could_never_be_verified_is_not_enrolled(
    refused: Callable[..., str], badge_file: Path, films: Path, ada: Badge, tmp_path: Path
) -> None:
    """Catches: an id edited by hand, whose genuine films are all rejected; a board without identity; and the empty
    registry that such a refusal would leave."""
    badge_file.write_text(replace(ada, id="0000000000000001").to_json())
    assert "0000000000000001" in refused("enroll", "ada.json", "--registry", "sqlite:///new.sqlite3")
    assert "identity" in refused("enroll", str(films / "badge.json"), "--registry", "sqlite:///new.sqlite3")
    uncoded = replace(ada, gratings=(replace(ada.gratings[0], code=None),))
    badge_file.write_text(uncoded.to_json())
    assert "identity" in refused("enroll", "ada.json", "--registry", "sqlite:///new.sqlite3")


# simulate


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "film.txt"], "film film.txt cannot"),
        (["--out", "film.webm"], "name it .mp4 or .mkv"),
        (["--out", ""], "folder"),
        (["--out", "ada.json/film.mp4"], "cannot be made"),
        (["--out", "ada.json"], "exists already"),
        (["--out", "new.mp4", "--motion", "none.csv"], "none.csv"),
        (["--out", "new.mp4", "--motion", "bad.csv"], "bad.csv"),
        (["--out", "new.mp4", "--distance", "nan"], "--distance"),
        (["--out", "new.mp4", "--fps", "nan"], "nan"),
        (["--out", "new.mp4", "--frames", "1"], "--frames"),
        (["--out", "new.mp4", "--forge", "magic"], "frozen"),
        (["--out", "new.mp4", "--forge", "photo", "--backend", "mitsuba"], "true badges"),
        (["--out", "new.mp4", "--camera", "wide", "--backend", "mitsuba"], "distortion"),
        (["--out", "new.webm", "--effect", "hlg", "--frames", "2"], "name it .mp4 or .mkv"),
        (["--out", "new.mp4", "--forge", "late", "--backend", "mitsuba"], "analytic"),
    ],
    ids=lambda value: " ".join(value)[6:] if isinstance(value, list) else "",
)
def test_a_film_that_cannot_be_made_is_refused(
    refused: Callable[..., str], badge_file: Path, tmp_path: Path, options: list[str], words: str
) -> None:
    """Catches: a half-made film or a temporary file, and a message that names the temporary file."""
    (tmp_path / "bad.csv").write_text("t_s,x_mm\n0,1\n")
    assert words in refused("simulate", "ada.json", *options)


# registry, usage, JSON


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["dance"], "'dance'. See 'moireid --help'"),
        (["--dance"], "moireid --help"),
        (["verify"], "VIDEO"),
        (["simulate", "a.json"], "--out"),
        (["registry", "dance"], "'dance'. See 'moireid registry --help'"),
        (["registry", "show"], "NAME|ID"),
        (["two\nlines"], "two"),
    ],
    ids=lambda value: " ".join(value).replace("\n", "|") if isinstance(value, list) else "",
)
def test_wrong_usage_is_one_sentence(refused: Callable[..., str], arguments: list[str], words: str) -> None:
    """Catches: click's three lines of usage, and a pointer to the help of another command."""
    assert words in refused(*arguments)


@pytest.mark.claim("--json prints one object on stdout and nothing else")
@pytest.mark.slow
def test_json_is_one_object_and_talk_goes_elsewhere(run: Run, tmp_path: Path) -> None:
    """Catches: progress or notes on stdout, JSON over several lines, keys that the contract names left out."""
    url = ("--registry", REGISTRY, "--json")
    printed = run("Zoë Ж", "--out", "z", "--mount", "none", "--explain", *url, entry=print_your_badge)
    assert printed.code == 0 and printed.document["issued"] is True
    # Whether some font has both scripts is the machine's; a note says where none has.
    output = [line for line in printed.err.splitlines() if not line.startswith("note: no font")]
    assert output == []
    badge_id = printed.document["id"]
    enrolled = run("enroll", "z/badge.json", *url)
    assert (enrolled.code, enrolled.err) == (0, "")
    assert (enrolled.document["id"], enrolled.document["name"]) == (badge_id, "Zoë Ж")
    assert run("registry", "init", *url).document["badges"] == 1
    listed = run("registry", "list", *url).document["badges"]
    assert [(row["id"], row["name"]) for row in listed] == [(badge_id, "Zoë Ж")]
    for claim in ("Zoë Ж", "Zoe\u0308 Ж", badge_id, badge_id.upper()):
        shown = run("registry", "show", claim, *url)
        # What the printer's dots make of it is in the file alone: it is no part of the badge.
        file = json.loads((tmp_path / "z/badge.json").read_text(encoding="utf-8"))
        assert shown.code == 0 and shown.document["badge"] | {"realised": file["realised"]} == file
    again = run("print", "Zoë Ж", "--out", "z2", "--mount", "none", *url)
    assert again.document["id"] != badge_id
    same = run("print", "Zoë Ж", "--out", "z3", "--mount", "none", "--payload", badge_id, *url)
    assert same.document["id"] == badge_id and run("registry", "init", *url).document["badges"] == 2


# As a person runs them


def program(*arguments: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    clean = {key: value for key, value in os.environ.items() if key not in ("MOIREID_TRACEBACK", "PYTHONIOENCODING")}
    return subprocess.run(
        [str(BIN / arguments[0]), *arguments[1:]], cwd=folder, env=clean | environment, capture_output=True, timeout=120
    )


def test_output_that_nobody_takes_is_no_traceback(tmp_path: Path, people: None) -> None:
    """Catches: a full disk under stdout of --help, and `moireid registry list | head -1`."""
    for arguments in (["--help"], ["registry", "list", "--registry", REGISTRY]):
        with open("/dev/full", "wb") as full:
            done = subprocess.run(
                [str(BIN / "moireid"), *arguments], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, timeout=120
            )
        assert done.returncode == 2 and b"Traceback" not in done.stderr and done.stderr.count(b"\n") == 1, done.stderr
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [str(BIN / "moireid"), "registry", "list", "--registry", REGISTRY],
        cwd=tmp_path,
        stdout=writer,
        stderr=subprocess.PIPE,
        timeout=120,
    )
    os.close(writer)
    assert (done.returncode != 0, done.stderr) == (True, b"")


HEAVY = {"OCP", "build123d", "cadquery", "manifold3d", "matplotlib", "mitsuba", "numba", "scipy", "trimesh"}
HEAVY |= {"dask", "distributed", "fsspec", "pyarrow"}


@pytest.mark.claim("Heavy packages are loaded by the work that needs them")
@pytest.mark.parametrize(
    ("arguments", "spared"),
    [
        (["print", "--help"], HEAVY | {"av", "cv2", "jsonschema", "numpy", "reportlab", "sqlalchemy"}),
        (["print", "Ada", "--out", "new", "--mount", "none"], HEAVY | {"av", "sqlalchemy"}),
        (["enroll", "ada.json", "--registry", REGISTRY], HEAVY | {"av", "cv2", "reportlab"}),
        (["verify", "none.mp4", "--badge", "ada.json"], HEAVY | {"reportlab", "sqlalchemy"}),
    ],
    ids=lambda value: " ".join(value)[:12] if isinstance(value, list) else "",
)
def test_a_command_loads_no_package_that_it_does_not_need(
    tmp_path: Path, badge_file: Path, arguments: list[str], spared: set[str]
) -> None:
    """Catches: an import at the top of a module that makes `--help` wait for build123d (5 s)."""
    code = (
        "import sys\n"
        "from moireid.cli.main import main\n"
        f"sys.argv = {['moireid', *arguments]!r}\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print('LOADED', *{name.split('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    loaded = set(done.stderr.splitlines()[-1].split())
    assert "LOADED" in loaded and "click" in loaded, done.stderr
    assert loaded & spared == set()


def test_a_camera_is_given_once_and_as_a_calibration(refused: Callable[..., str], badge_file: Path) -> None:
    """Catches: two focal lengths; a camera file that is read only once the film was."""
    Path("camera.json").write_text("{}")
    film = ("verify", "film.mp4", "--badge", "ada.json", "--camera", "camera.json")
    assert "--camera holds the focal length" in refused(*film, "--focal-px", "900")
    assert "--focal-px" in refused(*film[:-2], "--focal-px", "-3")
    for option in ("--cover", "--track"):
        assert f"cannot check {option}" in refused(*film[:-2], option, "0", "--pipeline", "published")
    assert "holds no calibration" in refused("identify", "film.mp4", "--registry", REGISTRY, "--camera", "camera.json")
