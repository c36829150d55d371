"""What the world does to a film: phones, editors, call programs and services, each effect by name and strength.

effect.py       an effect: what it changes of scene, pictures, times and file
table.py        collects all effects by name; add yours in the file of its theme
framing.py      crops, tiles, zoom, auto-framing, focus breathing, stretched pixels, virtual background
stabilising.py  stabilisers, rows that wobble, rolling shutters
retiming.py     frame times, slow motion, and noise reduction over time
coding.py       high dynamic range, calls, low quality
toning.py       tone mapping, sharpening halos, exposure that follows the fringes, glare
"""
