"""What a camera and a codec make of a picture.

shutter.py   a frame in time: rolling shutter and exposure
sensor.py    background, blur, exposure, noise, sharpening
encode.py    codecs, and what chat programs do to a film
transfer.py  curves of high dynamic range
priority.py  the scheduling class that an encoder leaves behind
"""
