"""moireid: print a moiré badge, film it, and check that its fringes obey the optics and whose badge it is.

badge.py         the frozen Badge and its JSON           errors.py     the error tree
layers.py        its lens and its printed gratings       models.py     files into models, and what is wrong with them
profiles.py      lens sheets and printers by name        files.py      files written whole or not at all
sheets.py        lens sheets as they are sold            lazy.py       packages that load modules on demand
optics.py        the phase law in closed form            extras.py     the sentence for a missing optional package
lenticule.py     ray tracing, and the law's table        sandbox/      work in a process without rights
frames.py        the frame of a grating                  idcodes/      payload <-> line spacing
dots.py          lines on a printer's dots               artwork/      what a badge's page looks like
smooth_lines.py  lines that bend from cell to cell
fiducials.py     four squares, or a thin coded frame     designer/     name, lens, printer, range -> Badge
names.py         invisible letters; lines of namesakes   fabrication/  Badge -> PDF and mount
asbuilt.py       figures of one built badge              simulate/     Badge -> film, true or forged
provenance.py    where a claim comes from                verifier/     film -> report and verdict
result_cache.py  rows of figures kept in a file          reading/      films read in a sealed process
json_schema.py   documents held against a JSON Schema
user_settings.py what a user sets once for all commands
camera_chart.py  the chart to calibrate a camera with    registry/     who was issued which badge
calibration/     a sheet or a camera, from pictures      attest/       verdicts signed, and checked by others
cli/             the two programs                        issuing.py    an order -> a badge that can be made
                                                         enrolment.py  measured figures into a registry
"""

__version__ = "0.1.0"
