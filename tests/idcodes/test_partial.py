"""A word that cannot be corrected, compared with known people.  Each test names the fault that it catches."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from moireid.idcodes import WRONG_PERSON, PartialWord
from moireid.idcodes.words import WordCode
from moireid.verifier.decision.judge import Invariant
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason
from moireid.verifier.session.identify import judge

CODE = WordCode(8, 26)


def spoilt(payload: bytes, wrong: list[int], *, lost: tuple[int, ...] = (), beats: bool = True) -> PartialWord:
    """The word of `payload` with some bytes wrong and some not read."""
    octets: list[int | None] = list(CODE.encode(payload))
    for place in wrong:
        octets[place] ^= 0x5A  # type: ignore[operator]
    for place in lost:
        octets[place] = None
    return PartialWord(CODE, tuple(octets), lambda found: beats)


@dataclass
class People:
    """Who is enrolled."""

    ids: list[str]
    revoked: list[str] = field(default_factory=list)

    def holds(self, badge_id: str) -> bool:
        return badge_id in self.ids and badge_id not in self.revoked

    def alike(self, parts: dict[int, str]) -> list[str]:
        return [i for i in self.ids if any(i[4 * place : 4 * place + 4] == part for place, part in parts.items())]


def found_among(people: People, word: PartialWord | None, law: str = "accept", *reasons: Reason, **identity: object):
    invariant = Invariant(law, ())  # type: ignore[arg-type]
    report = SimpleNamespace(
        reasons=reasons, invariant=invariant, identity=Identity("not_claimed", (), partial=word, **identity)
    )
    return judge(report, people)  # type: ignore[arg-type]


@pytest.mark.claim("A damaged identity passes for another by the stated chance at most")
def test_chance_of_a_wrong_person_bounds_what_strangers_reach(rng):
    """Catches: an exponent of one too many; agreement counted in cells, or in bytes that were not read."""
    known = [np.frombuffer(CODE.encode(rng.bytes(8)), np.uint8) for _ in range(60)]
    strangers = rng.integers(0, 256, (4000, CODE.word_bytes), np.uint8)
    agreeing = np.concatenate([(strangers == word).sum(axis=1) for word in known])
    word = spoilt(bytes(8), [])
    for count in (1, 2):
        measured, bound = float(np.mean(agreeing >= count)), word.wrong_person(count) / 1e9
        assert measured <= (bound if word.wrong_person(count) < 1 else 26 * 256.0**-count * 13)
    assert word.wrong_person(10) > WRONG_PERSON >= word.wrong_person(11)
    assert spoilt(bytes(8), [], lost=tuple(range(10, 26))).wrong_person(10) < word.wrong_person(10)
    # Beyond payload and check the parity follows from them, so more agreement proves no more than 13 bytes do.
    assert spoilt(bytes(8), [], lost=tuple(range(20, 26))).wrong_person(20) >= 1e9 * 256.0**-13


def test_one_person_is_identified_by_a_word_that_cannot_be_corrected(rng):
    """Catches: the nearest person whatever the distance; a person found though two parts of the id are wrong."""
    ids = [rng.bytes(8).hex() for _ in range(200)]
    payload = bytes.fromhex(ids[17])
    word = spoilt(payload, [0, 1, 2, 3, *range(9, 15)])
    assert CODE.decode(bytes(word.octets), [0.1] * 26) is None  # type: ignore[arg-type]
    assert word.agreeing(payload) == 16
    outcome = found_among(People(ids), word)
    assert (outcome.finding, outcome.found_id) == ("found", ids[17])
    assert "16 of its 26" in outcome.reasons[-1].text
    outcome = found_among(People(ids), spoilt(payload, [0, 1, 2, 3, *range(8, 15)]))
    assert (outcome.finding, outcome.found_id) == ("inconclusive", None)


@pytest.mark.parametrize("why", ["revoked", "stranger", "beats", "nothing", "other length"])
def test_no_one_is_identified_where_it_is_not_allowed(why, rng):
    """Catches: a revoked person found by the back door; a stranger taken for somebody; beats left out."""
    ids = [rng.bytes(8).hex() for _ in range(50)]
    payload = bytes.fromhex(ids[3])
    wrong = [0, 1, *range(9, 16)]
    people = People(ids, revoked=[ids[3]] if why == "revoked" else [])
    if why == "stranger":
        ids.remove(payload.hex())
    if why == "other length":
        people = People([ids[3] + 16 * "0"])
    word = None if why == "nothing" else spoilt(payload, wrong, beats=why != "beats")
    outcome = found_among(people, word)
    assert (outcome.finding, outcome.found_id) == ("inconclusive", None)


def test_a_decoded_id_under_another_s_beats_identifies_no_one(rng):
    """Catches: beats that only a claim is held against."""
    badge_id = rng.bytes(8).hex()
    outcome = found_among(People([badge_id]), None, decoded_id=badge_id, beats_agree=False)
    assert (outcome.finding, outcome.found_id) == ("nobody", None)
    assert outcome.reasons[-1].code == "beats"
    assert found_among(People([badge_id]), None, decoded_id=badge_id).finding == "found"


@pytest.mark.parametrize(
    ("law", "doubts", "enrolled", "finding"),
    [
        ("reject", (), True, "nobody"),
        ("inconclusive", (), True, "inconclusive"),
        ("accept", ("damaged",), True, "inconclusive"),
        ("accept", (), False, "nobody"),
    ],
)
def test_a_name_needs_the_law_a_whole_film_and_a_record(law, doubts, enrolled, finding):
    """Catches: somebody named for a forged film, or one that was not judged whole; a stranger taken for somebody."""
    notes = [Reason(code, "undecided", None, None, "", "") for code in doubts]
    people = People(["0102030405060708"] if enrolled else [])
    assert found_among(people, None, law, *notes, decoded_id="0102030405060708").finding == finding


def test_somebody_with_a_chosen_id_is_never_taken_for_another():
    """Catches: a chance that holds for ids drawn at random alone; words of ids that differ in a byte agree in many."""
    code = WordCode(16, 42)
    mine, like = bytes(range(16)), bytes(range(15)) + b"\xff"
    octets = list(code.encode(mine))
    for place in range(21, 42):
        octets[place] ^= 0x33
    word = PartialWord(code, tuple(octets), lambda found: True)
    assert word.agreeing(like) >= 15 and word.wrong_person(word.agreeing(like)) < WRONG_PERSON
    for enrolled, revoked in (([like], []), ([mine, like], [mine])):
        people = People([i.hex() for i in enrolled], [i.hex() for i in revoked])
        assert found_among(people, word).found_id is None
