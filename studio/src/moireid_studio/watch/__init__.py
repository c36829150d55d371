"""Any stream judged as it comes: a camera, the screen, a file that grows, a pipe, an address, a WebRTC sender.

source.py    what a source is, from what was typed
order.py     the messages between the two processes
watching.py  our side: start the judge, feed it, take its events
feeding.py   bytes for the judge: of a pipe, of addresses; a WebRTC stream, asked for (WHEP)
fetching.py  HTTP, and which addresses a playlist may name
devices.py   cameras of this machine, and its screen
whip.py      a server that takes one WebRTC sender (WHIP)
judge.py     the judge's process: pictures in, events out
readers.py   a file that grows, bytes that are asked for, their pictures, and those that wait
peer.py      pictures of a WebRTC sender
"""
