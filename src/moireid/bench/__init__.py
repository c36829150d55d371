"""`moireid bench SUITE`: figures with the command that prints them; this room may use all others, as the programs do.

identity.py      does the whole identity come back, over distance, printing and assembly; original or copy?  clips.py
                 films them, matching.py counts false matches by an error model, shorter.py cuts films short
stability.py     films at the edge and beyond; stiff_scenes.py: scenes that renderers find hard
fabricate.py     pages by form and resolution (raster.py reads them), mounts by the angle of their facets; both at their
                 extremes (page_extremes.py, mount_extremes.py); calibration.py reads photographs of a pitch test
simulate.py      error against run time of the renderers, left_out.py what a scene does not need; reference.py: the
                 outside tracer, scenes.py: eleven scenes
verify.py        error against run time of the verifier on films of known truth (verify_films.py); motion_extremes.py:
                 stiff and extreme motions; judged.py: frames in, verdict out
film_set.py      films by the engine of collections, with the list that `evaluate` reads
rows.py          films of a suite made and read by the engine of collections (moireid.archive)
live_film.py     a person before a webcam who follows prompts; replays.py: earlier answers to fresh challenges
output.py        JSON of a suite; table and plot in *_output.py
"""
