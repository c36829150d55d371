"""Error against run time of the renderers.

suite.py      the sweep                                   left_out.py      what a scene does not need
reference.py  a tracer that shares no line with ours      scenes.py        eleven scenes
output.py     tables and plots                            stiff_scenes.py  scenes that renderers find hard
"""
