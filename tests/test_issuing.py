"""From an order to a plan, and which mount a format gets.  Next to each test: the wrong implementation it catches."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from moireid.badge import Badge, load_badge
from moireid.designer import Request, design_badge, random_payload
from moireid.designer.formats import in_format
from moireid.errors import FabricationError, RegistryError
from moireid.fabrication.mount_parts import MountSolids
from moireid.fabrication.package import print_badge
from moireid.fabrication.printed.mount import MountPlan, MountReport
from moireid.fabrication.process_figures import MountFigures, mount_figures
from moireid.issuing import IssueOrder, Wear, plan_badge
from moireid.registry import open_registry

PLAIN = Wear(None, None, None, None, None, None, ("Reporter",), None, None, None)


def order(mount: str | None = "none", payload: bytes | None = None) -> IssueOrder:
    return IssueOrder(PLAIN.fit(Request("Ada Lovelace")), PLAIN, mount, MountFigures(), payload)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often the badge is designed and its mount is planned."""
    found: Counter[str] = Counter()

    def counted(where: str, name: str) -> None:
        module = __import__(where, fromlist=[name])
        own: Callable[..., Any] = getattr(module, name)

        def call(*args: Any, **more: Any) -> Any:
            found[name] += 1
            return own(*args, **more)

        monkeypatch.setattr(module, name, call)

    counted("moireid.designer.drawn", "design_badge")
    # It is imported by the functions that call it.
    counted("moireid.fabrication.printed.mount", "plan_mount")
    return found


NO_SOLIDS = MountSolids((), {"printed": (), "acrylic": ()}, {})


def test_a_badge_is_designed_once_and_its_mount_planned_once(
    tmp_path: Path, calls: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a second draw after the checks, so that another identity is printed; plans made anew for each file."""

    # The solids, which take seconds, are those of the tests of mounts.
    def write_mount(badge: Badge, folder: Path, *, plan: MountPlan, **_: object) -> MountReport:
        files = [folder / name for name in ("mount.stl", "mount.3mf")]
        for path in files:
            path.touch()
        assert plan is not None
        return MountReport(*files, 2.4e4, (150.0, 170.0, 8.0), 30.0, 0, (), {})

    plan = plan_badge(order("lanyard"), None)
    monkeypatch.setattr("moireid.fabrication.printed.mount.write_mount", write_mount)
    monkeypatch.setattr("moireid.fabrication.package.shape_parts", lambda *_: NO_SOLIDS)
    monkeypatch.setattr("moireid.fabrication.assembly.guide._views", lambda *_: [])
    for name in ("write_assembly_step", "write_glb"):
        monkeypatch.setattr(f"moireid.fabrication.assembly_files.{name}", lambda *given: given[2].touch())
    printed = print_badge(plan.badge, tmp_path / "ada", parts=plan.parts, look=plan.look)
    assert calls == {"design_badge": 1, "plan_mount": 1}
    assert load_badge(printed.files["badge.json"]) == plan.badge
    assert list(printed.files) == plan.files and printed.mount_mass_g


def test_an_identity_of_another_badge_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a plan for an identity that somebody else has, which fails after all files are made."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    payload = random_payload(8)
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as registry:
        first = plan_badge(order(payload=payload), registry.by_id)
        assert first.holder is None
        registry.enroll(first.badge)
        again = plan_badge(order(payload=payload), registry.by_id)
        assert again.holder is not None and again.holder.name == "Ada Lovelace"
        other = IssueOrder(PLAIN.fit(Request("Grace Hopper")), PLAIN, "none", MountFigures(), payload)
        with pytest.raises(RegistryError, match="is held by 'Ada Lovelace' already"):
            plan_badge(other, registry.by_id)


CARD = Wear("cr80", "portrait", None, None, None, None, (), None, None, None)


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(in_format(Request("Ada Lovelace"), "cr80", orientation="portrait"), bytes(8))


def test_a_format_gets_a_holder_where_the_mount_asked_for_does_not_fit(badge: Badge) -> None:
    """Catches: a refusal or a note alone where a holder can be made; a holder in place of a mount that fits."""
    parts, note = CARD.parts(badge, "stand", MountFigures())
    assert parts.printed == "holder"
    assert note == "no printed mount of the kind stand fits cr80; a snap-in holder is made instead"
    for wish in (None, "lanyard", "holder", "none"):
        parts, note = CARD.parts(badge, wish, MountFigures())
        assert (parts.printed, note) == (wish or "lanyard", None)


def test_a_figure_that_was_given_is_an_order(badge: Badge) -> None:
    """Catches: another mount than the one whose figure was set; a board of its own that is given a holder unasked."""
    with pytest.raises(FabricationError, match="front wall"):
        CARD.parts(badge, "stand", mount_figures(["stand_deg=20"]))
    # A board of its own has the acrylic stack, which can be made.
    parts, note = replace(CARD, format_name=None).parts(badge, "stand", MountFigures())
    assert (parts.printed, note) == ("none", None) and parts.acrylic and "front wall" in parts.left_out["printed"]
