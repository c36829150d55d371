"""What a camera and a codec make of a picture.

sensor.py  background, blur, rolling shutter, exposure, noise, sharpening; curves of high dynamic range
encode.py  codecs, and what chat programs do to a film
"""
