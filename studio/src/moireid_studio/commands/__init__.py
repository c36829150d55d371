"""The commands that the studio adds to `moireid`.

serve_cmd.py     serve, token create / list / revoke
watch_cmd.py     watch: its options and the order of its steps
watch_display.py  what it shows, in lines or as JSON
"""
