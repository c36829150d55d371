"""The steps of a first badge, with work that costs nothing.  Next to each test: the fault that it catches."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.bringup.bring_up import STEPS, BuildStep, advance
from moireid.bringup.build_folder import OWN_FILES, STATE, BuildFolder, Figure, Reading, open_folder
from moireid.cli.main import moireid
from moireid.errors import MediaError, SpecError


class Work:
    """What a step does, counted; it fails where `refuse` says why."""

    def __init__(self, name: str, made: tuple[str, ...] = ()) -> None:
        self.name, self.made, self.times, self.refuse = name, made, 0, ""

    def __call__(self, folder: BuildFolder, *_: object) -> Reading:
        self.times += 1
        if self.refuse:
            raise MediaError(self.refuse)
        for name in self.made:
            folder.at(name).write_text("x")
        return Reading(figures=[Figure(self.name, 1.0, 0.1, "mm", "measured")])


def steps_of(first: Work, second: Work, third: Work) -> tuple[BuildStep, ...]:
    """Print something; read a film of it; print once."""
    ask = ("Put a film into {folder}, of {lens} on {paper}.",)
    return (
        BuildStep("first", "First", "", first, (), made=first.made),
        BuildStep("second", "Second", "", second, ask, needs=("film",), wishes=("thickness_mm",)),
        BuildStep("third", "Third", "", third, (), made=third.made, once=True),
    )


@pytest.fixture
def works() -> tuple[Work, Work, Work]:
    return Work("first", ("page.txt",)), Work("second"), Work("third", ("badge.txt",))


def test_a_round_does_what_it_can_and_asks_for_the_rest(tmp_path: Path, works):
    """Catches: a step that waits for a film and is done without it; no advice."""
    found = advance(open_folder(tmp_path), steps_of(*works))
    assert found.did == ("first",) and found.next_step.name == "second" and found.refused is None
    assert found.ask == [f"Put a film into {tmp_path}, of 62 lenses to the inch, about 0.69 mm thick on A4."]
    (tmp_path / "film.mp4").write_text("one")
    found = advance(open_folder(tmp_path), steps_of(*works))
    assert found.did == ("second", "third") and found.next_step is None
    assert "moireid enroll" in found.ask[1]


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


def test_a_figure_is_shown_with_two_digits_of_its_error_bar():
    """Catches: an error bar that is rounded away; digits that were not measured; a figure not known as a number."""
    shown = [Figure("P", value, sd, "mm", "").shown for value, sd in ((1.0, 0.1), (0.50713, 2.3e-5), (41.2, 12.0))]
    assert shown == ["1.00 ± 0.10 mm", "0.507130 ± 0.000023 mm", "41 ± 12 mm"]
    assert Figure("P", None, None, "mm", "").shown == "not known"


def test_the_command_begins_prints_and_asks(tmp_path: Path):
    """Catches: talk in the JSON; files of the wish that are not made; a figure to be looked at without its advice."""
    folder = tmp_path / "first"
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder), "--lens", "60lpi", "--json"])
    assert ran.exit_code == 0, ran.output
    found = json.loads(ran.stdout)
    assert found["next"]["name"] == "sheet" and found["did"] == ["charts"] and not found["done"]
    assert any("60 lenses to the inch" in sentence for sentence in found["ask"])
    made = {"pitch-test.pdf", "pitch-test.json", STATE}
    assert {path.name for path in folder.iterdir()} == made
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder)])
    assert ran.exit_code == 0 and "Next: Photograph the pitch test" in ran.stdout
    (folder / "sheet-photo.jpg").write_bytes(b"no picture")
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder), "--json"])
    assert ran.exit_code == 3 and json.loads(ran.stdout)["refused"]
    pale = Reading(figures=[Figure("Twist", 0.5, 0.01, "degrees", "Of the lenses.", "Turn the sheet.")])
    begun = open_folder(folder)
    begun.readings["films"] = pale
    begun.save()
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder)])
    assert "! Twist" in ran.stdout and "Of the lenses. Turn the sheet." in ran.stdout
    assert json.loads((folder / STATE).read_text())["kind"] == "first-badge"


def test_files_of_others_are_not_replaced(tmp_path: Path):
    """Catches: a sheet.json of one's own overwritten, as the folder was given by mistake; a file that is missed."""
    (tmp_path / "sheet.json").write_text("mine")
    with pytest.raises(SpecError, match=r"sheet\.json exists already"):
        open_folder(tmp_path)
    assert {name.split("/")[0] for step in STEPS for name in step.made} <= set(OWN_FILES)


def test_a_folder_that_could_not_begin_can_begin_otherwise(tmp_path: Path):
    """Catches: a printer too coarse for the sheet that is kept for ever, so that the right one is refused."""
    coarse = advance(open_folder(tmp_path, {"lens": "100lpi-14mil", "printer_dpi": 144}))
    assert coarse.refused and coarse.next_step.name == "charts" and coarse.ask == []
    assert advance(open_folder(tmp_path, {"printer_dpi": 600})).did == ("charts",)
