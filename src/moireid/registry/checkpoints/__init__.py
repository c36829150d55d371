"""Checks by others that show when a registry was put back to an earlier state.

note.py         signed notes: a text with signatures below it; public keys of those who sign
checkpoint.py   checkpoints: a log's size and root as a signed note
cosignature.py  signatures of witnesses on checkpoints
"""
