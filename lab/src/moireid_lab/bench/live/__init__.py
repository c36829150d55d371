"""The live challenge.

film.py  a person before a webcam who follows prompts     replays.py  earlier answers to fresh challenges
call.py  a call: prompts read aloud, a line with delay, a codec and lost pictures
"""
