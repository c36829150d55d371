"""True and forged badges filmed through what phones, editors, calls and services do to a film, at three strengths.

cases.py   effects, strengths, distances and badges   suite.py   filmed and judged   output.py   table and plot
"""
