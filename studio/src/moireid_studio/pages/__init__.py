"""The pages.

render.py   templates into pages                   home.py         first page, help, signing in
verify.py   a film and its verdict                 registry.py     records, revoking, audit
issue.py    one person, or an event                issue_words.py  the link budget in words
enroll.py   a capture, measured, then kept         built_words.py  what was measured, in words and on scales
preview_law.py  what static/fringes.js draws       player.py       what static/player.js draws beneath a film
answers.py  errors, on a page or in JSON           verdicts.py     which verdicts were given
"""
