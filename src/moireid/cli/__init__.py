"""The two programs, thin: parse, call the library, show.

main.py        the group `moireid`, and `print-your-badge`
common.py      exit codes, errors, JSON, progress
printing/      print-your-badge, moireid print; people.py: of many people
issue_notes.py what an issuer is told of identities and names
enroll_cmd.py  enroll
registry/      registry init / list / show and so on
verify/        verify, identify
watch/         watch
attest/        verify --sign, and attest check
simulate_cmd.py  simulate
film_set_cmd.py  film-set
generator_cmd.py  generator-kit
evaluate_cmd.py  evaluate; rate.py: how far and how fast
bench_cmd.py   bench
pitch_cmd.py   pitch-test, calibrate
serve_cmd.py   serve, token create / list / revoke; verdicts_cmd.py: verdicts that a studio gave

Heavy packages are imported inside the functions that need them, so that `--help` stays quick.
"""
