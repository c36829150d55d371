"""What somebody else can keep, so that a registry cannot be turned back: signed checkpoints, and what was seen last.

merkle.py      the Merkle tree of RFC 6962: roots, and proofs of inclusion and consistency
checkpoint.py  a log's size and root as a signed note
witness.py     checkpoints from a file, a folder or a web address; a log held against them
seen.py        which authority and which head this user saw last
proof.py       the same for somebody without the registry
"""
