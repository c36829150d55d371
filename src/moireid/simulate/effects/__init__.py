"""What the world does to a film: phones, editors, call programs and services, each effect by name and strength.

effect.py       an effect: what it changes of scene, pictures, times and file
table.py        all effects by name
framing.py      crops, tiles, zoom, auto-framing, focus breathing, stretched pixels, virtual background
stabilising.py  stabilisers, rows that wobble, rolling shutters
retiming.py     frame times, slow motion, encoding, and noise reduction over time
toning.py       tone mapping, sharpening halos, exposure that follows the fringes, glare
"""
