"""moireid: print a moiré badge, film it, and check that its fringes obey the optics and whose badge it is.

badge.py       the frozen Badge and its JSON             idcodes/     payload <-> line spacing
profiles.py    lens sheets, printers, papers             designer/    name, lens, printer, range -> Badge
optics.py      the phase law in closed form              fabrication/ Badge -> PDF and mount
lenticule.py   the trace that calibrates the law         simulate/    Badge -> film, true or forged
errors.py      the error tree                            verifier/    film -> report and verdict
files.py       files written whole or not at all         registry/    who was issued which badge
lazy.py        packages that load modules on demand      calibration/ photographs of a pitch test -> lens profile
sheets.py      lens sheets as they are sold              attest/      verdicts signed, and checked by others
lens_array.py  the same for round lenses                 cli/         the two programs
"""

__version__ = "0.1.0"
