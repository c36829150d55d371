"""`moireid lab evaluate`: a labelled collection of films, scored by our pipeline and by the published one.

manifest.py       the list of films, read and fully checked before any work
csv_lists.py      lists that people write
film_rows.py      one film with one pipeline: a row of figures, and the key under which it is kept
collect.py        every row of a collection, made by the engine; rows of an earlier run are reused
statistics.py     ROC, AUC, EER, thresholds, Cllr and intervals: plain functions over arrays
summary.py        from rows to the figures of evaluate.json
text_table.py     rows as a table of text, also for benches
table.py          the figures as text
plots.py          scores by group, ROC, Tippett
generator_kit.py  frames, prompts and lists for a user who makes forged films with a video generator
"""
