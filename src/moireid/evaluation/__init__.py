"""`moireid evaluate`: a labelled collection of films, scored by our pipeline and by the published one.

manifest.py    the collection's list, read and checked whole before any work
rows.py        one film with one pipeline: a row of figures, and the key under which it is kept
workers.py     rows made in processes of their own, which may crash or hang without ending the run
collect.py     every row of a collection; those kept from an earlier run are not made again
statistics.py  ROC, AUC, EER, thresholds, effect sizes and intervals: plain functions over arrays
summary.py     from rows to the figures of evaluate.json
table.py       the figures as text
plots.py       scores by group, ROC and DET
"""
