"""The live challenge.

film.py  a person before a webcam who follows prompts     replays.py  earlier answers to fresh challenges
"""
