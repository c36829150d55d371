"""`moireid registry`: its commands.

records.py  init, list, show, forget; log, erase; revoke
checks.py   audit, checkpoint, publish
copies.py   export, import
"""

from moireid.cli.registry import checks, copies, records
from moireid.cli.registry.records import registry_group

__all__ = ["checks", "copies", "records", "registry_group"]
