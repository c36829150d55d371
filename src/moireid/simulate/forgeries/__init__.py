"""What a forged film shows.

courses.py     false courses of the fringes
rear_layer.py  what a film shows of the badge, frame by frame
"""
