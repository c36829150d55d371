"""The pages.

home.py            first page, help, signing in; how pages are made from templates
verify.py          a film and its verdict; errors as pages or JSON
registry_pages.py  records, revoking, audit
issue_pages.py     one person, or an event
enroll.py          a capture, measured, then kept
"""
