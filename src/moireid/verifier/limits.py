"""Every constant on which accept, reject or inconclusive depends: limits, priors, floors and tolerances.

They are grouped by the question that they answer.  The comment before each says where it comes from:

- *derived*: from optics, statistics or manufacturers' figures; the reason is given;
- *decision set*: the figures of 187 films in `tests/data/decision`, by an outside ray tracer.  `benchmarks/decision.py`
  refits the table `EXPECTED`, and prints how much of each limit genuine films use;
- *ray-traced films*: other films by the same ray tracer.  Most are not kept in this repository, so the figure stands
  only here; six are in `tests/data/films`, and `benchmarks/first_path.py` prints their figures;
- *set by hand*: by judgement alone.

After a change, `benchmarks/film_verdicts.py` prints the verdicts of such films for every camera, codec, motion and
forgery, and `benchmarks/short_lies.py` those of forgeries of a second or two.
Each name ends with its unit: `_SHARE` and `_RATIO` are pure numbers, `_SDS` counts standard deviations, `_LOG10` is a
decadic logarithm.  Other limits stand where they are used: finding pages in `tracking/`, decoding in `moireid.idcodes`,
live prompts in `live/challenge.py`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# --- Is there enough to judge? ---------------------------------------------------------------------------------------

#: Window of the published figure (Qing et al. 2026): the mean of |rho| over windows of 30 frames.
WINDOW_FRAMES = 30
#: Set by hand: fewer frames than two windows are not enough to judge motion.
MIN_FRAMES = 2 * WINDOW_FRAMES
#: Set by hand: a hand's sway takes two or three seconds; a segment should contain one and a half of it.
SEGMENT_S = 4.0
#: Least standard deviation of the predicted phase.  Derived: 0.25 rad is 3.5 cm of sideways sway at 1 m.  Less cannot
#: be separated by five standard deviations from the drifts of light and codec (0.01 to 0.05 rad on ray-traced films).
MIN_EXCITATION_RAD = 0.25
#: ... and as a multiple of the prediction's error.  Derived: three times gives a correlation of 0.95.
MIN_EXCITATION_TO_ERROR_RATIO = 3.0
#: Set by hand: frames with a larger standard deviation of the phase are left out.
MAX_PHASE_SD_RAD = 0.6

#: The verdict must be of this share of the film.  Set by hand: the larger part.
MIN_COVER_SHARE = 0.5

# --- Which frames belong together? -----------------------------------------------------------------------------------

#: A badge that is lost moves unseen, and what is not seen is no evidence.  Set by hand: one frame may be missing, with
#: half a frame for times that jitter; shorter than the second figure is no gap, longer than the third is always one.
#: The second is what a film of 12 frames a second may miss: calls lose pictures for so long, and whoever wants a film
#: with few pictures can send one.
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
#: ... and its bounds.  Set by hand.
FOCAL_RANGE_RATIO = (0.4, 2.5)
#: Set by hand: a focal length this many standard deviations from its prior is estimated again, on a steady path.
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
#: Prior of the print's aspect (`camera.print_aspect`).  Set by hand: printers feed 0.1 to 0.3 % too far or too short,
#: some more, and paper grows 0.1 % more across its fibres than along them when it gets damp.
PRINT_ASPECT_PRIOR_SD_LOG, PRINT_ASPECT_MAX_LOG = 0.002, 0.02
#: Prior of the radial distortion k1 (`camera.distortion`), which has no unit.  Set by hand: most phones correct theirs
#: to 0.02, webcams leave up to 0.1, which is two standard deviations.  If it is not estimated, 0.1 makes the fringes'
#: gain 9 % wrong; a prior for phones alone makes the gain of a webcam's short film wrong by several error bars.
#: Action cameras pull a corner of the picture inwards by 15 %, which is -0.3; but no lens that is sold pushes it
#: outwards by more than 5 %, which is 0.12 at the guessed focal length.
DISTORTION_PRIOR_SD_K1, DISTORTION_RANGE_K1 = 0.05, (-0.3, 0.12)
#: Frequency of a hand's tremor (`camera.page_speed`).  Source: physiological tremor of the hand, 8 to 12 Hz (Elble and
#: Koller, Tremor, 1990).
TREMOR_HZ = 10.0
#: A frame counts as misregistered from this reprojection error on, over the film's median and in pixels.  Derived: by
#: chance, two residuals of a frame exceed ten medians with a probability of 1e-30.
STRAY_MEDIANS_RATIO, STRAY_PX = 10.0, 0.5
#: From here on a frame's pose is taken from its neighbours, but its fringes count.  Derived: by chance, two residuals
#: of a frame exceed six medians with a probability of 1e-11; 0.1 px of a badge 200 px high moves the parallax by 0.03.
DOUBTED_MEDIANS_RATIO, DOUBTED_PX = 6.0, 0.1
#: What one camera may leave of the corners over many frames, px.  Films of this project's own simulator: up to 0.027
#: where a badge turns, as registration errs alike at one turn; 0.04 to 0.2 in most that are zoomed or reframed.
MAX_LASTING_PX = 0.03
#: From here on the camera is doubted where the gain is open too.  Set by hand: a third of that.
SUSPECT_PX = 0.01
#: The most by which a picture is zoomed within a film.  Set by hand; parallaxes are wrong by that factor at most.
MOST_ZOOM = 2.0
#: A stretch whose predicted phase spreads by less than this shows a badge at rest, which says nothing, as a print could
#: lie there.  Set by hand: as `RESIDUAL_FLOOR_RAD`, what light and codec explain.
REST_RAD = 0.05
#: At most this share of the frames may be left out as outliers, as nobody knows what they show.  Set by hand.
MAX_STRAY_SHARE = 0.05
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
#: (`one_camera.slow_to_fast`).  Films of `benchmarks/small_pages.py`: 1.15 times, with a scatter of a fifth; the
#: estimate from reprojection errors alone is up to 2.6 times too small there.  A coder that saves moves a small square
#: by whole quarters of a pixel, so what turns slowly stays as it was for a while.
SLOW_ERROR_RATIO = 1.15
#: With markers below the first figure both may still be too small: in most of 24 films of `benchmarks/small_pages.py`
#: by 1.4 at most, in two by 2.1 and 2.6.  Motion that would not be enough with errors larger by the second figure
#: proves nothing against a film; and an unlikely film is rejected only if it is so with errors larger by the third.
DOUBTED_MARKER_PX, SMALL_MARKER_DOUBT_RATIO, SMALL_MARKER_WORST_RATIO = 24.0, 1.6, 2.6
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
#: A strip is partly covered if its error bar is this many times that of the clearest strip.  Set by hand.
MAX_VAGUENESS_RATIO = 3.0
#: A frame is partly covered if fringes explain its strip this many times worse than usual, and leave at least this
#: share of their contrast.  Set by hand: noise and codec vary by half; a hand over a tenth of a strip leaves 0.3.
COVERED_MISFIT_RATIO, COVERED_MISFIT_CONTRASTS = 2.0, 0.2
#: A frame's markers are partly covered if page and print correlate by this much less than usual, and by this many
#: standard deviations.  Set by hand: a subtitle over one marker of four takes 0.08 away.
COVERED_CORRELATION, COVERED_CORRELATION_SDS = 0.03, 5.0
#: At most this share of rows and frames may be covered.  Set by hand: the larger part must be seen.
MAX_COVERED_SHARE = 0.5
#: A hand is told of where it covers a marker in this share of the frames.  Set by hand: in fewer it may be smeared.
MIN_HELD_SHARE = 0.05
#: Places within a strip: frames with a larger error bar of the phase are left out; shifts are averaged over this time
#: (faster patches look like noise to the eye too); blocks with less than this share of the median information are left
#: out, as they lie on a plateau of the fringe. Set by hand; `EXPECTED["places"]` was fitted with them.
PLACE_CLEAR_RAD, PLACE_MEAN_S, PLACE_MIN_INFORMATION_SHARE = 0.3, 0.5, 0.15

#: How far contrast may dip with motion (`fringes.mixed_frames`).  Derived: an exposure that lasts all frame long.
#: Below its regression by so many standard deviations: 99.7 % of a normal distribution.
MAX_MIXED_SHARE, MIXED_SDS = 1 / 12, 3.0

# --- Which deviations from the law occur on a genuine badge? ---------------------------------------------------------

#: Codecs show faint fringes late: a block that changes little is copied from the last frame along the badge's motion,
#: and so keeps the old phase.  Derived: the maximum is one frame at 30 a second.  Ray-traced films: 0 to 15 ms, and 26
#: ms in one at 50 degrees, which has no lag with a finer quantiser.
MAX_LAG_S = 0.05
#: Set by hand: the shortest lie of another badge in view that counts, half a word.
SPELL_S = 1.0
#: For no longer may nothing be followed or searched, as looking may cost only so much (`tracking.search_work`).  Set by
#: hand: twice what a room full of things before a moving camera needs; a chessboard that fills the picture needs more.
MAX_UNSEARCHED_S = 2.0
# --- Do the fringes follow the law?  Wide limits, as every genuine film must pass each of them -----------------------

#: Allowed deviation of the gain from 1.  Derived: thickness and index of commercial sheets vary by about 10 %, the
#: estimated focal length by up to 5 %, pitch by 1 %.
GAIN_TOLERANCE_SHARE = 0.15
#: ... plus this many of its error bars before it is rejected.  Derived: 99.7 % of a normal distribution.
GAIN_REJECTED_SDS = 3.0
#: From this share of the gain on, an error bar is too wide to accept.  Derived: fringes at 1.9 times the true gain
#: would be accepted with a probability of 1 % (ln(1.15 / 1.9) is 2.33 times 0.215).
MAX_GAIN_SD_SHARE = 0.215
#: A badge that is known as built: its gain is accepted within the first, or within so many error bars of film
#: and enrolment together where that is more, and never beyond `GAIN_TOLERANCE_SHARE`.  Derived: focus moves the focal
#: length by up to 2 % unseen; 20 K and wet air change thickness and index of a sheet by 0.5 %, 5 um of air another 1 to
#: 2 %.  At 1 m an error bar is 0.03, so that a gain 7 % off is not accepted; of true ones 82 % lie within four thirds
#: of a bar.
BUILT_GAIN_ROOM_SHARE, BUILT_GAIN_SDS = 0.04, 4 / 3
#: Gains that can be enrolled.  Set by hand: wider than all sheets of `moireid.sheets` but the extreme ones, and finite.
ENROLLED_GAINS = (0.5, 1.6)
#: Films of one enrolment whose gains differ by more than this many of their standard deviations, and by more than the
#: room above, are of different sheets, or one of them is wrong.  Derived: 99.7 % of a normal distribution.
GAINS_AGREE_SDS = 3.0
#: A residual is explained by this floor (light and codec), by this share of the motion (the law is traced for the
#: nominal sheet), and by this many times the error of pose and phase.  Set by hand, from films of `bench natural` and
#: `bench reality`: honest ones leave 0.3 to 1.2 times that error.
RESIDUAL_FLOOR_RAD, RESIDUAL_MOTION_SHARE, EXPLAINED_SDS = 0.015, 0.01, 2.0
#: A film that could be honest with a residual this many times larger is inconclusive and not rejected.  Ray-traced
#: films: far away, where markers are a few pixels, poses err by up to 2.5 times their estimate.
POSSIBLE_RESIDUAL_RATIO = 2.0
#: Strips of a genuine badge share the camera's pose, so they move together within their noise.  Decision set: 0.030 rad
#: at most on genuine films.  Patches that move independently show 0.15 and more.
MAX_STRIP_WANDER_RAD = 0.1
#: Spacing of the fringes against distance (`motion.spacing`): a film whose gain differs from a badge's by more
#: than the first is inconclusive.  Derived: half of the way to a table of photographs, whose gain is 0.  Error bars
#: beyond the second: 99.7 % of a normal distribution.
MAX_SPACING_ERROR_RATIO, PHOTOGRAPH_SDS = 0.5, 3.0
#: Errors along a strip that last all film long, root mean square.  Set by hand: 0.003 px where a fringe is
#: 19 px, as at 2 m; films of two renderers, coded by H.264, show 0.0002 to 0.0015.
SPACING_FLOOR_RAD = 0.001
#: A waveform that changes with parallax within this many radians of phase ripples; at most so much of it, in contrasts,
#: is a badge's.  Set by hand: three outside films show 0.0020 to 0.0021, those of this project up to 0.0016.
RIPPLE_STEP_RAD, MAX_RIPPLE_CONTRASTS = 0.08, 0.004
#: A film is inconclusive if what turns with the fringes, of the third harmonic, is not by so many contrasts more than
#: what stands still (`motion.turning`).  Derived: a third of what two gratings of lines have, 1/9.  Twelve films of
#: photographs laid over each other show 0.002 at most; true ones, of two outside renderers and ours, 0.09 to 0.29.
MIN_OVERTONE_CONTRASTS = 0.035
#: A pattern that stands still on the badge may be so much of that.  Set by hand: twice what dots of 600 dpi make in the
#: finest lines.
MAX_STILL_SHARE = 0.3
#: Share of a cross-fade's ripple that is left in a film, as coding and blending in coded brightness take some away.
#: Films of this project: 0.26 to 0.74; the count of photographs rests on the low end.
RIPPLE_LEFT_SHARE = 0.33
#: A film is inconclusive if its waveform surely changes by more than this share of what two to four cross-faded
#: photographs make (`motion.cross_fade`).  Set by hand: 38 true films of this project and three outside ones show -0.02
#: at most, films of two or three such photographs 0.27 and more.
MAX_CROSS_FADE_SHARE = 0.2
#: By how much a badge's own waveform may change with the place in that form.  Set by hand: those films show 2 %.
UNEVEN_SHARE = 0.02
#: A gap between neighbouring views of the fringes counts as unseen from this share of the mean difference between two
#: views on (`fringes.seen_way`).  Derived: fewer than 12 photographs at even distances.
MAX_VIEW_GAP_SHARE = 0.25
#: A film is inconclusive if more than this share of the fringes' way lies in such gaps.  Set by hand: the larger part.
MAX_UNSEEN_WAY_SHARE = 0.5

# --- How much likelier is the film with a genuine badge than with a forged one? --------------------------------------

#: Forged deviations: every octave between these shares of the motion is equally likely.  Set by hand.
FORGED_MIN_SHARE, FORGED_MAX_SHARE = 0.1, 3.0
#: The law is traced for a flat, even, nominal sheet; a genuine badge deviates from it by this share.  Set by hand.
LAW_MOTION_SHARE = 0.02


@dataclass(frozen=True)
class Expected:
    """One figure on genuine badges: mean and standard deviation of the logarithm of figure over unit.

    The unit is the root of the sum of squares of `error_share` times the expected error of a frame, `floor_rad`, and
    `motion_share` times the motion.  strip_sd_share times a strip's error bar, and rounding_share times the error
    by rounding, replace the floor if they exceed it.
    """

    error_share: float
    floor_rad: float
    mean_log: float
    sd_log: float
    strip_sd_share: float = 0.0
    rounding_share: float = 0.0
    motion_share: float = LAW_MOTION_SHARE


#: Means and standard deviations of honest films, by `benchmarks/priors.py`.  No standard deviation is below 0.35, set
#: by hand: cameras and sheets vary more than in one collection.  Strips share the pose, so its error does not enter
#: their figures, nor those of places.  In faint print, strips deviate by half of their error bars and more on
#: ray-traced films, and so does a twelfth of a strip over half a second.  Errors that a codec repeats are not averaged:
#: places have all of them, and strips, of a few coding blocks each, half.
EXPECTED: dict[str, Expected] = {
    "wander": Expected(1.0, 0.010, -0.55, 0.40, motion_share=0.01),
    "rows": Expected(0.0, 0.010, -0.15, 0.35, strip_sd_share=0.7, rounding_share=0.5),
    "places": Expected(0.0, 0.020, -0.05, 0.35, strip_sd_share=0.7, rounding_share=1.0),
}

# --- Which symbol is a cell, and does the cell move? -----------------------------------------------------------------

#: A mount holds the sheet within 0.3 degrees of the lines; derived: the first figure is a little more.  Whoever lays a
#: sheet by eye may be off by as much as the second.  Set by hand: there a row of 9 mm, read without its margins, loses
#: a quarter of its fringes' contrast.  At a twist beyond the first the rows must agree better by the third.  Set by
#: hand: five times what offsets wrong by 0.2 rad take away.
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
#: Difference between a cell's shape and the learnt one, in contrasts: blur from neighbours, uneven sheets.  It is
#: smooth, so a cell has about this many independent pieces of it.  Set by hand.
SHAPE_ERROR_CONTRASTS, SHAPE_ERROR_PIECES = 0.06, 4
#: Remaining error of offset, twist and beat when a cell is fitted on one of its places.  Set by hand.
SYMBOL_PLACE_SD_RAD = 0.15
#: Standard deviations of a cell's level and contrast from those of the uniform rows: uneven light.  Set by hand.
CELL_LEVEL_SD_CONTRASTS, CELL_CONTRAST_SD_RATIO = 0.15, 0.25
#: Bounds of a cell's level and contrast.  In a film with little motion, a cell shows one plateau of the fringe. With a
#: free level the other plateau, half a turn away, would fit as well, and many samples outweigh any prior.  Set by hand.
CELL_MAX_LEVEL_CONTRASTS, CELL_CONTRAST_RANGE_RATIO = 0.5, (0.4, 1.8)
#: An error bar from a rival symbol counts from here on.  Set by hand.
RIVAL_SD_RAD = 0.3
#: Motion of the cells' fringes relative to the rows: from the first on it passes, up to the second it fails.
#: Ray-traced films: genuine ones give 0.96 and more, a still picture of cells 0.  Derived: a third of the cells may be
#: covered.
CELLS_MOVE_RATIO, CELLS_STAND_RATIO = 0.6, 0.4
#: Above this the film is inconclusive: cells change more than their rows do.  Ray-traced films: genuine ones give up to
#: 1.04, cross-faded photographs with rows smoothed by 3 to 5 mm 1.3 to 2.2.
CELLS_MOST_RATIO = 1.25
#: Least mean square of the expected change for this test.  Set by hand.
MIN_CELL_CHANGE_CONTRASTS2 = 0.005

# --- Is it the badge that was enrolled, or a copy? -------------------------------------------------------------------

#: Office paper grows by up to these shares for 20 % of relative humidity, along and across its fibre.  Set by hand:
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
#: Standard deviation of the rows' offsets, from which the twist is estimated.  Set by hand.
ROW_OFFSET_SD_RAD = 0.03
#: Rotation of a sheet in its mount between days.  Set by hand: 0.02 mm over 80 mm.
TWIST_REPEATS_RAD = 2.5e-4
#: Independent samples per second of a hand-held film.  Set by hand: motion is smooth.
INDEPENDENT_PER_S = 2.0
#: Limits in standard deviations: original within the first, a copy beyond the second, between them not known.  Set by
#: hand.
ORIGINAL_SDS, COPY_SDS = 3.5, 6.0
#: A stretch has an offset of its own from this length on.  Set by hand: a second holds two independent samples.
LEAST_STRETCH_S = 1.0
#: On a steady course the badge as built speaks for a film if gain and offset agree within this many standard
#: deviations.  Derived: 95 % of a normal distribution; a wider window would let a delay of 0.2 s through on a sweep.
KNOWN_SDS = 2.0

# --- Does the badge pass in front of the face? -----------------------------------------------------------------------

#: Least score of the face detector.  Set by hand: a photograph of a face scores 1.3 to 1.5, its highest false detection
#: 0.23.
MIN_FACE_SCORE = 0.5
#: Badge and face overlap if they share this much of the smaller one.  Set by hand: a false border could hide in a
#: smaller overlap.
MIN_OVERLAP_SHARE = 0.25
#: They must overlap for this long without a break.  Set by hand.
MIN_OVERLAP_S = 1.0
#: Share of the readable frames that must agree with the law within `EXPLAINED_SDS` (99.7 % would for independent
#: errors), and share of the interval's frames that must be readable.  Set by hand.
MIN_AGREEING_SHARE, MIN_READ_SHARE = 0.95, 0.5

# --- Explanations of one film ----------------------------------------------------------------------------------------

#: Blocks of one film that explanations are compared on, at most.  Derived: up to a minute at 10 blocks a second, of
#: which the shortest delay that is told from the law takes two.
MOST_BLOCKS = 600
#: Below this a frame's error bar makes it no weightier, rad.  Set by hand: light and codec vary by as much.
LEAST_SCALE_RAD = 0.01
#: What an honest camera, badge and codec may add to the law (`explanations.honest`).  Lag: one frame and a half at 30 a
#: second; a time stamp may be early by a third of a frame.  Shape: as `RESIDUAL_MOTION_SHARE`.  Zoom: focus moves the
#: focal length by 1 to 2 %.  Axis: a logged phone's stabiliser moves it by 3 px of 1450, times 7.3 rad of phase.
MAX_LEAD_S = 0.01
MAX_SHAPE_SHARE, MAX_ZOOM_DRIFT_SHARE, MAX_AXIS_DRIFT_RAD = 0.03, 0.02, 0.015
#: Error of a block that no explanation models, rad.  Set by hand.
UNMODELLED_RAD = 0.006
#: A residual holds at least so many independent samples.  Set by hand: a shorter film is not judged.
LEAST_SAMPLES = 4.0
#: Priors of rivals: ratio to the best-fitting one, delays, and the time over which a motion of its own is smooth.  An
#: honest codec's lag ends at `MAX_LAG_S`, and a generator that lags by more than 2 s shows another motion.
FORGED_GAINS, LATE_RANGE_S, OWN_MOTION_S = (-2.0, 3.0), (0.2, 2.0), (0.5, 3.0)
#: Delays that are fitted, s.
DELAYS_S = (0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0)
#: Forgeries drawn of each rival.  Derived: a share of 2 in 100 is then known to 1 in 100.
DRAWS = 200
#: A film is not accepted if a rival fits it better by more than this power of ten, or would look as law-like as it does
#: in more than this share of cases.  Set by hand: a factor of ten; 2 in 100 held on all films tried.
MAX_RIVAL_LOG10, MAX_RIVAL_SHARE = 1.0, 0.02
#: A film is rejected if the law cannot explain it and a rival is better by this power of ten.  Set by hand.
REJECTED_LOG10 = 3.0
#: What a picture that was zoomed, reframed or mixed may leave of the motion, as a share.  Derived: a zoom by up to two
#: that goes with the motion leaves a correlation of 0.95 (Cauchy and Schwarz), which is a residual of a third.
CAMERA_MOTION_SHARE = 0.33
#: Calibration of scores (`decision.calibration`), by `benchmarks/priors.py`; the cap is the logarithm of the number of
#: films in that set.
CALIBRATION_SLOPE, CALIBRATION_OFFSET_LOG10, CALIBRATION_CAP_LOG10 = 0.3, 0.0, 2.5
#: A forgery gets this share of the film's own residual, in blocks of so many seconds, and looks like the film if its
#: residual is at most so many times as large.  Set by hand: a forger's film has less error than one that was filmed.
RESAMPLED_SHARE, RESAMPLED_S, ALIKE_RATIO = 0.7, 0.5, 1.15
#: Windows in which the fringes may leave the law, s, and the law's motion in a window, rad.
SPELLS_S, MIN_SPELL_MOTION_RAD = (0.3, 0.5, 0.8, 1.5, 3.0), 0.2
#: The gain of the fringes there, and by how many powers of ten less likely that is beforehand.  Set by hand: a poor
#: pose looks like half or twice the motion far more often than like none.
SPELL_GAINS = {0.0: 0.5, -1.0: 0.5, 0.5: 2.0, 2.0: 2.0}
#: Degrees of freedom of the slips' distribution, and the least slip of a block, rad.  Set by hand: outliers of poses.
SPELL_FREEDOM, LEAST_SLIP_RAD = 6.0, 0.004
