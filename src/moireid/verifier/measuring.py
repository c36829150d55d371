"""Constants of measuring, identity, enrolment and face: which frames belong together, how large errors are, which
symbol a cell is, and whether figures are those of the enrolled badge.

They are grouped by the question that they answer.  The comment before each says where it comes from, in the words of
`limits.py`.

Each name ends with its unit: `_SHARE` and `_RATIO` are pure numbers, `_SDS` counts standard deviations.  Other limits
are where they are used: finding pages in `tracking/`, decoding in `moireid.idcodes`, live prompts in
`live/challenge.py`.
"""

from __future__ import annotations

import math

# --- Is there enough to judge? ---------------------------------------------------------------------------------------

#: Set by hand: frames with a larger standard deviation of the phase are left out.
MAX_PHASE_SD_RAD = 0.6

# --- Which frames belong together? -----------------------------------------------------------------------------------

#: A badge that is lost moves unseen, and what is not seen is no evidence.  Set by hand: one frame may be missing, with
#: half a frame for times that jitter; shorter than the second figure is no gap, longer than the third is always one.
#: The second is what a film of 12 frames a second may miss: calls lose pictures for so long, and a forger can choose to
#: send a film with few pictures.
MAX_MISSING_FRAMES, MIN_GAP_S, MAX_GAP_S = 2.5, 2.5 / 12, 0.3
#: The fastest change of speed of a badge's turn, or of the camera's way around it: parallax coordinate per second
#: squared.  Derived: wrists reach some 50 rad/s^2 in quick everyday moves, an arm 3 g (30 m/s^2, the same at 0.5 m).
#: What is faster within one frame, and this many times the usual scatter of poses, is a cut.
MAX_TURN_PER_S2, JUMP_NOISE_SDS = 60.0, 8.0
#: A corner of the badge jumps in the picture from the first figure on, in focal lengths.  Set by hand: 0.6 px in a 720p
#: film.  It may do so by what a hand's jerk, the second figure (focal lengths per s^3), does in the time between
#: frames, of which the third counts at most.  Derived: a hand that goes 20 cm in 0.9 s half a metre away jerks by 33
#: (60 times the way over the cube of the time; Flash and Hogan 1985): 1 px at 30 frames a second, and 17 px at 12.
MAX_PICTURE_JUMP, HAND_JERK_PER_S3, MOST_JERK_S = 0.0005, 40.0, 0.1
#: Derived: beyond half a turn (pi) between two frames the direction is ambiguous; this stays three error bars of an
#: uncertain phase below.
MAX_STEP_RAD = 2.5

# --- How large are the errors of the camera's pose? ------------------------------------------------------------------

