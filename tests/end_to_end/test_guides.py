"""The guides are true: what they say to type works, what they show comes out, and the site is whole by itself."""

from __future__ import annotations

import ast
import math
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from kit.guiding import Session, blocks_of
from kit.places import ROOT
from kit.releasing import tracked_files
from moireid import __version__
from moireid.artwork.template import TEMPLATES
from moireid.cli.main import moireid
from moireid.cli.registry.checks import registry_publish
from moireid.designer.formats import FORMATS
from moireid.fabrication.page.pdf import SCALE_BAR_MM
from moireid.registry.checkpoints.cosignature import DAYS
from moireid.registry.rollback import CODES
from moireid.simulate.effects.table import KINDS
from moireid.verifier.explanations.photographs.cross_fade import MOST_LOOKED_FOR
from moireid.verifier.identity.compare_built import WORDS
from moireid.verifier.limits import LEAST_STRENGTH, MOST_STRENGTH, OWN_MOTION, PROOF_SDS, USUAL_SDS
from moireid.verifier.report.finding_words import RIVALS
from moireid.verifier.session.chapters import CHAPTER_FRAMES
from moireid_lab.evaluation.generator_kit import PROMPTS
from moireid_lab.evaluation.statistics import interval
from moireid_studio.auth.tokens import DEFAULT_DAYS
from moireid_studio.challenge.chance import LEAST_WIDTH_PX
from moireid_studio.challenge.clock import CALL, HERE
from moireid_studio.links import LASTS_MIN
from moireid_studio.settings import Limits
from moireid_studio.watch.order import Patience

DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
FIRST = DOCS / "tutorial" / "first-verdict.md"
#: Pages that people read in the project itself; the list of changes names what is gone, too.
READ_THERE = sorted({*ROOT.glob("*.md"), *ROOT.glob("[!.]*/README.md")} - {ROOT / "CHANGELOG.md"})
#: Pages that are made from the code as the site is built.
MADE = {f"reference/{name}.html" for name in ("commands", "simulation", "badge-json", "report-json")}


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tutorial, and what it leaves: the files with which the other pages go on."""
    folder = tmp_path_factory.mktemp("walked")
    with Session(folder) as session:
        session.follow(FIRST)
    return folder


@pytest.mark.claim("Every block of the guides runs as its page says")
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
    named = [
        one.type for one in command.params if isinstance(one, click.Argument) and isinstance(one.type, click.Choice)
    ]
    if named and rest and not rest[0].startswith("-") and rest[0] not in (*named[0].choices, "SUITE", "…"):
        return False
    options = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    options |= {"--help", "--version"}
    return all(word.split("=")[0] in options for word in rest if word.startswith("--"))


def test_every_link_leads_to_a_file() -> None:
    """Catches: a page, a picture or a file of the source that was moved or removed, and is still named."""
    tracked = [f"/{name}" for name in tracked_files()]
    # Made as the site is built.
    gone, made = [], tuple(Path(page).stem + ".md" for page in MADE)
    for page in PAGES + READ_THERE:
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        linked = [link for pair in re.findall(r"\]\(([^)#\s]+)|\bsrc=\"([^\"]+)", text) for link in pair if link]
        here = {link for link in linked if ":" not in link and not (page.parent / link).exists()}
        gone += [f"{page.name}: {link}" for link in here if not link.endswith(made)]
        named = re.findall(r"`([\w./-]+\.(?:py|js|sh|toml|lock)\b)", text)
        gone += [f"{page.name}: {name}" for name in named if not any(one.endswith(f"/{name}") for one in tracked)]
    assert gone == []


def test_every_option_test_and_code_that_is_named_is_there() -> None:
    """Catches: in running text, an option that no program takes any more, a test that was renamed, a code that no film
    gets any more, a version or a tag that is none."""
    files = [ROOT / name for name in tracked_files() if name.endswith((".py", "run"))]
    source = "".join(file.read_text(encoding="utf-8") for file in files)
    # One of them is pip's.
    options, tests = {"--no-deps", *re.findall(r"--[a-z][\w-]+", source)}, set(re.findall(r"def (test_\w+)", source))
    # One of them is a shell's.
    words = {"zsh_source", *re.findall(r"\w+", source)}
    tags = subprocess.run(["git", "tag"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    gone = []
    for page in PAGES + READ_THERE:
        text = page.read_text(encoding="utf-8")
        versions = re.findall(r"(?<![\w.])v?\d+\.\d+\.\d+(?![\d.])", text)
        gone += [f"{page.name}: {one}" for one in versions if one not in (__version__, *tags)]
        every = re.findall(r"`([^`\n]+)`", text)
        spans = " ".join(every)
        gone += [f"{page.name}: {one}" for one in re.findall(r"(?<![\w-])--[a-z][\w-]+", spans) if one not in options]
        named = re.findall(r"\btest_\w+\b(?!\.py|/)", spans)
        gone += [f"{page.name}: {one}" for one in named if one not in tests]
        alone = (one for one in every if re.fullmatch(r"[a-z]+(_[a-z]+)*", one))
        gone += [f"{page.name}: {one}" for one in alone if one not in words]
    assert gone == []


def test_figures_of_the_guides_are_those_of_the_code() -> None:
    """Catches: a limit or a list that was changed in the code alone."""
    words, studio = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine"], Limits()
    proof = math.exp((PROOF_SDS - USUAL_SDS) * OWN_MOTION.sd_log)
    (lasts,) = (one.default for one in registry_publish.params if one.name == "days")
    golden = len(list((ROOT / "tests" / "data" / "golden").glob("*.signals")))
    said = {
        "docs/how-to/calls.md": (
            f"not grown for {Patience().grown_s:g} s",
            f"read {words[HERE.moves]} moves aloud, which the person must follow within {words[int(HERE.latest_s)]} s",
            f"asks for {words[HERE.moves]} moves",
            f"Tokens end after {DEFAULT_DAYS:g} days",
            f"kept for {'an hour' if studio.keep_s == 3600 else studio.keep_s}",
            f"up to {studio.upload_bytes >> 20} MB",
            f"once, for {'half an hour' if LASTS_MIN == 30 else LASTS_MIN}",
            f"least {LEAST_WIDTH_PX} px wide), and read {words[CALL.moves]} sentences",
            f"judges {words[studio.workers]} films at a time",
        ),
        "docs/how-to/developer.md": (f"chapter of {CHAPTER_FRAMES} frames",),
        "docs/how-to/newsroom.md": (f"({LEAST_STRENGTH} to {MOST_STRENGTH}; default {LEAST_STRENGTH})",),
        "docs/how-to/organiser.md": (f"in the last {DAYS} days", f"counts for {words[int(lasts)]} days"),
        "docs/how-to/researcher.md": (
            f"has {words[len(PROMPTS)]} prompts",
            f"none of 100 is accepted, the true share may still be {100 * interval(0, 100)[1]:.1f} %",
        ),
        "docs/how-to/wear.md": (
            f"scale bar says {SCALE_BAR_MM:g} mm",
            *("`{}` {:g} × {:g}".format(name, *one.size_mm) for name, one in FORMATS.items()),
        ),
        "docs/reference/reason-codes.md": (
            f"usually {proof:.1f} times the first",
            f"two to {words[MOST_LOOKED_FOR]} cross-faded",
        ),
        "CHANGELOG.md": (
            f"{words[len(FORMATS)]} formats, {words[len(TEMPLATES)]} templates",
            f"{len(KINDS)} effects",
        ),
        "CONTRIBUTING.md": (f"verdicts of {golden} films",),
    }
    for page, parts in said.items():
        text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
        text += re.sub(r" \([^()]*\)", "", text)
        assert [part for part in parts if part not in text] == [], page


@pytest.mark.slow
def test_every_reason_code_is_told_and_no_other() -> None:
    """Catches: a finding that nobody documented, and a code on the page that no film can get any more."""
    result = (DOCS / "reference" / "reason-codes.md").read_text(encoding="utf-8")
    rows = "\n".join(line.split("|")[1] for line in result.splitlines() if line.startswith("| `"))
    levels = {"pass", "fail", "undecided", "note"}
    # Why a registry is refused is a code, too.
    built = set(WORDS)
    assert set(re.findall(r"`(\w+)`", rows)) - levels == {*_codes(), *built, *RIVALS, *CODES}


def _codes() -> Iterator[str]:
    """Every code of a `Reason` or of an audit's finding that is in the source as a word."""
    baseline = ROOT / "lab" / "src" / "moireid_lab" / "baseline"
    places = (ROOT / "src" / "moireid", ROOT / "studio" / "src" / "moireid_studio" / "challenge", baseline)
    for path in (one for place in places for one in place.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = ast.unparse(node.func).split(".")[-1] if isinstance(node, ast.Call) else ""
            makes = isinstance(node, ast.Call) and name in ("Reason", "Fault", "report")
            code = node.args[0] if makes and node.args else None
            if isinstance(code, ast.Constant) and isinstance(code.value, str):
                yield code.value


@pytest.mark.slow
def test_what_the_readme_shows_of_python_runs(walked: Path, tmp_path: Path) -> None:
    """Catches: a first page whose Python is of another version."""
    shutil.copytree(walked, tmp_path / "walked")
    page = tmp_path / "readme.md"
    (block,) = (block for block in blocks_of(ROOT / "README.md") if block.kind == "python")
    printed = "\n".join(re.findall(r"^print\(.+\)  # (.+)$", block.body, re.MULTILINE))
    assert printed.startswith("FilmCheck(accept: ")
    # One identity, so that each run is alike.
    code = block.body.replace('format="a6"', 'format="a6", payload="0123456789abcdef"')
    assert code != block.body
    page.write_text(f"```python\n{code}```\n```text\n{printed}\n```\n", encoding="utf-8")
    with Session(tmp_path / "walked") as session:
        session.follow(page)


@pytest.mark.slow
def test_the_site_is_built_strictly(tmp_path: Path) -> None:
    """Catches: a dead link, and a page nobody leads to."""
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 0, done.stderr
    written = {path.relative_to(DOCS).with_suffix(".html") for path in PAGES}
    assert {page.relative_to(tmp_path) for page in tmp_path.rglob("*.html")} >= written
