"""`moireid bench published`: the tables of the published paper, filmed by our simulator, by both pipelines.

conditions.py  what each row of the tables films, and what of the paper's figures the project knows
suite.py       the films made and scored, and the figures of each row
output.py      table and plot
"""
