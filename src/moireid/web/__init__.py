"""The studio: pages and an API over the library, for `moireid serve`.  It adds no optics of its own.

app.py             create_app: which routes there are     settings.py   where things lie, and the limits
studio.py          what all routes share                  problems.py   errors as one sentence, on a page or in JSON
roles.py           who may do what: `require("issuer")`   tokens.py     tokens, of which only a hash is kept
guard.py           headers, and nothing from other sites  pages.py      templates into pages
uploads.py         a form with a film, to the disk        checks.py     from a form to a job at work
jobs.py            films that wait, work, are over        child.py      a process for each film; task.py the way in
work.py            what that process does                 schema.py     what /openapi.json says of forms and reports
home_pages.py      first page, help, signing in           verify_pages.py, registry_pages.py, api.py, registry_api.py
issue_pages.py     one person, or an event                issue_api.py  the same for programs, and captures
orders.py          what is wished, checked as by command  forms.py      fields and small files, within a limit
issue_jobs.py      orders to jobs, and back               issue_work.py, enroll_work.py  what their processes do
issue_words.py     the link budget in words               preview_law.py  what static/fringes.js draws a badge from
enroll_pages.py    a capture, measured, then kept         built_words.py  what was measured, in words and on scales
events.py          a job's progress, as it changes        live.py       the live check and its socket
live_worker.py     the process behind one live session

FastAPI is imported by this room alone, so nothing but `moireid serve` pays for it.
"""
