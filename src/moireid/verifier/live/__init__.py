"""A live check: random prompts that the person must follow.

challenge.py  prompts, and whether they were followed
chance.py     the chance that an older film follows
clock.py      when a live frame was taken
session.py    a live session, of frames and events
stream.py     one of any stream, told as a film is
"""
