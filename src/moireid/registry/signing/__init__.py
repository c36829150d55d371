"""The authority's private key in a process of its own: it alone reads the key, and signs what others ask for.

signer_process.py  the process: `moireid registry signer`, or one that the studio starts for itself
client.py          the other side: a signer that asks that process
Convention: the process listens at a Unix socket, named by MOIREID_SIGNER.  Messages are JSON in both directions.
"""
