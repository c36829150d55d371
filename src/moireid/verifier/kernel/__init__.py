"""What is computed for each frame and each fit, in C: one small library without dependencies, built with the package.

    kernel.h, picture.c     how a picture and places of the page are given, and where the places lie in it
    registration.c          the whole loop that registers a page
    following.c             a page's registration and its rows in one call
    rows.c                  brightness along strips of the page
    smear.c                 prints that moved while they were exposed
    matching.c              where such a print is
    poses.c                 poses of a plane
    squares.c               clear square markers: a threshold, dark components, their codes
    freestanding.c          what compilers expect of a C library
    library.py              finds the library, checks its version, and how arrays are handed over
    page.py, fitting.py, squares.py   the same for NumPy arrays

Python checks all sizes, C reads and writes only within them and allocates nothing.  The NumPy versions of the same
equations are in the tests, as references.
"""
