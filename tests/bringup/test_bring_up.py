"""The steps of a first badge, with work that costs nothing.  Next to each test: the fault that it catches."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.bringup.bring_up import STEPS, BuildStep, advance
from moireid.bringup.build_folder import BADGE_JSON, OWN_FILES, STATE, BuildFolder, Figure, Reading, open_folder
from moireid.bringup.progress_page import render_progress, shown_value
from moireid.cli.main import moireid
from moireid.errors import MediaError, SpecError

WITH_FIGURE = Reading(figures=[Figure("P", 1.0, 0.1, "mm", "look", "words")])


class Work:
    """What a step does, counted; it fails where `refuse` says why."""

    def __init__(self, name: str, made: tuple[str, ...] = ()) -> None:
        self.name, self.made, self.times, self.refuse = name, made, 0, ""

    def __call__(self, folder: BuildFolder, _: object) -> Reading:
        self.times += 1
        if self.refuse:
            raise MediaError(self.refuse)
        for name in self.made:
            folder.at(name).write_text("x")
        return Reading(figures=[Figure(self.name, 1.0, 0.1, "mm", "good", "measured")])


def steps_of(first: Work, second: Work, third: Work) -> tuple[BuildStep, ...]:
    """Print something; read a film of it; print once; a film that may be left out is between."""
    ask = ("Put a film into {folder}, of {lens} on {paper}.",)
    return (
        BuildStep("first", "First", "", first, (), made=first.made),
        BuildStep("extra", "Extra", "", Work("extra"), ask, needs=(("extra",),), optional=True),
        BuildStep("second", "Second", "", second, ask, needs=(("film", "photo"),), wishes=("thickness_mm",)),
        BuildStep("third", "Third", "", third, (), made=third.made, once=True),
    )


@pytest.fixture
def works() -> tuple[Work, Work, Work]:
    return Work("first", ("page.txt",)), Work("second"), Work("third", ("badge.txt",))


def test_a_folder_that_could_not_begin_can_begin_otherwise(tmp_path: Path):
    """Catches: a printer too coarse for the sheet that is kept for ever, so that the right one is refused."""
    coarse = advance(open_folder(tmp_path, {"lens": "100lpi-14mil", "printer_dpi": 144}))
    assert coarse.refused and coarse.next_step.name == "charts" and coarse.ask == []
    assert advance(open_folder(tmp_path, {"printer_dpi": 600})).did == ("charts",)


def test_a_round_does_what_it_can_and_asks_for_the_rest(tmp_path: Path, works):
    """Catches: a step that waits for a film and is done without it; one that may be left out and blocks; no advice."""
    found = advance(open_folder(tmp_path), steps_of(*works))
    assert found.did == ("first",) and found.next_step.name == "second" and found.refused is None
    assert found.ask == [f"Put a film into {tmp_path}, of 62 lenses to the inch, about 0.69 mm thick on A4."]
    (tmp_path / "film.mp4").write_text("one")
    found = advance(open_folder(tmp_path), steps_of(*works))
    assert found.did == ("second", "third") and found.next_step is None
    assert "moireid enroll" in found.ask[1]


def test_commands_can_be_copied_from_a_folder_with_a_space(tmp_path: Path, works):
    """Catches: a path that the shell takes for two words."""
    (tmp_path / "my first").mkdir()
    (tmp_path / "my first" / "film.mp4").write_text("one")
    found = advance(open_folder(tmp_path / "my first"), steps_of(*works))
    assert shlex.split(found.ask[1])[2] == str(tmp_path / "my first" / BADGE_JSON)


def test_what_is_wished_is_kept_though_nothing_can_be_done_yet(tmp_path: Path, works):
    """Catches: a calliper's reading that is forgotten before the photo is there; a folder that an interrupt leaves, and
    that is then taken for someone else's."""
    advance(open_folder(tmp_path / "badge", {"thickness_mm": 1.02}), steps_of(*works))
    assert open_folder(tmp_path / "badge").wish.thickness_mm == 1.02

    def interrupted(folder: BuildFolder, _: object) -> Reading:
        folder.at("pitch-test.pdf").write_text("x")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        advance(open_folder(tmp_path / "new"), (BuildStep("first", "First", "", interrupted, ()),))
    assert advance(open_folder(tmp_path / "new"), steps_of(*works)).did == ("first",)


