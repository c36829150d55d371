"""Where the camera was, from the page's corners alone: focal length, axis, shutter, distortion, and a pose per frame.

plane_pose.py        both poses of a plane, all frames at once   fast_poses.py   the same near known poses, faster
distortion.py        radial lens distortion                      map_search.py   maximum a posteriori search
print_aspect.py      a print whose two directions differ in scale
closed_form.py       axis, focal length and aspect of a crop or of a stretched picture, without a search
zoom_course.py       the course of a zoom within a film
self_calibration.py  focal length, axis, shutter, distortion and the print's aspect, of a film
steady_path.py       the focal length from a steady path         smoothing.py    the camera's path, smoothed
stretches.py         runs of frames without a break
page_speed.py        speed and jumps of the page in the picture
one_camera.py        does one camera explain the film, or was its picture zoomed, reframed or stabilised?
fit.py               the camera over a film
"""
