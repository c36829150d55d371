"""Where the camera was, from the page's corners alone: focal length, shutter, distortion, and a pose a frame.

plane_pose.py        both poses of a plane, all frames at once   fast_poses.py   the same, near poses that are known
distortion.py        radial lens distortion                      map_search.py   the least misfit with priors
self_calibration.py  focal length, shutter and distortion of a film
steady_path.py       a steady course asks for the focal length   smoothing.py    the course, smoothed
stretches.py         runs of frames without a break
fit.py               the camera over a film
"""