#: Prior of the focal length over the picture's longer side, and of its logarithm.  Derived: phones' main cameras film
#: at 0.7 to 0.85 (26 mm equivalent and some crop for stabilisation), webcams at 0.6 to 0.9; a zoom is estimated from
#: any film that shows tilt.  With a wider prior the estimate for a nearly frontal film becomes far too long: the longer
#: the focal length, the more freely tilts fit noise, by up to 30 units of chi-square on ray-traced films at three times
#: the true one.
FOCAL_PRIOR_RATIO, FOCAL_PRIOR_SD_LOG = 0.78, 0.15
#: ... and its bounds.  Source: of 1,110 profiles of phones, 1 % are below 0.37 and 1 % beyond 2.5.
FOCAL_RANGE_RATIO = (0.3, 4.0)
#: A focal length this many standard deviations from its prior is estimated again, on a steady path.  Derived: 95 % of a
#: normal distribution.
FOCAL_FAR_SDS = 2.0
#: Set by hand: a running verdict keeps a focal length once its error, as a share of the motion, is this small.  A kept
#: one has no error bar.  If the badge is held still at first, the focal length is a guess, and with it all later frames
#: would look forged.
FOCAL_KEPT_SHARE = 0.03
#: Prior of the shutter's time from first to last row.  Derived: phone sensors take 5 to 20 ms.  The maximum is set by
#: hand: one frame at 30 a second.
SHUTTER_PRIOR_S, SHUTTER_PRIOR_SD_S, SHUTTER_MAX_S = 0.010, 0.010, 0.033
#: Prior of the place of the optical axis, in long sides of the picture from its middle.  Set by hand: phones centre
#: theirs within a hundredth; a crop or a tile of a call may move it anywhere, and the tails are heavy for that.
AXIS_PRIOR_SD_SHARE, AXIS_MAX_SHARE = 0.007, 0.7
#: Prior of a pixel's width over its height, as a logarithm.  Derived: sensors have square pixels; programs round a
#: picture's width to whole or even pixels, which is 0.05 to 0.1 %, and some stretch it by any amount: heavy tails.
STRETCH_PRIOR_SD_LOG, STRETCH_MAX_LOG = 0.0005, 1.0
#: Prior of the print's aspect (`camera.page_speed`).  Set by hand: printers feed 0.1 to 0.3 % too far or too short,
#: some more, and paper grows 0.1 % more across its fibres than along them when it gets damp.
PRINT_ASPECT_PRIOR_SD_LOG, PRINT_ASPECT_MAX_LOG = 0.002, 0.02
#: Prior of a page's twist, 1/m: a page that is bent to a radius R about an axis at an angle a to its side has
#: sin(2 a) / (2 R).  Set by hand: most pages are flatter than 1.5 m.  Beyond the bound, which is a radius of half a
#: metre, the poses' two solutions can no longer be distinguished, and a twist at it is no solution.
TWIST_PRIOR_SD_PER_M, TWIST_MAX_PER_M, TWIST_AT_LIMIT_SHARE = 0.3, 1.0, 0.97
#: Prior of the radial distortion (`camera.distortion`: a and b, in units of the usual focal length), and its bounds.
#: a is calibrated on 987 lenses of phones (gyroflow's table of lenses): 90 % are between -0.03 and 0.06.
#: b is between -0.4 and 0.4 in 90 %, whose quartiles ask for 0.12; 0.05 is used, by films, as the tails of Student's t
#: reach that far too.  With 0.12, 5 of 200 real lenses (with 0.05: 6) give gains beyond three error bars, but 1 of 198
#: true films of `bench reality` was rejected (with 0.05: 0).  Webcams and action cameras reach an a of -0.7: a k1 of
#: -0.4 at a focal length of 0.6.  What is not estimated makes the fringes' gain wrong: a of 0.1 by 9 %.
DISTORTION_PRIOR_SD, DISTORTION_MAX = (0.02, 0.05), (0.8, 1.0)
#: Error of the spread of the parallax from what two terms leave of a lens's distortion.  Calibrated on real lenses:
#: gyroflow's table of lenses, `moireid lab bench half-real`.
LENS_MODEL_SD_SHARE = 0.002
#: Frequency of a hand's tremor (`camera.page_speed`).  Source: physiological tremor of the hand, 8 to 12 Hz (Elble and
#: Koller, Tremor, 1990).
TREMOR_HZ = 10.0
#: A frame counts as misregistered from this reprojection error on, over the film's median and in pixels.  Derived: by
#: chance, two residuals of a frame exceed ten medians with a probability of 1e-30.
STRAY_MEDIANS_RATIO, STRAY_PX = 10.0, 0.5
#: From here on a frame's pose is taken from its neighbours, but its fringes count.  Derived: by chance, two residuals
#: of a frame exceed six medians with a probability of 1e-11; 0.1 px of a badge 200 px high moves the parallax by 0.03.
DOUBTED_MEDIANS_RATIO, DOUBTED_PX = 6.0, 0.1
#: Smoothing may remove this many times the estimated error of the poses.  Ray-traced films: coded pictures have up to
#: twice that error at 3 m, and a hand moves by less than 1 cm above 3 Hz.
SMOOTHED_ERROR_RATIO = 2.5
#: Share of a frame's pose error that is left after smoothing.  A hand is slow enough to average a dozen frames, but
#: part of the error is common to neighbouring frames. Ray-traced films: 0.4 to 0.6 at 1 to 2 m.
SMOOTHED_SHARE = 0.5
#: The corners of markers smaller than a coding block share its errors, which then do not show in the reprojection
#: error. From this side length on, the error is as estimated; below, it grows with this power of one over the size.
#: Ray-traced films: as estimated at 1 to 2 m, 1.4 to 1.7 times at 3 m (13 px), 2.5 times at 4 m.
SMALL_MARKER_PX, SMALL_MARKER_POWER = 19.0, 1.5
#: What smoothing leaves of the pose error, over what it removes times the residuals' slow part over their fast one
#: (`fast_poses.slow_to_fast`).  Films of `moireid lab bench small-pages`: 1.15 times, with a scatter of a fifth; the
#: estimate from reprojection errors alone is up to 2.6 times too small there.  A coder that saves moves a small square
#: by whole quarters of a pixel, so what turns slowly stays as it was for a while.
SLOW_ERROR_RATIO = 1.15
#: In faint print a codec repeats the same error for many frames, and smoothing does not reduce it.  From this error by
#: rounding on (`strip_phase.rounding_rad`), all of the pose error is of this kind.  Ray-traced films: a print contrast
#: of 5 %, at which the pose error is twice that by `SMOOTHED_SHARE`; at 20 % it is not.
ROUNDING_ONLY_RAD = 0.06

