"""Files into models: msgspec checks types and ranges, and the first fault is said in one sentence.

A model is a frozen dataclass, or a `msgspec.Struct` where a file has another shape than the program's own object.  What
a field allows and means is written next to it (`typing.Annotated`, `msgspec.Meta`); the JSON Schemas that are shipped
are made of the same.

Convention: a place in a file is its keys and numbers, such as `gratings.0.cells.3.duty`.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any, TypeVar

import msgspec

from moireid.errors import SpecError

Model = TypeVar("Model")
#: JSON's numbers are read by every program alike up to so many digits, and up to so large as whole ones.
MOST_DIGITS, MOST_WHOLE = 18, 2**53
#: Letters of a value that a message shows.
SHOWN = 60
#: One step of the path at which msgspec found a fault, such as `.cells` or `[3]`.
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")


def parse_json(text: str, source: str, advice: str) -> Any:
    """The content of a JSON text; `source` names the file, and `advice` is the next step.

    Convention: 1 and 1.0 are the same whole number, so that both give the same model.
    Raises: SpecError where it is no JSON, or holds a number that is not finite or has too many digits.
    """
    try:
        return json.loads(text, parse_constant=_no_constant, parse_float=_finite, parse_int=_small)
    except (ValueError, RecursionError) as error:
        raise SpecError(f"{source} is not JSON ({error}); {advice}") from error


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is no number in JSON")


def _finite(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise ValueError(f"{digits[:40]} is no finite number")
    return int(value) if value.is_integer() and abs(value) < MOST_WHOLE else value


def _small(digits: str) -> int:
    if len(digits) > MOST_DIGITS:
        raise ValueError(f"{digits[:MOST_DIGITS]}… has too many digits for a number here")
    return int(digits)


def check_format(document: object, known: int | tuple[int, ...], source: str) -> None:
    """Refuse a file of another format before anything else of it is read.  Raises: SpecError."""
    formats = known if isinstance(known, tuple) else (known,)
    if isinstance(document, dict) and document.get("format") not in formats:
        found, read = _shown(document.get("format")), " and ".join(map(str, formats))
        raise SpecError(f"{source}: format: format {found} is not known to this version; it reads format {read}")


def read_model(
    document: object, model: type[Model], source: str, advice: str, *, at: str = "", first: int = 0
) -> Model:
    """The model of a file's content.

    Parameters
    ----------
    document : object
        Plain lists and dictionaries, as JSON and TOML are read.
    model : type
        A dataclass or a `msgspec.Struct`.
    source : str
        Names the file in messages.
    advice : str
        The next step, as messages end with it.
    at : str
        Where in the file the content is, if it is not all of it.
    first : int
        Number of a list's first entry, as messages count.

    Raises
    ------
    SpecError
        The place of the first fault, what it holds, and what is allowed there.
    """
    try:
        return msgspec.convert(document, model)
    except UnicodeEncodeError as error:
        raise SpecError(f"{source} holds text that is not Unicode (half of a pair of code units); {advice}") from error
    except msgspec.ValidationError as error:
        # What a file says may be quoted before the place, so the last one counts.
        text, _, path = str(error).rpartition(" - at `$") if " - at `$" in str(error) else (str(error), "", "")
        keys: list[str | int] = [int(number) if number else name for name, number in _STEP.findall(path)]
        named = [str(key + first) if isinstance(key, int) else key for key in keys]
        where = ".".join([at, *named] if at else named) or "the file"
        try:
            fault = _fault(text, keys, document, model)
        except (KeyError, IndexError, TypeError, StopIteration):
            # The file's own text looks like a place.
            where, fault = at or "the file", f"cannot be read: {_shown(str(error))}"
        raise SpecError(f"{source}: {where} {fault}; {advice}") from error


def _fault(text: str, keys: list[str | int], document: Any, model: type) -> str:
    """What is wrong at a place, by msgspec's words for it and by the model's rule."""
    rule, within = _rule_at(model, keys)
    if found := re.fullmatch(r"Object missing required field `(.+)`", text):
        return f"lacks {found[1]}"
    if found := re.fullmatch(r"Object contains unknown field `(.+)`", text, re.DOTALL):
        shapes = (resolved(one, within) for one in rule.get("anyOf", [rule]))
        keys_of: Mapping[str, Any] = next((shape["properties"] for shape in shapes if "properties" in shape), {})
        return f"has the unknown key {_shown(found[1])}; allowed are {', '.join(sorted(keys_of))}"
    if not text.startswith(("Expected", "Invalid", "Number", "Integer")):
        return text
    value = document
    for key in keys:
        value = value[key]
    return f"must be {allowed(rule, within)}, got {_shown(value)}"


def _shown(value: object) -> str:
    """A value as JSON writes it, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    text = text.encode("utf-8", "replace").decode()
    return text if len(text) <= SHOWN else text[:SHOWN] + " …"


