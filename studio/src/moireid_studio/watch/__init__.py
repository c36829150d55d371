"""A stream judged as it comes: a camera, a file that grows, a pipe.

source.py    what a source is, from what was typed
order.py     the messages between the two processes
watching.py  our side: start the judge, feed it, take its events
feeding.py   what the judge is fed: bytes of a pipe, pictures of a camera
cameras.py   cameras of this machine
judge.py     the judge's process: pictures in, events out
readers.py   a file that grows, a pipe's bytes, their pictures, and those that wait
"""