# --- How large are the errors of a fringe's phase? -------------------------------------------------------------------

#: Noise of a strip's samples over that of independent ones.  Derived: two samples per millimetre share 1.4 pixels.
STRIP_NOISE_RATIO = 1.4
#: Print scale (0.5 %) and lens pitch (0.3 %) shift every beat by up to this share of 1 / p_f.  Derived: their sum.
PITCH_TOLERANCE_SHARE = 0.008
#: Least standard deviation of a row's beat frequency.  Set by hand: an error bar from four blocks can be small by
#: chance; this is a millicycle over 100 mm.
MIN_FREQUENCY_SD_PER_MM = 1e-5
#: A frame is partly covered if fringes explain its strip this many times worse than usual, and leave at least this
#: share of their contrast.  Set by hand: noise and codec vary by half; a hand over a tenth of a strip leaves 0.3.
COVERED_MISFIT_RATIO, COVERED_MISFIT_CONTRASTS = 2.0, 0.2
#: A frame's markers are partly covered if page and print correlate by this much less than usual, and by this many
#: standard deviations.  Set by hand: a subtitle over one marker of four takes 0.08 away.
COVERED_CORRELATION, COVERED_CORRELATION_SDS = 0.03, 5.0
#: Places within a strip: frames with a larger error bar of the phase are left out; shifts are averaged over this time
#: (faster patches look like noise to the eye too); blocks with less than this share of the median information are left
#: out, as they lie on a plateau of the fringe. Set by hand; `limits.PARTS` was fitted with them.
PLACE_CLEAR_RAD, PLACE_MEAN_S, PLACE_MIN_INFORMATION_SHARE = 0.3, 0.5, 0.15
#: The gain of one row, or of one place in it, may differ from the badge's by up to this share.  Derived: 0.05 mm of air
#: more beneath the sheet move its fringes so much further; a sheet that is taped and not glued has waves of that size.
UNEVEN_GAIN_SHARE = 0.1
#: A gain of its own of so many times the bound may yet be the work of air, and of so many it is not.  Set by hand:
#: parts of films of builds with all usual flaws have up to 1.3 times.
STILL_AIR, NO_AIR = 1.5, 2.0
#: A map of places is used where it is larger than this, root mean square, and than so many of its standard deviations.
#: Smaller ones neither blur a row's fringes (by 1 part in 800) nor move a symbol.  Set by hand.
MAP_LEAST_RAD, MAP_SDS = 0.05, 3.0
#: Rounds in which a map is estimated; each leaves about a fifth of what is missing.
MAP_ROUNDS = 3

# --- How long may nothing be followed, and how wide are gaps? --------------------------------------------------------

#: A shorter violation by another badge in view does not count.  Set by hand: half a word.
SPELL_S = 1.0
#: For no longer may nothing be followed or searched, as looking may cost only so much (`tracking.search_work`).  Set by
#: hand: twice what a room full of things before a moving camera needs; a chessboard that fills the picture needs more.
MAX_UNSEARCHED_S = 2.0

# --- Which symbol is a cell, and does the cell move? -----------------------------------------------------------------

