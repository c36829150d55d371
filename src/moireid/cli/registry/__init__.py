"""`moireid registry`: its commands, thin as all of them.

records.py   init, list, show, revoke, forget
checks.py    audit, checkpoint, publish
history.py   log, erase
transfer.py  export, import
"""

from moireid.cli.registry import checks, history, transfer
from moireid.cli.registry.records import registry_group

__all__ = ["checks", "history", "registry_group", "transfer"]
