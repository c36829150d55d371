"""What of a JSON report its schema does not allow."""

from __future__ import annotations

import json
from typing import Any

import jsonschema

from moireid.json_schema import report_schema

SCHEMA = json.loads(report_schema())


def named_only(schema: Any) -> Any:
    """The schema with no room for keys that it does not name."""
    if isinstance(schema, list):
        return [named_only(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    closed = {key: value if key in ("if", "then") else named_only(value) for key, value in schema.items()}
    has_type = "object" in (schema.get("type") if isinstance(schema.get("type"), list) else [schema.get("type")])
    return {"additionalProperties": False, **closed} if has_type else closed


def faults(document: dict[str, Any], schema: dict[str, Any] = SCHEMA) -> list[str]:
    # Through text, as a reader has it: a NaN or a tuple must not pass for what it is in Python.
    seen = json.loads(json.dumps(document, allow_nan=False))
    return [error.message for error in jsonschema.Draft202012Validator(schema).iter_errors(seen)]