#: A mount holds the sheet within 0.3 degrees of the lines; derived: the first figure is a little more.  A sheet that
#: is placed by eye may be off by as much as the second.  Set by hand: there a row of 9 mm, read without its margins,
#: loses a quarter of its fringes' contrast.  A twist
#: beyond the first comes before smaller ones only where its rows agree better by the third.  Set by hand: five times
#: what offsets wrong by 0.2 rad take away.
USUAL_TWIST_RAD, MAX_TWIST_RAD, UNUSUAL_TWIST_LESS = math.radians(0.35), math.radians(1.6), 0.1
#: Rows whose mean is less than this share of their size agree at no twist.  Derived: errors of 0.84 rad, and beyond
#: 0.79 rad a cell is taken for its neighbour.
LEAST_AGREEMENT = 0.7
#: So many combinations of twists are tried at most.  Derived: a wrong one yields a payload with a probability of 2e-11
#: at most (`idcodes.words`), and 1e-9 is allowed.
MOST_FIELDS = 40
#: Twists whose agreement of rows is lower by up to this are as likely as the best.  Derived: offsets wrong by 0.2 rad
#: lower it by this (1 - cos 0.2).
DOUBTFUL_AGREEMENT_SHARE = 0.02
#: Noise of a cell's samples over that of independent ones: 1.4 in space, as `STRIP_NOISE_RATIO`, and coded pictures
#: repeat their noise in time.  Ray-traced films: clear symbols scatter by 2 to 4 times as much as independent samples.
CELL_NOISE_RATIO = 3.0
#: Least standard deviation of a reading.  Set by hand: lens pitch and sheet thickness vary that much over a sheet.
CELL_FLOOR_RAD = 0.05
#: Slips of the code's rows are averaged over the first, and the worst time of the second length is looked at by itself.
#: Set by hand: half of what a short forged part lasts, and all of it.
SLIP_MEAN_S, SLIP_WORST_S = 0.4, 1.2
#: Difference between a cell's shape and the learnt one, in contrasts: blur from neighbours, uneven sheets.  It is
#: smooth, so a cell has about this many independent pieces of it.  Set by hand.
SHAPE_ERROR_CONTRASTS, SHAPE_ERROR_PIECES = 0.06, 4
#: Blur of a picture, standard deviation, in its pixels.  Fitted to films of silk badges at 2 and 3 m: what neighbours
#: add to a cell's phase then agrees best with what is measured.  At 3 m 0.055 rad are left; 0.083 at 0.5 pixels, 0.069
#: at 0.9.
PICTURE_BLUR_PX = 0.7
#: Remaining error of offset, twist and beat when a cell is fitted on one of its places.  Set by hand.
SYMBOL_PLACE_SD_RAD = 0.15
#: Standard deviations of a cell's level and contrast from those of the uniform rows: uneven light.  Set by hand.
CELL_LEVEL_SD_CONTRASTS, CELL_CONTRAST_SD_RATIO = 0.15, 0.25
#: Bounds of a cell's level and contrast.  In a film with little motion, a cell shows one plateau of the fringe. With a
#: free level the other plateau, half a turn away, would fit as well, and many samples outweigh any prior.  Set by hand.
CELL_MAX_LEVEL_CONTRASTS, CELL_CONTRAST_RANGE_RATIO = 0.5, (0.4, 1.8)
#: An error bar from a rival symbol counts from here on.  Set by hand.
RIVAL_SD_RAD = 0.3
#: Motion of all cells' fringes together relative to the rows: below the first it is inconclusive, up to the second it
#: fails.  Ray-traced films: genuine ones give 0.96 and more, a still picture of cells 0.  Derived: a third of the cells
#: may be covered.
CELLS_MOVE_RATIO, CELLS_STILL_RATIO = 0.6, 0.4
#: The typical cell may move by so much less than the law, or by so many of its standard deviations, whichever is more.
#: Calibrated: blur and coding mix 1.5 % of each neighbour of another symbol into a cell, so 40 films of 20 badges of A6
#: at 0.6 m (`examples/07_design_to_verdict.py`) give 0.976, with a scatter of 0.0125 from film to film; the first is
#: that less three of these.  Derived: three is 99.7 % of a normal distribution.  Films of an outside tracer, also
#: through calls, at 1 and 2 m: 0.97 to 1.00 where the error bar is below 0.02.  Two photographs that are morphed by
#: optical flow give 0.75 to 0.91.
CELLS_SHORT_RATIO, CELLS_SHORT_SDS = 0.06, 3.0
#: Above this the film is inconclusive: cells change more than their rows do.  Ray-traced films: genuine ones give up to
#: 1.04, cross-faded photographs with rows smoothed by 3 to 5 mm 1.3 to 2.2.
CELLS_MOST_RATIO = 1.25
#: Least mean square of the expected change for this test.  Set by hand.
MIN_CELL_CHANGE_CONTRASTS2 = 0.005

