"""The same scene as geometry for Mitsuba 3.

mitsuba_renderer.py  frames of a film, with or without a light; their error
sheet.py             the lens sheet, a watertight solid; the page as strips
scene_parts.py       meshes, surfaces and camera as Mitsuba's objects
view.py              which pixels are rendered
variant.py           which variant of Mitsuba this machine runs
"""
