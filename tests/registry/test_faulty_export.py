"""Exports that are cut, changed or none.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import json

import numpy as np
import pytest

from kit.registries import spelled, state_of
from moireid.errors import RegistryError
from moireid.registry import engine, import_registry, merge, open_registry


def test_file_cut_anywhere_changes_nothing(three_exported, url, tmp_path):
    """Catches: taking what could be read before the end; a registry made for a file that is none."""
    content, exported = three_exported, tmp_path / "cut.json"
    for end in np.linspace(0, len(content.rstrip()) - 1, 40).astype(int):
        exported.write_bytes(content[:end])
        with pytest.raises(RegistryError, match="cut, damaged or none"):
            import_registry(exported, url)
    with pytest.raises(RegistryError, match=r"no registry|empty"):
        open_registry(url, create=False)


EDITS = {
    "name": lambda d: d["records"][0].update(name_nfc="Eve"),
    "badge": lambda d: d["records"][0]["badge"].update(name="Eve"),
    "unrevoked": lambda d: [item.update(revoked_at=None, revoked_reason=None) for item in d["records"]],
    "figures": lambda d: [item.update(as_built={"tilt_rad": 0}) for item in d["records"]],
    "record dropped": lambda d: d["records"].pop(),
    "record twice": lambda d: d["records"].append(d["records"][0]),
    "key too many": lambda d: d["records"][0].update(more=1),
    "surrogate": lambda d: d["records"][0].update(name_nfc="\ud800"),
    "entry dropped": lambda d: d["log"].pop(),
    "entries swapped": lambda d: d["log"].reverse(),
    "entry too far": lambda d: d["log"][0].update(seq=2**70),
    "log and head cut": lambda d: (d["log"].pop(), d.update(head_seq=5, head_hash=d["log"][-1]["hash"])),
    "no head": lambda d: d.pop("head_hash"),
    "another key": lambda d: d.update(public_key="00" * 32),
    "deep": lambda d: d["records"][0].update(badge=json.loads('{"a":' * 900 + "1" + "}" * 900)),
    "version": lambda d: d.update(version=99),
    "format": lambda d: d.update(format="x"),
}


@pytest.mark.slow
@pytest.mark.parametrize("edit", EDITS)
def test_edited_file_changes_nothing(three_exported, url, tmp_path, edit):
    """Catches: a part of the file that is believed; half of it imported; an error of the parser or the driver."""
    open_registry(url, create=True).close()
    before = state_of(url)
    document = json.loads(three_exported)
    EDITS[edit](document)
    (tmp_path / "edited.json").write_text(spelled(document))
    with pytest.raises(RegistryError, match=r"nothing was imported") as caught:
        import_registry(tmp_path / "edited.json", url)
    assert "\n" not in str(caught.value)
    assert state_of(url) == before


def test_database_that_fails_halfway_keeps_the_old_state(full, exported, target, monkeypatch):
    """Catches: an import in several transactions."""
    with open_registry(target, create=True) as copy:
        before = state_of(target)
        monkeypatch.setattr(engine, "CHUNK", 1)
        copied = merge._copy

        def failing(there, here):
            copied(there, here)
            raise RegistryError("the disk is full")

        monkeypatch.setattr(merge, "_copy", failing)
        with pytest.raises(RegistryError, match="disk is full"):
            copy.import_json(exported)
        assert state_of(target) == before
        monkeypatch.undo()
