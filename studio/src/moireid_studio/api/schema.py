"""Descriptions of forms and reports for /openapi.json, which the framework cannot derive from our functions."""

from __future__ import annotations

import json
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute

from moireid.json_schema import report_schema
from moireid_studio.auth.guard import rules_of
from moireid_studio.checks import FilmFields
from moireid_studio.uploads import ALLOWED

REPORT = {"$ref": "#/components/schemas/Report"}
IDENTIFICATION = {
    "type": "object",
    "description": "The report of the layout that says most, where anyone is enrolled; and whose badge it is.",
    "required": ["finding", "found_id", "found_name", "reasons"],
    "properties": {
        "finding": {"enum": ["found", "nobody", "inconclusive"]},
        "found_id": {"type": ["string", "null"]},
        "found_name": {"type": ["string", "null"]},
        "reasons": {"type": "array", "items": {"$ref": "#/components/schemas/ReportReason"}},
    },
}


def form(*names: str) -> dict[str, Any]:
    """The request body of a route that takes a film and these fields."""
    known = FilmFields.model_json_schema()["properties"]
    # A form knows no null: what may be absent is a value of its own kind or absent.
    fields = {name: {**known[name], **known[name].get("anyOf", [{}])[0]} for name in names}
    kept = ("type", "enum", "minimum", "maximum", "description")
    properties = {name: {key: value for key, value in one.items() if key in kept} for name, one in fields.items()}
    properties["video"] = {"type": "string", "format": "binary", "description": f"the film: {ALLOWED}"}
    schema = {"type": "object", "required": ["video"], "properties": properties, "additionalProperties": False}
    return {"requestBody": {"required": True, "content": {"multipart/form-data": {"schema": schema}}}}


def picture_form() -> dict[str, Any]:
    """The request body of the route that takes a logo or a portrait."""
    picture = {"type": "string", "format": "binary", "description": "SVG, PNG or JPEG"}
    schema = {"type": "object", "required": ["picture"], "properties": {"picture": picture}}
    return {"requestBody": {"required": True, "content": {"multipart/form-data": {"schema": schema}}}}


def answers(schema: dict[str, Any], description: str) -> dict[int | str, dict[str, Any]]:
    """The `responses` of a route whose answer has this schema."""
    return {200: {"description": description, "content": {"application/json": {"schema": schema}}}}


def describe(app: FastAPI) -> None:
    """Add the report's own schema to what the framework writes into /openapi.json."""
    made: dict[str, Any] = {}

    def openapi() -> dict[str, Any]:
        if not made:
            made.update(get_openapi(title=app.title, version=app.version, routes=app.routes, description=__doc__))
            made["info"]["description"] = "The same library as the command line; errors are a code and a sentence."
            made["components"]["schemas"].update(_report_parts())
            made["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
            for route in app.routes:
                if isinstance(route, APIRoute) and route.include_in_schema and any(r.roles for r in rules_of(route)):
                    for method in route.methods or ():
                        made["paths"][route.path_format][method.lower()]["security"] = [{"token": []}]
        return made

    app.openapi = openapi  # type: ignore[method-assign]


def _report_parts() -> dict[str, Any]:
    """The report's schema and its definitions, separately: inside another document its references must change."""
    document = json.loads(report_schema())
    names = {name: "Report" + "".join(word.title() for word in name.split("_")) for name in document["$defs"]}
    text = json.dumps(document)
    for name, ours in names.items():
        text = text.replace(f'"#/$defs/{name}"', f'"#/components/schemas/{ours}"')
    document = json.loads(text)
    parts = {names[name]: part for name, part in document.pop("$defs").items()}
    for word in ("$schema", "$id"):
        document.pop(word)
    return {"Report": document} | parts
