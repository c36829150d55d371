"""`moireid registry`: its commands, thin as all of them.

records.py   init, list, show, forget
states.py    revoke, suspend, reinstate
checks.py    audit, checkpoint, publish
proofs.py    prove, check-proof
history.py   log, erase
transfer.py  export, import
keys.py      rotate-key, signer
"""

from moireid.cli.registry import checks, history, keys, proofs, states, transfer
from moireid.cli.registry.records import registry_group

__all__ = ["checks", "history", "keys", "proofs", "registry_group", "states", "transfer"]
