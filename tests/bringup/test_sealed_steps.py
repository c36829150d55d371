"""Steps that read films, in a process that may be in a stranger's hands.  Each test names the fault that it catches."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from kit.film_taken_over import HostileOrder
from moireid.bringup.bring_up import STEPS
from moireid.bringup.build_folder import BuildFolder, open_folder
from moireid.bringup.sealed_steps import do_sealed
from moireid.errors import MediaError, SpecError
from moireid.reading.film_reader import film_reader

FILMS = next(step for step in STEPS if step.name == "films")
SHEET = next(step for step in STEPS if step.name == "sheet")


@pytest.fixture
def folder(tmp_path: Path) -> BuildFolder:
    """A folder with a badge that was printed, and its films."""
    made = open_folder(tmp_path / "first")
    made.save()
    made.at("badge").mkdir()
    made.at("badge/badge.json").write_text("as it was printed")
    for name in ("badge-film-1.mp4", "badge-film-2.mp4", "sheet-photo.jpg"):
        made.at(name).write_bytes(b"no film " + name.encode())
    return made


def taken_over(write: Callable[[Path], None], **said: Any) -> Any:
    """Readers that write in their folder, and answer, what the attacker likes."""

    class TakenOver:
        sealed = ()

        def read(self, order: Any, progress: Any, answer: Any = None) -> dict[str, Any]:
            write(order.keywords["folder"])
            return {"result": said}

    @contextmanager
    def readers(films: Sequence[Path], *, folder: Path) -> Iterator[Any]:
        yield TakenOver()

    return readers


def test_only_what_a_step_makes_is_taken_over(folder: BuildFolder) -> None:
    """Catches: a film that rewrites the printed badge or the sheet; a file that no step makes; a link followed."""

    def write(aside: Path) -> None:
        for name in ("badge/badge.json", "law-1.svg", "as-built.json", "first-badge.json"):
            (aside / name).write_text("by the attacker")
        (aside / "printer.json").symlink_to("/etc/passwd")

    before = {path: path.read_bytes() for path in folder.path.rglob("*") if path.is_file()}
    for step in (FILMS, SHEET):
        do_sealed(step, folder, None, taken_over(write))
    assert before.items() <= {path: path.read_bytes() for path in before}.items()
    new = {path.name for path in folder.path.rglob("*") if path.is_file()} - {path.name for path in before}
    assert new == {"as-built.json"}


def test_an_answer_of_another_kind_ends_in_a_sentence(folder: BuildFolder) -> None:
    """Catches: figures that are none, kept in the builder's folder."""
    with pytest.raises(MediaError, match="answers what no film shows"):
        do_sealed(FILMS, folder, None, taken_over(lambda aside: None, figures="none"))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such means")
def test_a_step_s_process_reaches_no_other_file(folder: BuildFolder, tmp_path: Path) -> None:
    """Catches: a builder's films that are decoded with all files open; a step that its process cannot do."""
    (tmp_path / "key.pem").write_text("secret")

    @contextmanager
    def readers(films: Sequence[Path], *, folder: Path) -> Iterator[Any]:
        with film_reader(films, folder=folder) as reader:
            yield reader

    @contextmanager
    def stealing(films: Sequence[Path], *, folder: Path) -> Iterator[Any]:
        class Stealing:
            sealed = ()

            def read(self, order: Any, progress: Any, answer: Any = None) -> dict[str, Any]:
                with readers(films, folder=folder) as reader:
                    return reader.read(HostileOrder("steal", str(tmp_path / "key.pem")), progress)

        yield Stealing()

    with pytest.raises(MediaError, match="Permission denied"):
        do_sealed(SHEET, folder, None, stealing)
    # The step itself is done there, where there is no chart.
    with pytest.raises(SpecError, match=r"/moireid-\w+/pitch-test\.json cannot be read"):
        do_sealed(SHEET, folder, None, readers)