def _rule_at(model: type, keys: list[str | int]) -> tuple[dict[str, Any], Mapping[str, Any]]:
    """The rule of a JSON Schema at a place of a model, and the rules that it refers to by name."""
    rule = msgspec.json.schema(model)
    within: Mapping[str, Any] = rule.get("$defs", {})
    for key in keys:
        # Of several shapes, only a list or an object has places within.
        shapes = (resolved(one, within) for one in resolved(rule, within).get("anyOf", [rule]))
        shape = next(one for one in shapes if {"properties", "items", "prefixItems"} & set(one))
        if isinstance(key, str):
            rule = shape["properties"][key]
        else:
            rule = shape["prefixItems"][key] if "prefixItems" in shape else shape["items"]
    return resolved(rule, within), within


def resolved(rule: dict[str, Any], within: Mapping[str, Any]) -> dict[str, Any]:
    """A rule of a JSON Schema with what it refers to; its own words count first."""
    if "$ref" not in rule:
        return rule
    known: dict[str, Any] = within[rule["$ref"].rsplit("/", 1)[1]]
    return known | {key: value for key, value in rule.items() if key != "$ref"}


def allowed(rule: dict[str, Any], within: Mapping[str, Any]) -> str:
    """What a rule of a JSON Schema allows, in words, such as "a number from 4 to 72"."""
    rule = resolved(rule, within)
    if "anyOf" in rule:
        return " or ".join(allowed(one, within) for one in rule["anyOf"])
    if "enum" in rule:
        choices = ", ".join(map(str, rule["enum"]))
        return choices if len(rule["enum"]) == 1 else f"one of {choices}"
    kind: str = rule.get("type", "anything")
    if kind in ("number", "integer"):
        return ("a number" if kind == "number" else "a whole number") + _range(rule)
    if kind == "array":
        least, most = rule.get("minItems", 0), rule.get("maxItems", math.inf)
        count = f"{least}" if least == most else f"{least} to {most}" if most < math.inf else f"{least} or more"
        inner = rule["prefixItems"][0] if rule.get("prefixItems") else rule.get("items")
        return f"a list of {count} entries" + (f", each {allowed(inner, within)}" if inner else "")
    if kind == "string":
        return "text" + (f" like {rule['pattern']}" if "pattern" in rule else "") + _length(rule)
    return {"boolean": "true or false", "object": "a table of keys and values"}.get(kind, kind)


def _range(rule: dict[str, Any]) -> str:
    """The bounds of a number in words, empty where it has none."""
    least, above = rule.get("minimum"), rule.get("exclusiveMinimum")
    most, below = rule.get("maximum"), rule.get("exclusiveMaximum")
    if least is not None and most is not None:
        return f" from {least:g} to {most:g}"
    low = f"{least:g} or more" if least is not None else f"above {above:g}" if above is not None else ""
    high = f"at most {most:g}" if most is not None else f"below {below:g}" if below is not None else ""
    return "".join(f" {word}" for word in (low, "and" if low and high else "", high) if word)


def _length(rule: dict[str, Any]) -> str:
    return f" of at most {rule['maxLength']} letters" if "maxLength" in rule else ""
