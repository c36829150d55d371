"""Checks that show when a registry was put back to an earlier state: signed checkpoints, and what was seen last.

merkle.py      the Merkle tree of RFC 6962: roots, and proofs of inclusion and consistency
checkpoint.py  signed notes, and checkpoints: a log's size and root as such a note
witness.py     checkpoints from a file, a folder or a web address; a log compared with them and with what was seen
seen.py        which authority and which head this user saw last; whether a record is the newest version
proof.py       a proof that a record is in the log, for a person without the registry
"""
