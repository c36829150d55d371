"""Where the camera was, from the page's corners alone: focal length, axis, shutter, distortion, and a pose per frame.

plane_pose.py        both poses of a plane, all frames at once; a camera in closed form
fast_poses.py        the same near known poses, faster; does one camera explain them?
distortion.py        radial lens distortion
page_shape.py        a page that is bent or twisted
map_search.py        maximum a posteriori search, and the path of a zoom
film_camera.py       a film's camera: its nine figures, and what they leave of the page's points
self_calibration.py  focal length, axis, shutter, distortion and the print's aspect, of a film, solved
smoothing.py         the camera's path, smoothed; misfit on a steady path
stretches.py         runs of frames without a break
page_speed.py        speed and jumps of the page in the picture; effect of the print's aspect
known_camera.py      a camera that was calibrated before, from its file
fit.py               the camera over a film
"""
