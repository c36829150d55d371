"""The capture record: what it holds, and what it leaves out.  Next to each test: the fault that it catches."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import cv2
import jsonschema
import msgspec
import numpy as np
import pytest

from kit.schemas import SCHEMAS
from moireid.badge import Badge
from moireid.bringup.badge_steps import FILMS, collect_record
from moireid.bringup.build_folder import Figure, open_folder, unknown
from moireid.bringup.capture_record import (
    MOST_BYTES,
    CameraRecord,
    CropRecord,
    FilmRecord,
    FindingRecord,
    SignalRecord,
    capture_record,
    read_record,
    write_record,
)
from moireid.bringup.field_crops import FieldCrop, rectified
from moireid.designer import Request, design_badge
from moireid.errors import SpecError
from moireid.profiles import LensProfile, PrinterProfile

RECT = (37.0, 104.0, 173.0, 193.0)


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Request("Ada Lovelace"), bytes(range(16)))


def a_film() -> FilmRecord:
    png = FieldCrop(0, 0.1, RECT, 1.0, np.full((89, 136), 90, np.uint8)).png_base64()
    signal = SignalRecord("sideways", RECT, 0.52, [0.1, None], [0.1, 0.2], [0.01, None], 0.02, [0, 0])
    camera = CameraRecord(1400.0, 20.0, False, (1.0, 2.0), 1.0, -0.01, 0.01, 0.012)
    return FilmRecord(
        1920,
        1080,
        2,
        "accept",
        [FindingRecord("gain", "pass", 1.0, 0.1, "ratio")],
        1.0,
        0.01,
        camera,
        [0.0, 0.1],
        [(1.0, 2.0, -1000.0)] * 2,
        [0.0, 0.1],
        [0.0, 0.0],
        [signal],
        [CropRecord(0.1, 0.05, RECT, 1.0, png)],
        {"gain_ratio": 1.0},
    )


def test_a_record_reads_back_and_keeps_to_its_schema(badge, tmp_path: Path):
    """Catches: fields that the shipped schema does not know, or forbids; a null where a frame is unreadable."""
    lens = LensProfile("mine", badge.lens, 1e-5)
    figures = [Figure("Sheet pitch", 0.508, 1e-5, "mm", "good", "x"), unknown("Flatness", "mm", "x", "y")]
    figures.append(Figure("Radius", None, None, "x focal", "good", "x", within=(0.9, 1.1)))
    record = capture_record(
        [a_film()], badge, figures=figures, sheet=lens, printer=PrinterProfile("mine", 600, 41.0, 4.0)
    )
    write_record(record, tmp_path / "record.json")
    assert read_record(tmp_path / "record.json") == record
    document = json.loads((tmp_path / "record.json").read_text())
    validator = jsonschema.Draft202012Validator(SCHEMAS["capture-record"]())
    assert list(validator.iter_errors(document)) == []
    document["films"][0]["signals"][0]["measured_rad"] = ["far"]
    assert list(validator.iter_errors(document))
    crop = base64.b64decode(document["films"][0]["crops"][0]["png"])
    assert cv2.imdecode(np.frombuffer(crop, np.uint8), cv2.IMREAD_UNCHANGED).shape == (89, 136)


def test_neither_name_nor_identity_is_in_it_unless_asked(badge, tmp_path: Path):
    """Catches: badge.json that goes along, a name in the print data, a path of the builder's machine."""
    for with_badge in (False, True):
        record = capture_record([a_film()], badge, with_badge=with_badge)
        text = msgspec.json.encode(record).decode()
        assert ("Lovelace" in text) == (badge.id in text) == with_badge
        assert (record.badge is not None) == with_badge and "path" not in text.replace("patch", "")


def test_what_is_no_record_is_refused_in_a_sentence(tmp_path: Path):
    """Catches: a badge or a report read as a record; a file of any size read whole; a traceback."""
    path = tmp_path / "odd.json"
    path.write_text('{"format": 1, "kind": "first-badge"}')
    with pytest.raises(SpecError, match="kind must be moireid-capture-record"):
        read_record(path)
    path.write_text('{"format": 2}')
    with pytest.raises(SpecError, match="format 2 is not known"):
        read_record(path)
    with pytest.raises(SpecError, match="cannot be read"):
        read_record(tmp_path / "none.json")
    with path.open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(SpecError, match="larger than 50 MB"):
        read_record(path)
    folder = open_folder(tmp_path / "first", {}, {})
    folder.at(FILMS).write_text('[{"width_px": 0}]')
    with pytest.raises(SpecError, match="is damaged"):
        collect_record(folder, with_badge=False, note="")


def test_a_crop_holds_its_rectangle_alone():
    """Catches: pixels from around the fields, where name and face are; a crop upside down or half a pixel off."""
    picture = np.full((300, 400), 255, np.uint8)
    picture[100:160, 50:250] = 10
    picture[100:130, 50:150] = 60
    page = np.array([[2.0, 0, 10], [0, 2.0, 20], [0, 0, 1]])
    cut = rectified(picture, page, (20.25, 40.25, 119.5, 69.5), 4.0)
    assert cut.shape == (117, 397) and set(np.unique(cut)) <= set(range(10, 61))
    assert cut[0, 0] == 60 and cut[0, -1] == cut[-1, 0] == 10
