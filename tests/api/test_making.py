"""`mo.design` and `mo.print_badge` do what the command does."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from PIL import Image

import moireid as mo
from moireid.cli.main import moireid

PAYLOAD = "0011223344556677"


@pytest.fixture(autouse=True)
def own_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))


@pytest.mark.parametrize("wish", [{}, {"format": "cr80"}, {"format": "a6", "template": "newsroom"}])
def test_the_badge_and_its_page_are_those_of_the_command(wish: dict[str, str], tmp_path: Path) -> None:
    """Catches: a wish that is lost on the way; a look or a format that the printed page does not have."""
    badge = mo.design("Ada Lovelace", payload=PAYLOAD, lines=["Reporter"], **wish)
    printed = mo.print_badge(badge, str(tmp_path / "ours"), mount="none")
    # A badge of a file has lost its template.
    again = mo.load_badge(printed.files["badge.json"])
    mo.print_badge(again, tmp_path / "again", mount="none", template=wish.get("template"))
    assert (tmp_path / "again" / "preview.png").read_bytes() == printed.files["preview.png"].read_bytes()
    options = [word for name, value in wish.items() for word in (f"--{name}", value)]
    line = ["--payload", PAYLOAD, "--line", "Reporter", "--mount", "none", *options]
    done = CliRunner().invoke(moireid, ["print", "Ada Lovelace", "--out", str(tmp_path / "theirs"), *line])
    assert done.exit_code == 0, done.output
    assert printed.files.keys() == {path.name for path in (tmp_path / "theirs").iterdir()}
    assert mo.load_badge(printed.files["badge.json"]) == badge == mo.load_badge(tmp_path / "theirs" / "badge.json")
    for name in ("preview.png", "fringes.webp"):
        assert printed.files[name].read_bytes() == (tmp_path / "theirs" / name).read_bytes(), name


def test_files_and_record_appear_together(tmp_path: Path) -> None:
    """Catches: a badge that is issued though its files could not be written, and the other way round."""
    badge = mo.design("Ada Lovelace", payload=PAYLOAD)
    with mo.Registry(tmp_path / "people.sqlite3", create=True) as registry:
        (tmp_path / "ada").mkdir()
        (tmp_path / "ada" / "badge.pdf").touch()
        with pytest.raises(mo.SpecError, match="exists already"):
            mo.print_badge(badge, tmp_path / "ada", mount="none", registry=registry)
        assert registry.by_id(PAYLOAD) is None
        mo.print_badge(badge, tmp_path / "ada", mount="none", registry=registry, overwrite=True)
        assert registry.find("Ada Lovelace").id == PAYLOAD
        other = mo.design("Grace Hopper", payload=PAYLOAD)
        with pytest.raises(mo.RegistryError):
            mo.print_badge(other, tmp_path / "grace", mount="none", registry=registry)
        assert not (tmp_path / "grace").exists()
        with pytest.raises(mo.RegistryError, match="is held by"):
            mo.design("Grace Hopper", payload=PAYLOAD, registry=registry)
        assert mo.design("Grace Hopper", registry=registry).payload_bits == 64


def test_artwork_is_on_the_page_and_kept_from_harm(tmp_path: Path) -> None:
    """Catches: a logo that is taken and not drawn; one that its own badge's files replace."""
    logo = tmp_path / "preview.png"
    Image.new("RGB", (40, 40), "teal").save(logo)
    badge = mo.design("Ada", format="a6", payload=PAYLOAD)
    with_logo = mo.print_badge(badge, tmp_path / "with", mount="none", logo=str(logo))
    plain = mo.print_badge(badge, tmp_path / "plain", mount="none")
    assert with_logo.files["preview.png"].read_bytes() != plain.files["preview.png"].read_bytes()
    with pytest.raises(mo.SpecError, match="is a file that is read here"):
        mo.print_badge(badge, tmp_path, mount="none", logo=logo, overwrite=True)


def test_a_badge_shows_its_picture() -> None:
    """Catches: a picture of another badge, or of nothing, in a notebook."""
    badge = mo.design("Ada", payload=PAYLOAD)
    picture = badge.show()
    assert picture.size == (876, 960)
    assert badge._repr_png_().startswith(b"\x89PNG")
    assert picture.tobytes() != mo.design("Grace", payload=PAYLOAD).show().tobytes()


def test_sizes_and_distances_are_numbers() -> None:
    """Catches: figures that lose digits as they become the text of an option."""
    badge = mo.design("Ada", size_mm=(150.125, 140), range_m=(0.8, 1.0), payload=bytes(8))
    x0, y0, x1, y1 = badge.outline_mm
    assert (x1 - x0, y1 - y0, badge.range_m, badge.id) == (150.125, 140, (0.8, 1.0), "00" * 8)
    with pytest.raises(mo.SpecError, match=r"size_mm='large' is no pair of numbers"):
        mo.design("Ada", size_mm="large")  # type: ignore[arg-type]
    with pytest.raises(mo.SpecError, match="is not possible"):
        mo.design("Ada", range_m=(2.0, 1.0))