def test_a_badge_that_could_not_be_printed_is_tried_again(tmp_path: Path, works):
    """Catches: a refusal that is kept for ever, as what is printed once has no inputs that change."""
    works[2].refuse = "the name is too long"
    (tmp_path / "film.mp4").write_text("one")
    assert advance(open_folder(tmp_path), steps_of(*works)).refused == "the name is too long"
    works[2].refuse = ""
    assert advance(open_folder(tmp_path, {"name": "Ada"}), steps_of(*works)).did == ("third",)


def test_a_file_that_may_be_left_out_never_stops_the_round(tmp_path: Path, works):
    """Catches: a film of the camera chart that cannot be used and blocks the badge; one that is taken for done."""
    works[1].refuse = "the chart is not seen"
    steps = (replace(steps_of(*works)[1], do=works[1]), steps_of(*works)[3])
    (tmp_path / "extra.mp4").write_text("one")
    found = advance(open_folder(tmp_path), steps)
    assert found.did == ("extra", "third") and found.next_step is None
    assert "Extra: not usable" in render_progress(found)
    assert advance(open_folder(tmp_path), steps).did == ()


def test_nothing_is_read_twice_and_a_new_film_is_read_at_once(tmp_path: Path, works):
    """Catches: films read at every call; an old reading kept for a new film or a new wish; a wish that
    cannot be taken back; a badge printed anew."""
    (tmp_path / "film.mp4").write_text("one")
    for wish, film, did in (
        ({}, "one", ("first", "second", "third")),
        ({}, "one", ()),
        ({}, "two", ("second",)),
        ({"thickness_mm": 1.02}, "two", ("second",)),
        ({}, "two", ()),
        ({"thickness_mm": 0}, "two", ("second",)),
    ):
        (tmp_path / "film.mp4").write_text(film)
        assert advance(open_folder(tmp_path, wish), steps_of(*works)).did == did
    assert works[2].times == 1
    (tmp_path / "badge.txt").unlink()
    assert advance(open_folder(tmp_path), steps_of(*works)).did == ("third",)


def test_a_film_that_cannot_be_used_stops_the_round_and_says_why(tmp_path: Path, works):
    """Catches: a badge printed for a sheet that was not measured; a refusal forgotten, or kept for the next film."""
    works[1].refuse = "the film is dark"
    (tmp_path / "film.mp4").write_text("one")
    for did in (("first", "second"), ()):
        found = advance(open_folder(tmp_path), steps_of(*works))
        assert (found.did, found.refused, found.next_step.name) == (did, "the film is dark", "second")
    assert works[2].times == 0
    works[1].refuse = ""
    (tmp_path / "film.mp4").write_text("two")
    assert advance(open_folder(tmp_path), steps_of(*works)).next_step is None


def test_files_are_found_by_their_names(tmp_path: Path):
    """Catches: a film taken for a photo of the same stem; one of two films that is read without a word."""
    folder = open_folder(tmp_path)
    assert folder.found("film") is None
    for name in ("film.MP4", "film.mp4.txt", "sheet-photo.heic"):
        (tmp_path / name).write_text("x")
    assert folder.found("film") == tmp_path / "film.MP4"
    (tmp_path / "film.mov").write_text("x")
    with pytest.raises(SpecError, match=r"film\.MP4 and film\.mov"):
        folder.found("film")
    with pytest.raises(SpecError, match="export it as JPEG"):
        folder.found("sheet-photo")


