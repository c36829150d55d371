"""A trust bundle: what a verifier needs of a registry, in one signed file that any web server can hand out.

parcel.py    the file: a signed header, and a content of which it names the digest
content.py   the content: an SQLite database of people, layouts, revocations and the log's hashes
publish.py   from a registry to a bundle
held.py      a bundle that somebody fetched: its checks, and the badge that a claim means
"""
