"""Signed verdicts: the verifier's user signs a report, and anyone can check it later.

signing_keys.py      private keys with certificates, public keys, their fingerprints
statement.py         what is signed: an in-toto statement about a film, with the report in it; strict reading of JSON
envelope.py          the signed statement as a DSSE envelope
checking.py          checks of an envelope: signature, key, report, certificates and film
certificate_identity.py  whom the signer's certificate must name, by the word of an authority that is trusted
registry_answer.py   what a registry says about a verdict's badge and signer
credentials.py       the verdict as content credentials (C2PA), written by a process without the key
credentials_work.py  the process that reads and writes content credentials, without the key

The process that has the key never decodes a film.
"""
