"""What several tests need; no test file imports another.

places.py           where the project, its films and its examples lie
programs.py         programs that pip does not install
compiling.py        the renderer, compiled ahead
claims.py           the ledger of claims, made of the marks of tests
drawn_pages.py      pictures of a page whose homography is known
drawn_frames.py     the same of a page with a coded frame
coded_films.py      films of given pictures, and short ones of long ones
damaging.py         films coded anew, joined, damaged, or flagged as damaged; edit lists and boxes of MP4
crafted_films.py    lists of other files and films of too many streams; a pipe that notes its readers
crafted_media.py    media, links and devices that harm their reader
hostile_verify.py   crafted media through plain verify
numeric_films.py    tracks of a badge, made of numbers alone
fringe_signals.py   phase signals of one grating, and series of them
photographed.py     signals of a badge and of photographs of it
kernel_fuzz.py      calls of the kernel with hostile figures
made_corners.py     a badge's corners as a film would give them
rendered_frames.py  frames by either renderer, and their phase
seen_gratings.py    a grating from straight in front, and the phase of its fringes
takes.py            a page before a camera, as effects know it
drawn.py            the shapes on a PDF page
mounting.py         mounts, and what a camera sees of them
film_stubs.py       jobs that stand in for films
in_place.py         the archive's engine without its processes
sandbox_work.py     what a sandboxed process is given to do
hostile_work.py     what a job's process says once a film has taken it over
sealed_work.py      what a hostile film would do, for a sealed process to try
film_taken_over.py  orders to read that do something else, as a film would
contained.py        a command under the filter of calls of `deploy/`
untrusted_readers.py  the readers of files that strangers give, and contents kept for them
fuzzing.py          those readers fuzzed by coverage
spoilt_films.py     what is used in place of films that spoil or take over their reader
report_documents.py  reports as verify --json prints them, by hand
report_faults.py    a report held against its schema
schemas.py          the shipped JSON Schemas, made of the models
guiding.py          the blocks of a guide, typed
signing.py          keys, certificates and a time authority
payloads.py         a fixed payload for a name
registries.py       registries on SQLite and PostgreSQL
witnesses.py        roots of logs, and witnesses who sign checkpoints
fault_runs.py       file calls of a registry fail, one in each run; faults.c is loaded to do it
enrolling.py        what other processes do at a registry
streams.py          films as they are streamed
webbing.py          a visit to the studio
browsing.py         a studio for a browser, and a look at its pages
releasing.py        the project in another folder, and what is built of it
"""
