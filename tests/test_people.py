"""A list of people and the badge of each.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

from pathlib import Path

from moireid.artwork.columns import files_below
from moireid.designer import Order
from moireid.names import line_of
from moireid.people import PersonRow, plan_people

ALL = Order("Everybody", mount="none")


def planned(text: str, order: Order = ALL) -> tuple[list[PersonRow], list[str]]:
    return plan_people(text.encode(), order, files_below(Path()))


def test_namesakes_are_noted() -> None:
    """Catches: a line that is read and lost; no warning about people whom claims cannot distinguish by name."""
    rows, notes = planned("name,line1,line2\nAna Silva,Reporter,News\nAna Silva,,Editor\nBob,,\n")
    assert [line_of(one.badge.print) for one in rows if one.badge] == ["Reporter", "Editor", None]
    assert len(notes) == 1 and notes[0].startswith("rows 2 and 3 bear the name 'Ana Silva', so claims")


def test_a_list_draws_an_identity_for_each_person() -> None:
    """Catches: two people of one name with one badge, a payload of the list that is drawn over or given twice."""
    rows, _ = planned("name,payload\nAda,\nAda,\nBob,0011223344556677\nCy,0011223344556677\n")
    ids = [one.badge.id for one in rows if one.badge]
    assert len(set(ids)) == 3 and ids[2] == "0011223344556677"
    assert rows[3].fault is not None and "row 4 has its identity" in rows[3].fault
