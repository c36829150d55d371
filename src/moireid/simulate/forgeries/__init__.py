"""What a forged film shows.

trajectories.py  kinds of forgeries, and false trajectories of the fringes
rear_layer.py    what a film shows of the badge, frame by frame: the truth, or any kind
"""
