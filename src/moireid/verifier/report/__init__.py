"""The report for people.

page.py           one page in one file, and the files next to it
circumstances.py  what is not in the film: when and by which claim it was checked, and what the registry knows
headline.py       the result in one line, by name, and what to do next
live_headline.py  the same of a live check
open_words.py     why a film is inconclusive, in a few words
person.py         whose badge is claimed           findings.py  failures first, passes last
rival_table.py    what else could move the fringes, and what of it remains
rival_plot.py     the best rival next to the law, by time
seconds.py        which seconds were judged, as bars and in words
pictures.py       the pictures, as files by name   frame.py     the whole frame, the badge outlined
law_plot.py       the law by time                  plots.py     the plots for experts
drawing.py        what all plots share: colours for light and dark pages, lines that break
"""
