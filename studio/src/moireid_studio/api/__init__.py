"""The API.

films.py   verify and identify             registry.py  look up, revoke, audit
issue.py   badges and captures             schema.py    what /openapi.json says
verdicts.py  verdicts that were given    health.py      is it up, is it ready; its figures
events.py    a job's progress, as it changes
"""
