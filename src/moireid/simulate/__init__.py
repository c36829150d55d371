"""Films of a badge, true or forged, with their ground truth.

scene.py      one description of badge as built and camera, for every renderer
motion.py     where the camera is: named motions, measured hand-held run, CSV files
camera.py     cameras: lens and its distortion, shutter, exposure; some by name
light.py      a disc of light before an even sky, and the bands into which the lenses focus it
analytic.py   rays traced in closed form through the true lenses, only where the badge is; in these three:
  quick.py    most pixels, many rays at once in float32      trace.py   the rest, ray by ray in float64
  rows.py     the loop over pixels      page.py   what is printed, as tables      light_kernels.py   what light adds
accuracy.py   how far one picture is from another, in radians of fringe phase
shutter.py    a frame in time: rolling shutter and exposure
sensor.py     background, blur, exposure, noise, sharpening
encode.py     codecs, and what chat programs do to a film
shown.py      what a film shows: the truth, or a forgery of any kind, by the next three
forge.py      false courses of the fringes
patches.py    parts of a badge that disagree
flat.py       a photograph, and a replay on a screen
truth.py      the ground truth beside a film
left_out.py   what a film does not show, and the time that saves
film.py       the whole film: frames, file and truth
wish.py       a film as it is asked for, in names and numbers
mitsuba_renderer.py   the same scene as geometry for Mitsuba 3: frames of a film
mitsuba_sheet.py   its lens sheet, a watertight solid      mitsuba_page.py   its printed lines, as strips
mitsuba_parts.py   meshes, surfaces and camera as Mitsuba's objects      mitsuba_view.py   which pixels it renders
mitsuba_estimate.py   its error, told before a film, and the setting that meets a wish
mitsuba_lit.py   the same under a light of its own, path-traced
mitsuba_variant.py   which of Mitsuba's variants this machine runs
"""
