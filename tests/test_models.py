"""Files read into models: what a model refuses is named with its place, and the shipped schemas say the same.

Each test states which wrong implementation it would catch.
"""

from __future__ import annotations

import copy
import json
import math
from dataclasses import MISSING, asdict, fields
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kit.places import FILMS
from kit.schemas import SCHEMAS, file_of, text_of
from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.badge import badge_from_json
from moireid.errors import SpecError
from moireid.models import parse_json

BUILT = AsBuilt("7097c67b0fafc59b", -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.01)
OPTIONAL = "measured_scale", "third_harmonic", "place_maps", "place_map_sd", "model"
REQUIRED = {"format"} | {field.name for field in fields(AsBuilt) if field.default is MISSING}
BADGE = json.loads((FILMS / "badge.json").read_text(encoding="utf-8"))
BADGE_SCHEMA = jsonschema.Draft202012Validator(SCHEMAS["badge"]())
#: The same examples in each run, however busy the machine is.
STEADY = settings(derandomize=True, deadline=None, max_examples=80)
#: With halves of surrogate pairs, which JSON can write, and words that msgspec's messages hold too.
TEXTS = st.text(st.characters(), max_size=9) | st.sampled_from(["\ud800", "a - at `$.b", "a\nb", "x - at `$.zzz"])
#: Any JSON value, small.
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=5,
)


@st.composite
def spoilt(draw: st.DrawFn, document: Any) -> Any:
    """A document in which one value at any depth is another one, or gone."""
    changed = inner = copy.deepcopy(document)
    while True:
        key = draw(st.sampled_from(sorted(inner) if isinstance(inner, dict) else range(min(len(inner), 3))))
        if not (isinstance(inner[key], (dict, list)) and inner[key] and draw(st.booleans())):
            break
        inner = inner[key]
    if draw(st.booleans()):
        inner[key] = draw(VALUES)
    else:
        del inner[key]
    return changed


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_shipped_schema_is_that_of_its_model(name: str) -> None:
    """Catches: a field whose limits or meaning changed in the model alone; a schema edited by hand."""
    assert file_of(name).read_text(encoding="utf-8") == text_of(name), "run `make schemas`"
    jsonschema.Draft202012Validator.check_schema(json.loads(text_of(name)))


@STEADY
@given(st.text(max_size=30) | VALUES.map(json.dumps) | spoilt(BADGE).map(json.dumps))
def test_any_badge_file_is_read_or_refused_in_one_sentence(text: str) -> None:
    """Catches: another exception than SpecError; a badge that is read and cannot be written or read again."""
    try:
        badge = badge_from_json(text, source="b.json")
    except SpecError as error:
        assert "\n" not in str(error) and len(str(error)) < 700
        return
    assert badge_from_json(badge.to_json()) == badge and badge.to_json() == badge_from_json(badge.to_json()).to_json()


@STEADY
@given(spoilt(BADGE))
def test_what_the_schema_refuses_the_model_refuses(document: Any) -> None:
    """Catches: a limit of the schema that the reader does not hold; null for a missing key is the one exception."""
    faults = [fault for fault in BADGE_SCHEMA.iter_errors(document) if fault.instance is not None]
    if faults:
        with pytest.raises(SpecError):
            badge_from_json(json.dumps(document))


@STEADY
@given(spoilt(json.loads(BUILT.to_json())) | VALUES)
def test_any_as_built_figures_are_read_or_refused(document: Any) -> None:
    """Catches: figures that are texts, a beat of zero, another format, a key that is absent."""
    try:
        found = as_built_from_json(json.dumps(document))
    except SpecError as error:
        assert str(error).startswith("as-built figures")
        return
    figures = [value for key, value in asdict(found).items() if key not in ("badge_id", "witnessed", *OPTIONAL)]
    assert all(type(value) in (int, float) and math.isfinite(value) for value in figures)
    assert type(found.witnessed) is bool
    assert found.beat_frequency_per_mm != 0 and document["format"] == 1 and set(document) >= REQUIRED
    assert as_built_from_json(found.to_json()) == found


@STEADY
@given(st.integers(), st.floats(allow_nan=True))
def test_numbers_are_read_alike_or_refused(whole: int, number: float) -> None:
    """Catches: a NaN that passes every comparison; 2 and 2.0 as two things; digits that another program rounds."""
    for value in (whole, number):
        text = json.dumps({"n": [value]})
        try:
            read = parse_json(text, "a file", "correct it")["n"][0]
        except SpecError:
            assert value != value or abs(value) == float("inf") or len(str(value)) > 18
            continue
        assert read == value and (isinstance(read, int) or not value.is_integer() or abs(value) >= 2**53)


@pytest.mark.parametrize("path", sorted(FILMS.glob("badge*.json")), ids=lambda path: path.stem)
def test_badge_files_of_earlier_versions_are_written_byte_for_byte(path: Any) -> None:
    """Catches: figures rounded, keys in another order or nulls added, which would change each digest of a badge."""
    text = path.read_text(encoding="utf-8")
    badge = badge_from_json(text)
    if badge.id is not None:
        assert badge.to_json() == text
