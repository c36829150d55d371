"""Error against run time of the renderers.

suite.py      the sweep                                   left_out.py      what a scene does not need
reference.py  an independent tracer                       scenes.py        eleven scenes
output.py     tables and plots                            stiff_scenes.py  scenes that renderers find hard
"""
