"""Films of a badge, true or forged, with their ground truth.

scene.py      one description of badge as built and camera, for every renderer
motion.py     where the camera is: named motions, measured hand-held run, CSV files
cameras.py    cameras: lens and its distortion, shutter, exposure; some by name
light.py      a disc of light before an even sky, and the bands into which the lenses focus it
analytic/     rays traced in closed form through the true lenses
mitsuba/      the same scene as geometry for Mitsuba 3
recording/    what a camera and a codec make of a picture
forgeries/    what a forged film shows
truth.py      the ground truth beside a film
left_out.py   what a film does not show, and the time that saves
filming.py    the whole film: frames, file and truth
wish.py       a film as it is asked for, in names and numbers
"""
