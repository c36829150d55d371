"""The two programs: they parse the options, call the library and show the result.

streams.py       standard streams that are closed
main.py          the group `moireid`, which other distributions add commands to, and `print-your-badge`
common.py        exit codes, errors, JSON, progress
sealed_reader.py the process in which films are read, and the option --unsealed
printing/        print-your-badge, moireid print; for one person or for many
issue_notes.py   notes to the issuer about identities and names
enroll_cmd.py    enroll
registry/        registry init, list, show and so on
witness_options.py  options by which readers ask for the signatures of witnesses
verify/          verify, identify
attest/          verify --sign, and attest check
simulate_cmd.py  simulate
first_badge_cmd.py  first-badge
pitch_cmd.py     pitch-test, calibrate

Heavy packages are imported inside the functions that need them, so that `--help` is quick.
"""
