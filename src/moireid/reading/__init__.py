"""Films read in a sealed process, for the commands: one that can do nothing but read its film and answer.

film_reader.py  starts the process, sends it an order, holds its deadline, and takes its answers; or reads here
film_work.py    the work of the process
answers.py      what a reader may answer, and how that is checked
film_reports.py  a film judged or identified so, and what this process states of it
film_orders.py  what is read of a film: a verdict, whose badge it is, or the figures of a badge as built
"""
