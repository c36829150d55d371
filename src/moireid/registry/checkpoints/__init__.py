"""What somebody else can keep, so that a registry cannot be turned back: signed checkpoints, and what was seen last.

merkle.py      the Merkle tree of RFC 6962: roots, and proofs of inclusion and consistency
note.py        signed notes, as transparency logs write them
checkpoint.py  a log's size and root as a signed note
witness.py     checkpoints from a file, a folder or a web address; a log held against them
seen.py        which authority and which head this user saw last
newest.py      a record held against the log up to its signed head
proof.py       the same for somebody without the registry
standing.py    a registry held against what was seen last and what is trusted
"""
