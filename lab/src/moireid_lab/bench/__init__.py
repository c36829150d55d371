"""`moireid lab bench SUITE`: the project's figures, each printed by a command; this package may import all others.

part.py        a part of the scoreboard: questions, cases, and what makes and judges one
scoreboard.py  every part's cases, rows kept by the sources that they depend on (sources.py), and the answers
scoreboard_tables.py  the tables of README and docs/accuracy.md
identity/      identity_suite.py: is the whole identity read, over distance, printing and assembly? is a copy seen?
fabricate/     fabricate_suite.py: pages, read back from what was written; photographs of a pitch test
simulate/      simulate_suite.py: error against run time of the renderers
forgers/       forgers_suite.py: attacks by those who read this code
film_set.py    films by the engine of collections, with the list that `evaluate` reads
bench_frame.py what is asked of a bench, its cases, rows, table, plot and files
bench_rows.py  rows made by the engine of collections (moireid_lab.archive), kept between runs
bench_plots.py the one plot of a bench
cost.py        the processor time of commands over that of bare packages
suites.py      the suites, and the module of each bench; those in benchmarks/ too
many_people.py badges of a hundred thousand people
live.py        simulated challenges and calls, and replays of earlier answers
paper_films.py the films of the paper's experiments, and stand-ins for what cannot be had
paper_tables.py the paper's tables next to ours
paper.py       films of the paper's experiments, scored by both pipelines
reality.py     the reality suite: films by phones, editors, calls and services
stability.py   the stability suite: stiff and extreme badges, builds, pictures and motions
"""
