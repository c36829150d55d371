"""assembly.pdf: how the parts go together.

guide.py  parts, steps and views        exploded.py  the parts, moved apart      axonometry.py  drawn from a corner
"""
