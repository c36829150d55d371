"""A film in, a verdict out.

verify_cmd.py    verify: the order of its steps
identify_cmd.py  identify
options.py       the options of verify, what was asked for, and what does not go together
asked.py         the badge that is claimed, by a registry, a bundle or a file; and what these know of a report
judging.py       the film judged in this process, or apart from a key; the pages of it
showing.py       a verdict in the terminal
"""
