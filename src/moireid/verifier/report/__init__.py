"""The report for people.

report_page.py    one page in one file, its pictures, and the files next to it
circumstances.py  what is not in the film: when and by which claim it was checked, and what the registry knows
headline.py       the result in one line, by name, and what to do next
live_receipt.py   receipts of live checks, which a film's report may hold
finding_words.py  failures first, passes last
rival_table.py    what else could move the fringes, and which of these explanations remain
seconds.py        which seconds were judged, as bars and in words
film_frame.py     one frame of the film
plots.py          the plot of the law over time
phase_figure.py   measured against predicted phase, for notebooks
summary.py        headline, advice and the plot of the law as a few lines of HTML, for notebooks
"""
