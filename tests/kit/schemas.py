"""The JSON Schemas that are shipped, made of the models: `make schemas` writes them.

Convention: a schema has one object within another where the file has, and no references, so that people can read it.  A
key that may be missing is never written as null, so the schema does not allow null there, though a reader takes it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec

import moireid
from moireid.badge import BadgeFile
from moireid.fiducials import CodedFrame, FiducialKind, Markers
from moireid.models import resolved

FOLDER = Path(moireid.__file__).parent / "schema"
DRAFT = "https://json-schema.org/draft/2020-12/schema"


def badge_schema() -> dict[str, Any]:
    """The schema of badge.json."""
    schema = _of(BadgeFile)
    schema["properties"]["markers"] |= _markers()
    return {"$schema": DRAFT, "title": "moireid badge, format 1"} | schema


SCHEMAS = {"badge": badge_schema}


def text_of(name: str) -> str:
    """The text of the schema file of that name."""
    return json.dumps(SCHEMAS[name](), indent=1, ensure_ascii=False) + "\n"


def file_of(name: str) -> Path:
    return FOLDER / f"{name}.schema.json"


def _of(model: type) -> dict[str, Any]:
    """The schema of a model, with what it refers to in its place."""
    schema = msgspec.json.schema(model)
    plain: dict[str, Any] = _inlined(schema, schema["$defs"])
    del plain["$defs"]
    return plain


def _inlined(rule: Any, within: dict[str, Any]) -> Any:
    if isinstance(rule, list):
        return [_inlined(one, within) for one in rule]
    if not isinstance(rule, dict):
        return rule
    rule = resolved(rule, within)
    if "title" in rule and "properties" in rule:
        del rule["title"]
    found = {key: _inlined(value, within) for key, value in rule.items()}
    if isinstance(found.get("description"), str):
        found["description"] = " ".join(found["description"].split("\n\n")[0].split())
    if len(places := found.get("prefixItems", [])) > 1 and all(one == places[0] for one in places):
        found["items"] = found.pop("prefixItems")[0]
    return _without_null(found) if "anyOf" in found else found


def _without_null(rule: dict[str, Any]) -> dict[str, Any]:
    """A rule of several shapes without null where it means a missing key, and as one shape where one is left."""
    shapes = [one for one in rule.pop("anyOf") if one != {"type": "null"}]
    missing = "default" in rule and rule.pop("default") is None
    if len(shapes) > 1:
        return {"anyOf": shapes} | rule
    return shapes[0] | rule | ({} if missing else {"type": [shapes[0]["type"], "null"]})


def _markers() -> dict[str, Any]:
    """Of the two fiducials, the one that `kind` says."""
    kind, squares, frame = _of(FiducialKind), _of(Markers), _of(CodedFrame)
    for words, one in (("of squares: ", squares), ("of a frame: ", frame)):
        for field in one["properties"].values():
            field["description"] = words + field["description"]
    return {
        "properties": kind["properties"] | squares["properties"] | frame["properties"],
        "if": {"required": ["kind"], "properties": {"kind": {"const": "frame"}}},
        "then": {"required": frame["required"]},
        "else": {"required": squares["required"]},
    }


if __name__ == "__main__":
    for each in SCHEMAS:
        file_of(each).write_text(text_of(each), encoding="utf-8")
