"""The studio: pages and an API over moireid, for `moireid serve`, and live checks.  It adds no optics of its own.

settings.py      where things are, and the limits
studio.py        what all routes share
app.py           create_app: which routes there are
problems.py      errors: a code and one sentence
forms.py         fields and small files, within a limit
uploads.py       a form with a film, to the disk
checks.py        from a form, or a film to try, to a job at work
issue_jobs.py    orders to jobs, and back
reports.py       a verdict as a page
links.py         one-time links, and what came of them
receipts.py      their receipts, and the reports of films that they are about
pictures.py      logos and portraits, kept until printed
picture_work.py  the sealed process that reads them
store/           the studio's own tables, and films that wait
auth/            roles, tokens, and no requests from other sites
http/            the server, its figures and log, and how much a token may ask
jobs/            work that takes time; each job has its own process
pages/           the pages
api/             the API
live/            the pages and sockets of a live check
challenge/       the live check itself: random prompts, and whether they were followed
watch/           a stream as it comes: a camera, a file that grows, a pipe
commands/        serve, token, watch

FastAPI is imported by `app.py` and what is under it, so nothing but `moireid serve` pays for it.
"""
