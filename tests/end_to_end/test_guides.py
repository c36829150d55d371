"""The guides are true: what they say to type works, what they show comes out, and the site is whole by itself."""

from __future__ import annotations

import ast
import importlib
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import get_args, get_type_hints

import click
import pytest

from kit.guiding import Block, Session, blocks_of, unseen
from kit.places import ROOT
from moireid.cli.main import moireid
from moireid.provenance import Exclusion
from moireid.registry.rollback import CODES
from moireid.verifier.report.finding_words import RIVALS

DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if path.parent.name != "gallery")
FIRST = DOCS / "tutorial" / "first-verdict.md"
#: Pages that people read in the project itself.
READ_THERE = [ROOT / name for name in ("README.md", "ARCHITECTURE.md", "THREATS.md")]
#: Pages that are made from the code as the site is built.
MADE = {f"reference/{name}.html" for name in ("commands", "badge-json", "report-json")}
#: Rooms that have a page each, with an example.
FACES = (
    *("moireid.designer", "moireid.fabrication", "moireid.simulate", "moireid.verifier", "moireid.registry"),
    *("moireid.calibration", "moireid.attest", "moireid.idcodes", "moireid.errors", "moireid_studio.challenge"),
)
#: Blocks that may be left unrun: each needs minutes, a camera or a second machine, and says so.
MOST_UNRUN = 3
#: What makes a browser fetch something; a link that somebody has to click is no such thing.
FETCHES = {
    "link": "href",
    "script": "src",
    "img": "src",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "use": "href",
}
ELSEWHERE = re.compile(r"^\s*(?:[a-z]+:)?//", re.IGNORECASE)


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tutorial, and what it leaves: the files with which the other pages go on."""
    folder = tmp_path_factory.mktemp("walked")
    with Session(folder) as session:
        session.follow(FIRST)
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site as `make docs` builds it."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_every_block_runs_as_its_page_says(walked: Path, tmp_path: Path) -> None:
    """Catches: a command that was renamed, an option that is gone, an exit code or a line shown that does not come.

    All pages are one test, so that the tutorial by which they begin is walked once.
    """
    for page in PAGES:
        if page != FIRST and any(block.kind in ("console", "python") for block in blocks_of(page)):
            folder = tmp_path / page.stem
            shutil.copytree(walked, folder)
            with Session(folder) as session:
                session.follow(page)


def test_hardly_any_block_is_left_unrun() -> None:
    """Catches: a guide that is made to pass by taking its blocks out of the test."""
    blocks = [block for page in PAGES for block in blocks_of(page)]
    assert sum(block.why is not None for block in blocks) <= MOST_UNRUN
    assert sum(block.kind in ("console", "python") and block.why is None for block in blocks) >= 20
    fences = sum(page.read_text(encoding="utf-8").count("\n```") for page in PAGES)
    assert fences == 2 * len(blocks), "a fence is written otherwise than the others, and nobody would run its block"
    assert {block.kind for block in blocks} <= {"console", "python", "text"}


def test_every_command_is_one() -> None:
    """Catches: a command or option in running text, or in a block that is not run, which the programs do not have."""
    wrong = []
    for page in PAGES + READ_THERE:
        text = page.read_text(encoding="utf-8")
        said = re.findall(r"`((?:moireid|print-your-badge) [^`\n]+)`", text)
        typed = "".join(block.body for block in blocks_of(page) if block.kind == "console")
        said += re.findall(r"^(?:\$ )?((?:moireid|print-your-badge) (?:.*\\\n)*.*)", typed, re.MULTILINE)
        wrong += [f"{page.name}: {each}" for each in said if not _is_command(each)]
    assert wrong == []


def _is_command(typed: str) -> bool:
    """Whether the programs have this command with these options; true of what is no command of ours."""
    words = shlex.split(typed, comments=True)
    if not words or words[0] not in ("moireid", "print-your-badge"):
        return True
    command: click.Command = moireid
    rest = words[1:] if words[0] == "moireid" else ["print", *words[1:]]
    while isinstance(command, click.Group) and rest and not rest[0].startswith("-"):
        found = command.get_command(click.Context(command), rest[0])
        if found is None:
            return False
        command, rest = found, rest[1:]
    options = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    options |= {"--help", "--version"}
    return all(word.split("=")[0] in options for word in rest if word.startswith("--"))


def test_every_file_that_is_named_is_there() -> None:
    """Catches: a decision, a figure or a rule that names a file which was moved, renamed or thrown out."""
    gone = []
    for page in PAGES + READ_THERE:
        named = sorted(set(re.findall(r"`([\w./-]+\.(?:py|js|sh|toml|lock)\b)", page.read_text(encoding="utf-8"))))
        places = (ROOT, ROOT / "src", ROOT / "src" / "moireid", ROOT / "studio" / "src", ROOT / "lab" / "src")
        lost = [name for name in named if not any((place / name).exists() for place in places)]
        # Scripts whose question is settled are kept at a tag, which a page that cites one names.
        kept_at_tag = "`ablations-0.1`" in page.read_text(encoding="utf-8")
        gone += [f"{page.name}: {name}" for name in lost if not (kept_at_tag and name.startswith("benchmarks/"))]
    assert gone == []


@pytest.mark.slow
def test_every_reason_code_is_told_and_no_other() -> None:
    """Catches: a finding that nobody documented, and a code on the page that no film can get any more."""
    result = (DOCS / "reference" / "reason-codes.md").read_text(encoding="utf-8")
    rows = "\n".join(line.split("|")[1] for line in result.splitlines() if line.startswith("| `"))
    levels = {"pass", "fail", "undecided", "note"}
    # Why a badge does not count is a code of its own, and so is why a registry is refused.
    barred = get_args(get_type_hints(Exclusion)["code"])
    assert set(re.findall(r"`(\w+)`", rows)) - levels == {*_codes(), *barred, *RIVALS, *CODES}


def _codes() -> Iterator[str]:
    """Every code of a `Reason` or of an audit's finding that is in the source as a word."""
    baseline = ROOT / "lab" / "src" / "moireid_lab" / "baseline"
    places = (ROOT / "src" / "moireid", ROOT / "studio" / "src" / "moireid_studio" / "challenge", baseline)
    for path in (one for place in places for one in place.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = ast.unparse(node.func).split(".")[-1] if isinstance(node, ast.Call) else ""
            makes = isinstance(node, ast.Call) and name in ("Reason", "Fault", "report")
            code: ast.AST | None = node.args[0] if makes and node.args else None
            # The codes of an enrolment's comparison stand in a table there.
            if isinstance(node, ast.Constant) and path.stem == "compare_built":
                code = node if re.fullmatch(r"as_built_\w+", str(node.value)) else None
            if isinstance(code, ast.Constant) and isinstance(code.value, str):
                yield code.value


def test_every_room_has_a_page_with_an_example() -> None:
    """Catches: one long page of all rooms; a room whose page shows nothing at work; a name of a room that was split
    over two pages and is on none, or on both."""
    pages = sorted((DOCS / "reference" / "python").glob("*.md"))
    assert {path.stem for path in pages} >= {"index", *(face.rpartition(".")[2] for face in FACES)}
    shown: dict[str, list[str]] = {}
    for page in pages:
        module, some = re.findall(r"(?m)^\{\{ names ([\w.]+)(?:: ([\w, ]+))? \}\}$", page.read_text(encoding="utf-8"))[
            0
        ]
        assert page.stem in ("index", "objects") or page.stem.split("-")[0] == module.rpartition(".")[2]
        shown.setdefault(module, []).extend(some.split(", ") if some else importlib.import_module(module).__all__)
        kinds = [block.kind for block in blocks_of(page)]
        assert kinds[:2] == ["python", "text"], page
    assert shown.keys() == {"moireid", *FACES}
    for module, names in shown.items():
        every = importlib.import_module(module).__all__
        here = [name for name in every if module != "moireid" or not (name.endswith("Error") or name == "__version__")]
        assert sorted(names) == sorted(here), module


@pytest.mark.slow
def test_what_the_readme_shows_of_python_runs(walked: Path, tmp_path: Path) -> None:
    """Catches: a first page whose Python is of another version."""
    shutil.copytree(walked, tmp_path / "walked")
    page = tmp_path / "readme.md"
    (block,) = (block for block in blocks_of(ROOT / "README.md") if block.kind == "python")
    printed = "\n".join(re.findall(r"^print\(.+\)  # (.+)$", block.body, re.MULTILINE))
    assert printed.startswith("FilmCheck(accept: ")
    page.write_text(f"```python\n{block.body}```\n```text\n{printed}\n```\n", encoding="utf-8")
    with Session(tmp_path / "walked") as session:
        session.follow(page)


def test_the_first_pages_are_short() -> None:
    """Catches: a README that grows back into a book."""
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 100
    assert len((ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").splitlines()) <= 80


def test_a_page_that_shows_what_does_not_come_is_told() -> None:
    """Catches: a runner that compares nothing, so that every page would pass."""
    assert unseen(["ACCEPT: …", "done"], "ACCEPT: it\nmore\ndone\n") is None
    assert unseen(["done", "ACCEPT: …"], "ACCEPT: it\nmore\ndone\n") == "ACCEPT: …"
    assert unseen(["ACCEPT"], "ACCEPT: it\n") == "ACCEPT"


@pytest.mark.parametrize(
    "page",
    [
        "```console\n$ false\n```\n",
        "```console\n$ true   # exit code 1\n```\n",
        "```console\n$ echo one\ntwo\n```\n",
        "```python\nraise SystemExit(0)\n```\n",
        "```python\nprint(1)\n```\n\n```text\n2\n```\n",
        "```python\none = 1\n```\n\n```text\n1\n```\n",
    ],
)
def test_a_page_that_is_wrong_fails(page: str, tmp_path: Path) -> None:
    """Catches: a runner that passes over exit codes, output, or what Python raises."""
    wrong = tmp_path / "page.md"
    wrong.write_text(page)
    with Session(tmp_path) as session, pytest.raises(AssertionError, match=r"page\.md, line [15]"):
        session.follow(wrong)


def test_a_session_lasts_for_its_page(tmp_path: Path) -> None:
    """Catches: a new shell or Python for each block, or a block with a reason that is run all the same."""
    page = tmp_path / "page.md"
    page.write_text(
        "```console\n$ cd / && here=1\n```\n```python\none = 1\n```\n<!-- not run: why -->\n```console\n$ false\n```\n"
        "```console\n$ pwd; echo $here\n/\n1\n```\n```python\nprint(one + 1)\n```\n```text\n2\n```\n"
    )
    with Session(tmp_path) as session:
        session.follow(page)
    assert blocks_of(page)[2] == Block("console", "$ false\n", 8, "why")


class _Fetched(HTMLParser):
    """What a page makes a browser fetch."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        result = dict(attrs)
        if tag == "link" and result.get("rel") in ("canonical", "next", "prev"):
            return
        self.found += [value for name in (FETCHES.get(tag), "srcset", "poster") if name and (value := result.get(name))]
        self.found += re.findall(r"url\(['\"]?([^)'\"]+)", result.get("style") or "")


@pytest.mark.slow
def test_the_site_is_built_strictly_and_asks_nothing_of_outside(site: Path) -> None:
    """Catches: a dead link, a page nobody leads to, and a font, script or picture from another host."""
    pages = sorted(site.rglob("*.html"))
    written = {path.relative_to(DOCS).with_suffix(".html").as_posix() for path in PAGES}
    assert {page.relative_to(site).as_posix() for page in pages} >= written | MADE
    for page in pages:
        fetched = _Fetched(page).found
        assert fetched
        assert [each for each in fetched if ELSEWHERE.match(each)] == [], page.name
        if page.name != "404.html":
            files = [each for each in fetched if not each.startswith("data:")]
            assert [each for each in files if not (page.parent / each.split("?")[0]).exists()] == [], page.name
    for sheet in site.rglob("*.css"):
        asked = re.findall(r"(?:url\(|@import)\s*['\"]?([^)'\"]+)", sheet.read_text(encoding="utf-8"))
        assert [each for each in asked if ELSEWHERE.match(each)] == [], sheet.name


@pytest.mark.slow
def test_every_command_has_its_help_on_the_site(site: Path) -> None:
    """Catches: a page of commands that was written once and forgot the commands that came after."""
    text = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    context = click.Context(moireid)
    for name in moireid.list_commands(context):
        command = moireid.get_command(context, name)
        assert f">moireid {name}<" in text
        for each in command.commands if isinstance(command, click.Group) else ():
            assert f">moireid {name} {each}<" in text


@pytest.mark.slow
def test_every_export_and_every_field_is_on_the_site(site: Path) -> None:
    """Catches: a face whose names have no page, and a key of badge.json or of the report that nobody explains."""
    rooms = {path.stem: path.read_text(encoding="utf-8") for path in (site / "reference" / "python").glob("*.html")}
    top = rooms.pop("index") + rooms.pop("objects")
    for stem in [stem for stem in rooms if "-" in stem]:
        rooms[stem.split("-")[0]] += rooms.pop(stem)
    assert rooms.keys() == {face.rpartition(".")[2] for face in FACES}
    for face in FACES:
        for name in importlib.import_module(face).__all__:
            assert f'id="{face}.{name}"' in rooms[face.rpartition(".")[2]], f"{face}.{name}"
    for name in importlib.import_module("moireid").__all__:
        where = {"simulate": "simulate.film_badge.simulate", "__version__": ""}.get(name, name)
        assert f'id="moireid.{where}"' in top or f'id="moireid.errors.{where}"' in rooms["errors"] or not where, name
    for name in ("badge", "report"):
        page = (site / "reference" / f"{name}-json.html").read_text(encoding="utf-8")
        rows = re.findall(r"<tr>\s*<td>(.*?)</td>\s*<td>.*?</td>\s*<td>(.*?)</td>", page, re.DOTALL)
        assert len(rows) > 30
        assert [field for field, meaning in rows if not meaning.strip()] == [], name


@pytest.mark.slow
def test_every_parameter_on_the_site_is_explained(site: Path) -> None:
    """Catches: a docstring whose entries the site's reader of NumPy style passes over, so that they come out empty."""
    pages = (site / "reference" / "python").glob("*.html")
    shown = "".join(path.read_text(encoding="utf-8") for path in pages)
    items = re.findall(r'<li class="doc-section-item field-body">(.*?)</li>', shown, re.DOTALL)
    empty = [item for item in items if re.search(r'<div class="doc-md-description">\s*</div>', item)]
    assert [re.sub(r"<[^>]+>|\s", "", item) for item in empty] == []


def test_pictures_are_small_and_used() -> None:
    """Catches: a gallery that outgrows the repository, and pictures that no page shows."""
    pictures = [path for path in (DOCS / "gallery").iterdir() if path.suffix != ".md"]
    assert sum(path.stat().st_size for path in pictures) < 1_000_000
    shown = "".join(path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md"))
    assert [path.name for path in pictures if f"gallery/{path.name}" not in shown] == []
