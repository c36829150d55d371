"""Films of a badge, true or forged, with their ground truth.

scene.py      one description of badge as built and camera, for every renderer
motion.py     where the camera is: named motions, measured hand-held run, CSV files
camera.py     cameras: lens and its distortion, shutter, exposure; some by name
analytic.py   rays traced in closed form through the true lenses, only where the badge is
shutter.py    a frame in time: rolling shutter and exposure
sensor.py     background, blur, exposure, noise, sharpening
encode.py     codecs, and what chat programs do to a film
shown.py      what a film shows: the truth, or a forgery of any kind, by the next three
forge.py      false courses of the fringes
patches.py    parts of a badge that disagree
flat.py       a photograph, and a replay on a screen
truth.py      the ground truth beside a film
film.py       the whole film: frames, file and truth
mitsuba_scene.py   the same scene as geometry for Mitsuba 3, one frame
"""
