"""The commands that the lab adds to `moireid`.

lab_cmd.py        the group `moireid lab`
bench_cmd.py      bench
cost_cmd.py       cost
evaluate_cmd.py   evaluate
film_set_cmd.py   film-set
generator_cmd.py  generator-kit
paper_cmd.py      paper
scoreboard_cmd.py  scoreboard
sharing.py        options that say where films are made and scored
"""