# --- Are the figures those of the badge that was enrolled? -----------------------------------------------------------

#: Office paper grows by up to these shares for 20 % of relative humidity, along and across its fibre.  Source:
#: some 0.1 % in the mean; fibres swell in width far more than in length (Lindner, Factors affecting the hygroexpansion
#: of paper, 2018; Salmen, Fellers and Htun 1985), by half as much again as that and by half as much.  Sheets of A4 and
#: letter are cut with the fibre along their height; so along x, across the fibre, and along y.
PAPER_GROWTH_SHARE = (0.0015, 0.0005)
#: The lens sheet grows with warmth.  Makers' data: PMMA 7.0 to 7.7, PETG 6.8, PET 6 to 7, all times 1e-5 a kelvin.  A
#: badge is enrolled indoors and worn outdoors: 20 K.  Water adds little to PET and PETG in that time.
SHEET_GROWTH_PER_K, WEATHER_K = 7e-5, 20.0
#: Repeatability of the offset under pose, light and codec.  Ray-traced films: 0.04 rad on one badge by different
#: motions.
OFFSET_REPEATS_RAD = 0.05
#: Repeatability of a map of places, root mean square, under motion, light and codec.  Ray-traced films: 0.004 to 0.017.
MAP_REPEATS_RAD = 0.02
#: A film's own error bar gives its map this much room at most, or who makes a film noisy could show any map; films at
#: 2 m have 0.003 to 0.034.
MAP_MOST_SD_RAD = 0.03
#: Standard deviation of the rows' offsets, from which the twist is estimated.  Set by hand.
ROW_OFFSET_SD_RAD = 0.03
#: Rotation of a sheet in its mount between days.  Set by hand: 0.02 mm over 80 mm.
TWIST_REPEATS_RAD = 2.5e-4
#: Limits in standard deviations: figures agree within the first, differ beyond the second, between them not known.
#: Derived: of a normal distribution, 1 in 2,100 true figures is beyond the first, and 2 in a billion beyond the second,
#: as a badge that is called a copy stays so.
AGREES_SDS, DIFFERS_SDS = 3.5, 6.0
#: A stretch has an offset of its own from this length on.  Derived: it holds two independent samples, the fewest that
#: show their scatter (`limits.INDEPENDENT_PER_S`).
LEAST_STRETCH_S = 1.0
#: On a steady path the badge as built speaks for a film if gain and offset agree within this many standard
#: deviations.  Derived: 95 % of a normal distribution; a wider window would let a delay of 0.2 s through on a sweep.
KNOWN_SDS = 2.0

# --- Does the badge pass in front of the face? -----------------------------------------------------------------------

#: Least score of the face detector.  A photograph of a face scores 1.3 to 1.5, its highest false detection 0.23: about
#: the geometric mean.
MIN_FACE_SCORE = 0.5
#: Badge and face overlap if they share this much of the smaller one.  Set by hand: a false border could hide in a
#: smaller overlap.
MIN_OVERLAP_SHARE = 0.25
#: They must overlap for this long without a break.  Set by hand.
MIN_OVERLAP_S = 1.0
#: Share of the readable frames that must agree with the law within three times `residual_limit_rad` (nearly all would
#: for independent errors), and share of the interval's frames that must be readable.  Set by hand.
MIN_AGREEING_SHARE, MIN_READ_SHARE = 0.95, 0.5
