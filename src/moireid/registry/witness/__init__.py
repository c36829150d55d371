"""Witnesses: servers that sign a log's checkpoint only if the log goes on from all that they signed before.

request.py  the request that a log sends to a witness, and the answers, as text
state.py    a witness's key and the newest checkpoint of each log, in one file
server.py   the server: `moireid witness`
client.py   a registry asks witnesses for their signatures
Source: C2SP tlog-witness, https://c2sp.org/tlog-witness.
"""
