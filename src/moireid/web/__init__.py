"""The studio: pages and an API over the library, for `moireid serve`.  It adds no optics of its own.

app.py         create_app: what is switched on, in one list    settings.py  where things lie, and the limits
studio.py      what all routes share: registry, tokens         problems.py  errors as one sentence, on a page or in JSON
roles.py       who may do what: `require("issuer")`            tokens.py    tokens, of which only a hash is kept
guard.py       headers, and nothing sent by other sites        pages.py     templates into pages
home_pages.py  the first page, help, signing in and out
live.py        the live check and its WebSocket            live_worker.py  the process behind one session

FastAPI is imported by this room alone, so nothing but `moireid serve` pays for it.
"""
