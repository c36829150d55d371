"""Documents of untrusted programs compared with a JSON Schema (2020-12).

jsonschema-rs does it: it loads in 40 ms, where jsonschema takes 180, which is more than reading a short film costs.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jsonschema_rs import Draft202012Validator


def schema_fault(document: object, schema: str, *others: str) -> str | None:
    """The first way in which a document breaks its schema, in words; None where it breaks none of its rules.

    Parameters
    ----------
    document : object
        As JSON is read.
    schema, others : str
        The schema as text, and those that it refers to by their ``$id``.
    """
    try:
        wrong = next(iter(compiled(schema, *others).iter_errors(document)), None)
    # So it refuses what nests too deeply, and text that no encoding has.
    except (ValueError, RecursionError) as error:
        return f"it cannot be compared with its schema ({str(error)[:80]})"
    if wrong is None:
        return None
    place = ".".join(map(str, wrong.instance_path)) or "it"
    return f"{place[:80]} breaks the rule {wrong.kind.name!r} of its schema"


@cache
def compiled(schema: str, *others: str) -> Draft202012Validator:
    """The validator of a schema, made once."""
    from jsonschema_rs import Draft202012, Draft202012Validator, Registry

    documents = map(json.loads, others)
    known = Registry([(one["$id"], one) for one in documents], draft=Draft202012)
    return Draft202012Validator(json.loads(schema), registry=known)


def report_schema() -> str:
    """JSON Schema (2020-12) of `verify --json`, as text."""
    return resources.files("moireid").joinpath("schema/report.schema.json").read_text(encoding="utf-8")
