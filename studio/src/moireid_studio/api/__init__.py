"""The API.

films.py         verify and identify; jobs and their reports
issue_api.py     badges and captures
registry_api.py  look up, revoke, audit
work_api.py      what the workers of a cluster ask
health.py        whether the studio is up and ready; its figures
schema.py        what /openapi.json says of forms and reports
"""
