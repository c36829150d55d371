"""A trust bundle: what a verifier needs of a registry, in one signed file that any web server can hand out.

bundle_file.py  the file: a signed header with the content's digest, then the content: people with what bars them,
                layouts, and the log's hashes
publish.py      the people of a registry, sealed
held.py         read a bundle: its checks, and the badge that a claim means
"""
