"""What a camera and a codec make of a picture.

sensor.py  background, blur, exposure, noise, sharpening
encode.py  codecs, and what chat programs do to a film
"""
