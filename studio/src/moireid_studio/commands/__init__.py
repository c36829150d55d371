"""The commands that the studio adds to `moireid`.

serve_cmd.py     serve, token create / list / revoke
verdicts_cmd.py  verdicts: list or export those that a studio gave
watch_cmd.py     watch: its options and the order of its steps
watch_display.py  what it shows on a terminal, or as lines
watch_kept.py    what is kept of a watched live check: figures, a receipt
"""
