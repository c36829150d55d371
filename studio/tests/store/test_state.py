"""Tokens and links, in files and on PostgreSQL.  The test names the wrong implementation it catches."""

from __future__ import annotations

from pathlib import Path

from moireid_studio.auth.tokens import Tokens
from moireid_studio.links import Links


def test_what_one_studio_writes_another_one_reads(tmp_path: Path, state: str | None) -> None:
    """Catches: a database that only one studio sees; a link that two of them use; a token that one of them revokes and
    another still takes."""
    here, there = (Tokens(tmp_path, state) for _ in range(2))
    secret, token = here.create("verifier")
    assert there.find(secret) == token and there.of_session(here.begin_session(secret) or "") == token
    links = [Links(tmp_path, state) for _ in range(2)]
    made = links[0].make(token.id, "Example News", "0" * 16, ids=False, wants_pictures=True)
    assert made is not None and links[1].by_secret(made[0]) == made[1]
    assert [one.use(made[1], agreed=True) for one in links] == [True, False]
    links[1].note_end(made[1], {"verdict": "accept"}, [b"jpeg"])
    assert links[0].pictures(made[1]) == [b"jpeg"] and [one.state for one in links[0].of_asker(token.id, 9)] == ["done"]
    there.revoke(token.id)
    assert here.find(secret) is None
    for one in (here, there, *links):
        one.close()
