"""`moireid bench SUITE`: figures with the command that prints them; this room may use all others, as the programs do.

identity/    is the whole identity read, over distance, printing and assembly; is a copy recognised?
stability/   films at the edge and beyond
fabricate/   pages and mounts, read back from what was written; photographs of a pitch test
simulate/    error against run time of the renderers, and what a scene does not need
verify/      error against run time of the verifier; stiff and extreme motions
forgers/     attacks by those who read this code, and everyday mishaps
reality/     films by phones, editors, calls and services: is a true badge ever rejected?
natural/     films with measured motions: does a longer film decide more?
published/   the published paper's tables, filmed by our simulator
live/        the live challenge, and replays
film_set.py  films by the engine of collections, with the list that `evaluate` reads
rows.py      films of a suite made and read by the engine of collections (moireid_lab.archive)
verdicts.py  what a row keeps of a report
output.py    JSON of a suite; its table and plot
"""
