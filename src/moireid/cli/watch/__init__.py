"""A stream in, verdicts out as it goes.

watch_cmd.py  watch: its options and the order of its steps      showing.py  the running verdict, as lines or as JSON
"""
