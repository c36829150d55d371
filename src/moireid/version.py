"""The version of the packages.

It has a module of its own, as `moireid` itself names what all rooms offer, and no room may lead back to them.
"""

__version__ = "0.1.0"
