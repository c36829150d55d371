"""`moireid bench SUITE`: figures with the command that prints them; this room may use all others, as the programs do.

identity/     is the whole identity read, over distance, printing and assembly; is a copy recognised?
fabricate/    pages and mounts, read back from what was written; photographs of a pitch test
simulate/     error against run time of the renderers, and what a scene does not need
verify/       error against run time of the verifier; stiff and extreme motions
forgers/      attacks by those who read this code, and everyday mishaps
film_set.py   films by the engine of collections, with the list that `evaluate` reads
rows.py       films of a suite made and read by the engine of collections (moireid_lab.archive)
verdicts.py   what a row keeps of a report
output.py     JSON of a suite; its table and plot
live.py       replays of earlier answers to new challenges
natural.py    table and plot of the natural suite
published.py  the paper's tables beside ours, as text and as a plot
reality.py    table and plot of the reality suite
stability.py  table and plot of the stability suite
"""
