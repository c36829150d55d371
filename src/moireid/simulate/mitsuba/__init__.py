"""The same scene as geometry for Mitsuba 3.

renderer.py  frames of a film                       sheet.py     the lens sheet, a watertight solid
page.py      the printed lines, as strips           parts.py     meshes, surfaces and camera as Mitsuba's objects
view.py      which pixels are rendered              estimate.py  its error, and the setting that meets a wish
lit.py       under a light, path-traced             variant.py   which variant of Mitsuba this machine runs
"""
