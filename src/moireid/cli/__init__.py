"""The two programs, thin: parse, call the library, show.

main.py          the group `moireid`, which other distributions add commands to, and `print-your-badge`
common.py        exit codes, errors, JSON, progress
printing/        print-your-badge, moireid print; people.py: of many people
issue_notes.py   what an issuer learns of identities and names
enroll_cmd.py    enroll
registry/        registry init / list / show and so on
verify/          verify, identify
attest/          verify --sign, and attest check
simulate_cmd.py  simulate
pitch_cmd.py     pitch-test, calibrate

Heavy packages are imported inside the functions that need them, so that `--help` stays quick.
"""
