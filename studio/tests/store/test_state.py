"""Tokens and links, in files and on PostgreSQL.  The test names the wrong implementation it catches."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import Column, Integer, MetaData, Table

from moireid_studio.auth.tokens import Tokens
from moireid_studio.links import FILE, Links, links
from moireid_studio.store.database import database_of


def test_what_one_studio_writes_another_one_reads(tmp_path: Path, state: str | None) -> None:
    """Catches: a database that only one studio sees; a link that two of them use; a token that one of them revokes and
    another still takes."""
    here, there = (Tokens(tmp_path, state) for _ in range(2))
    secret, token = here.create("verifier")
    assert there.find(secret) == token and there.of_session(here.begin_session(secret) or "") == token
    both = [Links(tmp_path, state) for _ in range(2)]
    made = both[0].make(token.id, "Example News", "0" * 16, ids=False, wants_pictures=True)
    assert made is not None and both[1].by_secret(made[0]) == made[1]
    assert [one.use(made[1], agreed=True) for one in both] == [True, False]
    both[1].note_end(made[1], {"verdict": "accept"}, [b"jpeg"])
    assert both[0].pictures(made[1]) == [b"jpeg"] and [one.state for one in both[0].of_asker(token.id, 9)] == ["done"]
    there.revoke(token.id)
    assert here.find(secret) is None
    for one in (here, there, *both):
        one.close()


def test_links_are_made_in_a_table_of_an_earlier_version(tmp_path: Path, state: str | None) -> None:
    """Catches: a column of another type, so that a studio on PostgreSQL makes no link in the table that it has."""
    database = database_of(tmp_path, FILE, state)
    with database.writing() as connection:
        earlier = MetaData()
        numbers = {name: Integer() for name in ("ids", "wants_pictures", "agreed")}
        columns = [Column(one.name, numbers.get(one.name, one.type), primary_key=one.primary_key) for one in links.c]
        Table(links.name, earlier, *columns)
        earlier.create_all(connection)
    database.close()
    own = Links(tmp_path, state)
    made = own.make("me", "Example News", "0" * 16, ids=True, wants_pictures=False)
    assert made is not None and (made[1].ids, made[1].wants_pictures, made[1].agreed) == (True, False, None)
    assert own.use(made[1], agreed=True) and (own.by_secret(made[0]) or made[1]).agreed is True
    own.close()
