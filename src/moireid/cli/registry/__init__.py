"""`moireid registry`: its commands, thin as all of them.

records.py   init, list, show, revoke, forget
checks.py    audit, checkpoint, publish
proofs.py    prove, check-proof
transfer.py  export, import
"""

from moireid.cli.registry import checks, proofs, transfer
from moireid.cli.registry.records import registry_group

__all__ = ["checks", "proofs", "registry_group", "transfer"]
