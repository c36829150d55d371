"""The reader of JSON in little memory.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import io
import json

import pytest

from moireid.registry import export_file as export
from moireid.registry.export_file import walk


@pytest.mark.parametrize("chunk", [1, 2, 3, 7, 4096])
def test_walk_sees_what_json_sees(monkeypatch, chunk):
    """Catches: a value cut at a buffer's edge: a number, an escape, a letter of two bytes."""
    monkeypatch.setattr(export, "CHUNK", chunk)
    document = {
        "a": 12345.678e-3,
        "é\u2028\n": 'x\\"\u00e9\U0001f600',
        "list": [1, 23, [], {}, None, "]", [1, [2]]],
        "none": [],
        "object": {"b": [1, 2]},
        "true": True,
    }
    for indent in (None, 2):
        for ascii_only in (True, False):
            seen: dict[str, list[object]] = {}
            for key, value in walk(io.BytesIO(json.dumps(document, indent=indent, ensure_ascii=ascii_only).encode())):
                seen.setdefault(key, []).append(value)
            expected = {key: value if key == "list" else [value] for key, value in document.items()} | {"none": []}
            assert {"none": []} | seen == expected


@pytest.mark.parametrize(
    "text", ['{"a":[1,]}', '{"a":[1 2]}', '{"a":1,}', '{"a":[,1]}', '{"a":[}', "{,}", '{"a":[Infinity]}', '{"a":-}']
)
def test_walk_refuses_what_json_refuses(text):
    """Catches: a lenient reader, by which two programs read two things out of one file."""
    with pytest.raises(ValueError, match=r"\w"):
        json.loads(text, parse_constant=lambda name: int(name))
    with pytest.raises(ValueError, match=r"\w"):
        list(walk(io.BytesIO(text.encode())))


def test_walk_holds_one_item_at_a_time(monkeypatch):
    """Catches: a reader that keeps what it has passed, and one that reads all before the first item."""
    monkeypatch.setattr(export, "CHUNK", 64)

    class Stream(io.BytesIO):
        read_so_far = 0

        def read(self, size: int | None = -1, /) -> bytes:
            content = super().read(size)
            self.read_so_far += len(content)
            return content

    stream = Stream(json.dumps({"list": ["x" * 50] * 1000}).encode())
    items = walk(stream)
    for _ in range(3):
        next(items)
    assert stream.read_so_far < 1000
    monkeypatch.setattr(export, "VALUE_LIMIT", 500)
    assert len(list(walk(io.BytesIO(json.dumps({"list": ["x" * 50] * 1000}).encode())))) == 1000
    with pytest.raises(ValueError, match="longer than 500 bytes"):
        list(walk(io.BytesIO(json.dumps({"text": "x" * 5000}).encode())))


@pytest.mark.parametrize("opens", ["[", '{"a":'])
def test_walk_refuses_hostile_nesting(opens):
    """Catches: a value so deep that Python's own limit ends the program."""
    deep = '{"a":' + opens * 100_000
    with pytest.raises(ValueError, match="deeper than 200 levels"):
        list(walk(io.BytesIO(deep.encode())))
