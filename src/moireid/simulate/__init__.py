"""Films of a badge, true or forged, with their ground truth.

motion.py     where the camera is: named motions, measured hand-held run, CSV files
scene.py      one description of badge as built, camera and motion, for every renderer
forge.py      fringes that move by another law
analytic.py   rays traced in closed form through the true lenses, only where the badge is
sensor.py     background, exposure, noise, encoding
film.py       the whole film: H.264 and truth beside it
mitsuba_scene.py   the same scene as geometry for Mitsuba 3, one frame
"""
