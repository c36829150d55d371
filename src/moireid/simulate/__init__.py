"""Films of a badge, true or forged, with their ground truth.

motion.py     where the camera is: named motions, measured hand-held run, CSV files
scene.py      one description of badge as built, camera and motion, for every renderer
light.py      a disc of light before an even sky, and the bands into which the lenses focus it
forge.py      fringes that move by another law
analytic.py   rays traced in closed form through the true lenses, only where the badge is
light_kernels.py   what the light adds to each of those rays
sensor.py     background, exposure, noise, encoding
film.py       the whole film: H.264 and truth beside it
mitsuba_renderer.py   the same scene as geometry for Mitsuba 3: frames of a film
mitsuba_sheet.py   its lens sheet, a watertight solid      mitsuba_page.py   its printed lines, as strips
mitsuba_parts.py   meshes, surfaces and camera as Mitsuba's objects      mitsuba_view.py   which pixels it renders
mitsuba_lit.py   the same under a light of its own, path-traced
mitsuba_variant.py   which of Mitsuba's variants this machine runs
"""
