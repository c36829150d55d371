"""A film in, a verdict out.

verify_cmd.py    verify: the order of its steps
identify_cmd.py  identify
options.py       the options of verify, what was asked for, and what does not go together
"""