def test_a_folder_keeps_what_it_was_begun_for(tmp_path: Path):
    """Catches: a pitch test of another sheet read as this one's; a state file that ends in a traceback."""
    open_folder(tmp_path, {"lens": "75lpi"}).with_reading("charts", Reading()).save()
    assert open_folder(tmp_path).wish.lens == "75lpi"
    with pytest.raises(SpecError, match="begun with lens=75lpi, and 50lpi is given"):
        open_folder(tmp_path, {"lens": "50lpi"})
    with pytest.raises(SpecError, match="99lpi"):
        open_folder(tmp_path / "new", {"lens": "99lpi"})
    assert not (tmp_path / "new").exists()
    (tmp_path / BADGE_JSON).parent.mkdir()
    (tmp_path / BADGE_JSON).write_text("x")
    with pytest.raises(SpecError, match="begun with name=First Badge, and Ada is given"):
        open_folder(tmp_path, {"name": "Ada"})
    (tmp_path / STATE).write_text('{"format": 1, "kind": "something"}')
    with pytest.raises(SpecError, match="kind must be first-badge"):
        open_folder(tmp_path)
    (tmp_path / STATE).write_text("{")
    with pytest.raises(SpecError, match="is not JSON"):
        open_folder(tmp_path)


@pytest.mark.parametrize(
    ("value", "sd", "shown"),
    [
        (0.50917, 0.0000231, "0.509170 ± 0.000023 mm"),
        (44.71, 3.62, "44.7 ± 3.6 mm"),
        (1.0, 0.0, "1 mm"),
        (123.4, 45.0, "123 ± 45 mm"),
        (None, None, "not known"),
    ],
)
def test_figures_are_shown_as_exactly_as_they_are_known(value, sd, shown):
    """Catches: digits that say nothing, or too few; an unknown figure shown as 0."""
    assert shown_value(Figure("a", value, sd, "mm", "good", "")) == shown


def test_the_page_shows_every_figure_and_lets_no_text_be_markup(tmp_path: Path, works):
    """Catches: figures or reasons left out; a name or reason that is run as HTML; a picture that is fetched."""
    works[1].refuse = "<script>alert(1)</script>"
    (tmp_path / "film.mp4").write_text("one")
    found = advance(open_folder(tmp_path), steps_of(*works))
    page = render_progress(replace(found, folder=found.folder.with_reading("extra", WITH_FIGURE)))
    assert "&lt;script&gt;" in page and "<script>" not in page
    assert "1.00 ± 0.10 mm" in page and "look at it" in page and 'src="http' not in page


def test_the_command_begins_prints_and_asks(tmp_path: Path):
    """Catches: talk in the JSON; a page that is not written; files of the wish that are not made."""
    folder = tmp_path / "first"
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder), "--lens", "60lpi", "--json"])
    assert ran.exit_code == 0, ran.output
    found = json.loads(ran.stdout)
    assert found["next"]["name"] == "sheet" and found["did"] == ["charts"] and not found["done"]
    assert any("60 lenses to the inch" in sentence for sentence in found["ask"])
    made = {"pitch-test.pdf", "pitch-test.json", "camera-chart.pdf", "report.html", STATE}
    assert {path.name for path in folder.iterdir()} == made
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder)])
    assert ran.exit_code == 0 and "Next: Photograph the pitch test" in ran.stdout
    (folder / "sheet-photo.jpg").write_bytes(b"no picture")
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder), "--json"])
    assert ran.exit_code == 3 and json.loads(ran.stdout)["refused"]
    record = ["--record", str(tmp_path / "r.json")]
    own = ["--overwrite", "--record", str(folder / STATE)]
    for wrong in (["--with-badge"], record, [*record, "--note", "a" * 2001], own):
        ran = CliRunner().invoke(moireid, ["first-badge", str(folder), *wrong])
        assert ran.exit_code == 2 and "error:" in ran.stderr and not (tmp_path / "r.json").exists()
    assert json.loads((folder / STATE).read_text())["kind"] == "first-badge"


def test_files_of_others_are_not_replaced(tmp_path: Path):
    """Catches: a sheet.json of one's own overwritten, as the folder was given by mistake; a file that is missed."""
    (tmp_path / "sheet.json").write_text("mine")
    with pytest.raises(SpecError, match=r"sheet\.json exists already"):
        open_folder(tmp_path)
    assert {name.split("/")[0] for step in STEPS for name in step.made} <= set(OWN_FILES)


def test_every_step_asks_for_what_it_needs_by_name():
    """Catches: a step whose words do not name the file that it waits for."""
    for step in STEPS:
        for choice in step.needs:
            assert any(any(f"/{name}." in sentence for name in choice) for sentence in step.ask), step.name
