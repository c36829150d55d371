"""An outside tracer: films of a printed badge that share nothing with `moireid.simulate`.

What judges films must not be tested by the renderer of its own authors alone.  This one takes the page as a picture,
`badge.pdf` rasterised, and of `badge.json` what the builder of the badge knows: the board's outline, the lens
sheet, and where it is placed.  Rays go through the true shape of each lens.  It never imports the simulator, the phase
law or the lenticule's table of `moireid`; a test checks this.

page.py      the page as a raster, and the sheets placed on it
build.py     what goes wrong when a badge is printed and put together
flaws.py     what printers, sheets and wearers do to a badge
bend.py      a badge bent to a cylinder, or twisted
lens.py      one ray through a cylinder lens, by Snell's law
motion.py    where badge and camera are: a wearer who sways, a camera that walks, a measured hand
camera.py    a phone's or laptop's camera: rays of its pixels, shutter, noise
trace.py     one frame in linear light
lamps.py     a lamp to the side, and one that lenses mirror
sensor.py    from light to bytes: vignetting, noise, gamma
forge.py     thirteen lies: the lens region's picture taken from a wrong view
rivals.py    forgeries on the film's own trajectory, each rival of the law at its best
film.py      all of it together, into an H.264 file

Convention: badge frame in mm, origin at the board's centre, x right, y down, z into the page, whose ink is at z = 0; so
the crowns of lenses are at z = -thickness and a camera is at negative z.  Camera frame: x right, y down, z forward.
"""
