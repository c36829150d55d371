"""`moireid registry`: its commands, thin as all of them.

records.py   init, list, show, revoke, forget
checks.py    audit, checkpoint, publish
transfer.py  export, import
keys.py      rotate-key, signer
"""

from moireid.cli.registry import checks, keys, transfer
from moireid.cli.registry.records import registry_group

__all__ = ["checks", "keys", "registry_group", "transfer"]
