"""Forgeries that are made from true films of badges, frame by frame.

clip.py      a film as pictures of the board, straightened, each with the view that it shows
replay.py    frames of a clip, put where another trajectory asks for their views
rebadge.py   the middle row of one badge's film, copied into every cell of another badge

The forger is a good one: he knows the markers' homographies and all views without error, his camera has no rolling
shutter, and what he makes is filmed anew on a flat board that has the badge's true print around the fringes.

Convention: a view is (u, v, d): the parallax coordinates Cx/|Cz| and Cy/|Cz| of the board's centre, and the distance
|Cz|, mm.  Pictures of the board are (rows, columns) at `PX_PER_MM`, in coded brightness, 0 to 1.
"""
