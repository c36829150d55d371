"""Steps that read films, in a process that may be in a stranger's hands.  Each test names the fault that it catches."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

from kit.film_taken_over import HostileOrder
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.bringup import badge_steps
from moireid.bringup.bring_up import STEPS
from moireid.bringup.build_folder import BuildFolder, open_folder
from moireid.calibration import film_orders
from moireid.designer.chart import design_chart
from moireid.errors import MediaError, MoireIdError, SpecError
from moireid.fabrication.page.chart_page import print_chart
from moireid.reading.film_reader import Reader, film_reader

FILMS = next(step for step in STEPS if step.name == "films")
SHEET = next(step for step in STEPS if step.name == "sheet")


def quiet(done: int, of: int | None) -> None:
    """Show no progress."""


@pytest.fixture
def folder(tmp_path: Path, ada: Badge) -> BuildFolder:
    """A folder with a chart and a badge that were printed, and their films."""
    made = open_folder(tmp_path / "first")
    made.save()
    print_chart(design_chart(), made.path)
    made.at("badge").mkdir()
    made.at("badge/badge.json").write_text(ada.to_json(), encoding="utf-8")
    for name in ("badge-film-1.mp4", "badge-film-2.mp4", "sheet-photo.jpg"):
        made.at(name).write_bytes(b"no film " + name.encode())
    return made


def taken_over(**said: Any) -> Any:
    """Readers that answer what the attacker likes."""

    class TakenOver(Reader):
        def read(self, order: Any, progress: Any) -> Any:
            return super().read(lambda _: iter([{"result": said}]), progress)

    return lambda films: nullcontext(TakenOver())


def test_only_figures_of_this_badge_are_kept(folder: BuildFolder, ada: Badge) -> None:
    """Catches: figures that are none, or another badge's, kept in the builder's folder."""
    mine = json.loads(AsBuilt(str(ada.id), -0.04, 2e-5, 3.0, 0.04, 0.03, 3e-4, 0.99, 0.01).to_json())
    wrong: tuple[dict[str, Any], ...] = (
        {"figures": "none"},
        {"reading": {"figures": "none"}},
        {"reading": {}},
        {"reading": {}, "as_built": mine | {"badge_id": "ab" * 8}},
        {"reading": {}, "as_built": mine | {"gain_ratio": 9.0}},
    )
    for said in wrong:
        with pytest.raises((MediaError, SpecError)):
            FILMS.do(folder, quiet, taken_over(**said))
        assert not folder.at("as-built.json").exists()
    assert FILMS.do(folder, quiet, taken_over(reading={"refused": "dark"})).refused == "dark"
    assert not folder.at("as-built.json").exists()
    FILMS.do(folder, quiet, taken_over(reading={}, as_built=mine))
    assert json.loads(folder.at("as-built.json").read_text())["badge_id"] == ada.id


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such means")
@pytest.mark.parametrize("step", [SHEET, FILMS], ids=lambda step: step.name)
def test_a_step_s_process_reaches_no_other_file(
    step: Any, folder: BuildFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a builder's films that are decoded with all files open; a step that its process cannot do."""
    (tmp_path / "key.pem").write_text("secret")
    asked: list[Sequence[Path]] = []

    def readers(films: Sequence[Path]) -> Any:
        asked.append(films)
        return film_reader(films)

    # The step itself is done there, where there is no chart and no film.
    with pytest.raises(MoireIdError, match=r"sheet-photo|badge-film-1"):
        step.do(folder, quiet, readers)
    stealing = HostileOrder("steal", str(tmp_path / "key.pem"))
    for module in (film_orders, badge_steps):
        monkeypatch.setattr(module, "partial", lambda *_, **__: stealing)
    with pytest.raises(MediaError, match="Permission denied"):
        step.do(folder, quiet, readers)
    own = {"sheet-photo.jpg"} if step is SHEET else {"badge-film-1.mp4", "badge-film-2.mp4"}
    assert [{film.name for film in films} for films in asked] == [own, own]
