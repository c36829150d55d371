"""The capture record: what it holds, and what it leaves out.  Next to each test: the fault that it catches."""

from __future__ import annotations

import base64
import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from kit.places import FILMS
from moireid.badge import load_badge
from moireid.bringup import badge_steps
from moireid.bringup.badge_steps import collect_record
from moireid.bringup.build_folder import BADGE_JSON, open_folder
from moireid.bringup.capture_record import film_record, write_record
from moireid.bringup.chart_steps import PRINTER, SHEET
from moireid.bringup.field_crops import field_crops, rectified
from moireid.profiles import LensProfile, PrinterProfile, save_profile
from moireid.verifier import Question, verify


def test_a_record_holds_figures_signals_and_fields_and_no_name_unless_asked(tmp_path: Path):
    """Catches: badge.json that goes along, a name in the print data, a path of the builder's machine; signals of
    another film; crops that no program opens."""
    badge = replace(load_badge(FILMS / "badge.json"), name="Ada Lovelace", id="0123456789abcdef")
    report = verify(FILMS / "genuine_1.0m.mp4", Question(badge))
    folder = open_folder(tmp_path / "first")
    folder.at("badge").mkdir(parents=True)
    folder.at(BADGE_JSON).write_text(badge.to_json())
    save_profile(LensProfile("mine", badge.lens, 1e-5), folder.at(SHEET))
    save_profile(PrinterProfile("mine", 600, 41.0, 4.0), folder.at(PRINTER))
    folder.at(badge_steps.FILMS).write_text(json.dumps([film_record(report, None, field_crops(report))]))
    for with_badge in (False, True):
        write_record(collect_record(folder, with_badge=with_badge, note="from a shop"), tmp_path / "record.json")
        text = (tmp_path / "record.json").read_text()
        assert (badge.name in text) == (badge.id in text) == with_badge and str(FILMS) not in text
    document = json.loads(text)
    (film,) = document["films"]
    rows = list(csv.DictReader(io.StringIO(film["signals_csv"])))
    assert len(rows) == film["frames"]["tracked"] and film["invariant"]["gain_ratio"] == pytest.approx(1, abs=0.05)
    assert {"motion", "gain"} <= {one["code"] for one in film["findings"]} and "text" not in film["findings"][0]
    for crop in film["crops"]:
        x0, y0, x1, y1 = crop["rect_mm"]
        shown = cv2.imdecode(np.frombuffer(base64.b64decode(crop["png"]), np.uint8), cv2.IMREAD_UNCHANGED)
        assert shown.shape == (round((y1 - y0) * crop["px_per_mm"]), round((x1 - x0) * crop["px_per_mm"]))


def test_a_crop_holds_its_rectangle_alone():
    """Catches: pixels from around the fields, where name and face are; a crop upside down or half a pixel off."""
    picture = np.full((300, 400), 255, np.uint8)
    picture[100:160, 50:250] = 10
    picture[100:130, 50:150] = 60
    page = np.array([[2.0, 0, 10], [0, 2.0, 20], [0, 0, 1]])
    cut = rectified(picture, page, (20.25, 40.25, 119.5, 69.5), 4.0)
    assert cut.shape == (117, 397) and set(np.unique(cut)) <= set(range(10, 61))
    assert cut[0, 0] == 60 and cut[0, -1] == cut[-1, 0] == 10
