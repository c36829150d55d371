"""The Merkle tree, against the vectors of Certificate Transparency and in all small cases.  Each test says what it
catches."""

from __future__ import annotations

import hashlib
import itertools

import pytest

from kit.witnesses import consistent, root_of
from moireid.registry.merkle import consistency_proof, leaf_hash

# The inputs and results that the logs of Certificate Transparency are tested with.
INPUTS = ("", "00", "10", "2021", "3031", "40414243", "5051525354555657", "606162636465666768696a6b6c6d6e6f")
LEAVES = [leaf_hash(bytes.fromhex(text)) for text in INPUTS]
ROOTS = (
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
    "6e340b9cffb37a989ca544e6bb780a2c78901d3fb33738768511a30617afa01d",
    "fac54203e7cc696cf0dfcb42c92a1d9dbaf70ad9e621f4bd8d98662f00e3c125",
    "aeb6bcfe274b70a14fb067a5e5578264db0fa9b51af5e0ba159158f329e06e77",
    "d37ee418976dd95753c1c73862b9398fa2a2cf9b4ff0fdfe8b30cd95209614b7",
    "4e3bbb1f7b478dcfe71fb631631519a3bca12c9aefca1612bfce4c13a86264d4",
    "76e67dadbcdf1e10e1b74ddc608abd2f98dfb16fbce75277b5232a127f2087ef",
    "ddb89be403809e325750d3d263cd78929c2942b7942a34b77e122c9594a74c8c",
    "5dc9da79a70659a9ad559cb701ded9a2ab9d823aad2f4960cfe370eff4604328",
)
A, B = (
    "96a296d224f285c67bee93c30f8a309157f0daa35dc5b87e410b78630a09cfc7",
    "5f083f0a1a33ca076a95279832580db3e0ef4584bdff1f54c8a360f50de3031e",
)
C, D = (
    "6b47aaf29ee3c2af9af889bc1fb9254dabd31177f16232dd6aab035ca39bf6e4",
    "bc1a0643b12e4d2d7c77918f44e0f4f79a838b6cf9ec5b5c283e1f4d88599e6b",
)
E, F = (
    "ca854ea128ed050b41b35ffc1b87b8eb2bde461e9e3b5596ece6b9d5975a0ae0",
    "0ebc5d3437fbe2db158b9f126a1d118e308181031d0a949f8dededebc558ef6a",
)
G = "b08693ec2e721597130641e8211e7eedccb4c26413963eee6c1e2ed16ffb1a5f"


@pytest.mark.parametrize("size", range(9))
def test_roots_are_those_of_certificate_transparency(size):
    """Catches: a leaf hashed as a node; an odd leaf that is doubled; peaks joined from the wrong side."""
    assert root_of(LEAVES[:size]).hex() == ROOTS[size]


@pytest.mark.parametrize(
    ("first", "second", "proof"),
    [(1, 1, []), (1, 8, [A, B, C]), (6, 8, [F, E, ROOTS[4]]), (2, 5, [B, D]), (6, 7, [F, G, ROOTS[4]])],
)
def test_consistency_proofs_are_those_of_certificate_transparency(first, second, proof):
    """Catches: a proof that repeats the old root where the RFC leaves it out."""
    assert [step.hex() for step in consistency_proof(LEAVES[:second], first)] == proof


def test_every_proof_of_small_trees_holds_for_a_witness_and_no_other_does():
    """Catches: a proof that is shortened, lengthened or of another size or root, by a witness's own check of it."""
    leaves = [leaf_hash(bytes([number])) for number in range(18)]
    roots = [root_of(leaves[:size]) for size in range(19)]
    other = hashlib.sha256(b"other").digest()
    for first, second in itertools.combinations_with_replacement(range(1, 19), 2):
        proof = consistency_proof(leaves[:second], first)
        assert consistent(first, roots[first], second, roots[second], proof)
        for wrong in ([*proof, other], proof[:-1] if proof else [other]):
            assert not consistent(first, roots[first], second, roots[second], wrong)
        assert not consistent(first, other, second, roots[second], proof)
