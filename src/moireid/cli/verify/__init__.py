"""The commands that take a film and print a verdict.

verify_cmd.py      verify: look up the claim, judge the film, print the verdict, write the pages
identify_cmd.py    identify: the same without a claim
verify_options.py  whose badge is claimed
"""
