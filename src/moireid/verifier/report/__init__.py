"""The report for people.

page.py           one page in one file, and the files beside it
circumstances.py  what the film does not tell of its check: when, by which claim, what the registry knows
headline.py       what is the case, in one line by name, and what to do next
live_headline.py  the same of a live check
open_words.py     why a film is left open, in a few words
person.py         whose badge is claimed           findings.py  failures first, passes last
seconds.py        which seconds were judged, as bars and in words
pictures.py       the pictures, as files by name   frame.py     the whole frame, the badge outlined
law_plot.py       the law by time                  plots.py     the plots for experts
drawing.py        what all plots share: colours by day and night, lines that break
"""
