"""Every constant on which accept, reject or inconclusive depends: limits, priors, floors and tolerances.

They are grouped by the question that they answer.  The comment before each says where it comes from:

- *derived*: from optics, statistics or the makers' figures; the reason is given;
- *decision set*: the figures of 187 films in `tests/data/decision`, of a ray tracer that is independent of this
  project.  `benchmarks/decision.py` refits the table `EXPECTED`, and prints how much of each limit true films use;
- *ray-traced films*: other films of the same ray tracer.  Most are not kept in this repository, so the figure stands
  here alone; six are in `tests/data/films`, and `benchmarks/first_path.py` prints what they give;
- *set by hand*: nothing but judgement is behind it.

Where such a film's verdict could change, `benchmarks/film_verdicts.py` prints it for every camera, codec, motion and
forgery, and `benchmarks/short_lies.py` for forgeries of a second or two.

Units end each name: `_SHARE` and `_RATIO` are pure numbers, `_SDS` counts standard deviations, `_LOG10` is a decadic
logarithm.  How pages are found is decided in `tracking/`, how symbols become a word in `moireid.idcodes`, what a live
prompt asks for in `live/challenge.py`; their limits stand there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# --- Is there enough to judge? ---------------------------------------------------------------------------------------

#: Window of the published figure (Qing et al. 2026): the mean of |rho| over windows of 30 frames.
WINDOW_FRAMES = 30
#: Set by hand: fewer frames than two windows say nothing about motion.
MIN_FRAMES = 2 * WINDOW_FRAMES
#: Set by hand: a hand's sway takes two or three seconds; a segment should hold one and a half of it.
SEGMENT_S = 4.0
#: Least standard deviation of the predicted phase.  Derived: 0.25 rad is 3.5 cm of sideways sway at 1 m.  Less is not
#: told from the drifts of light and codec (0.01 to 0.05 rad on ray-traced films) with five standard deviations to
#: spare.
MIN_EXCITATION_RAD = 0.25
#: ... and over the prediction's own error.  Derived: three times leaves a correlation of 0.95.
MIN_EXCITATION_TO_ERROR_RATIO = 3.0
#: Set by hand: frames whose phase is vaguer tell nothing and are left out.
MAX_PHASE_SD_RAD = 0.6

# --- Which frames belong together? -----------------------------------------------------------------------------------

#: A badge that is lost moves unseen, and what is not seen is no evidence.  Set by hand: one frame may be missing, with
#: half a frame for times that jitter; what is shorter than the second figure is no gap, what is longer than the third
#: is one.
MAX_MISSING_FRAMES, MIN_GAP_S, MAX_GAP_S = 2.5, 0.05, 0.3
#: The most that a hand speeds a badge's turn, or the camera's way around it, up: parallax coordinate a second squared.
#: Derived: wrists reach some 50 rad/s^2 in quick everyday moves, an arm 3 g (30 m/s^2, at 0.5 m as much again).  What
#: is quicker within one frame, and so many times the usual scatter of poses, is a cut.
MAX_TURN_PER_S2, JUMP_NOISE_SDS = 60.0, 8.0
#: Derived: beyond half a turn between two frames (pi) nobody can tell which way it went; three error bars of a vague
#: phase are kept off.
MAX_STEP_RAD = 2.5

# --- How large are the errors of the camera's pose? ------------------------------------------------------------------

#: Prior of the focal length over the picture's longer side, and of its logarithm.  Derived: phones' main cameras film
#: at 0.7 to 0.85 (26 mm equivalent and some crop for stabilisation), webcams at 0.6 to 0.9; any film that shows tilt
#: tells a zoom.  A wider prior lets a nearly frontal film run away: the longer the focal length, the freer are its
#: tilts to fit noise, by up to 30 units of chi-square on ray-traced films at three times the true one.
FOCAL_PRIOR_RATIO, FOCAL_PRIOR_SD_LOG = 0.78, 0.15
#: ... and the ends between which it may lie.  Set by hand.
FOCAL_RANGE_RATIO = (0.4, 2.5)
#: Set by hand: from so many standard deviations of its prior on, a focal length is solved for again, on a steady
#: course.
FOCAL_FAR_SDS = 2.0
#: Set by hand: a running verdict keeps a focal length once it errs by so little, as a share of the motion.  A kept one
#: has no error bar, and that of a badge that was held still at first is a guess, by which all that follows would look
#: forged.
FOCAL_KEPT_SHARE = 0.03
#: Prior of the shutter's run from first to last row.  Derived: phone sensors take 5 to 20 ms.  The most
#: is set by hand, a frame at 30 a second.
SHUTTER_PRIOR_S, SHUTTER_PRIOR_SD_S, SHUTTER_MAX_S = 0.010, 0.010, 0.033
#: Prior of the radial distortion k1 (`camera.distortion`), which has no unit.  Derived: most phones correct theirs to
#: 0.02, some webcams leave 0.1; and 0.1 makes the fringes' gain 9 % wrong if it is not solved for.
DISTORTION_PRIOR_SD_K1, DISTORTION_MAX_K1 = 0.02, 0.3
#: A frame's reprojection error over the film's median, and in pixels, from which on it was misregistered.  Derived: two
#: residuals a frame exceed ten medians by chance with 1e-30.
STRAY_MEDIANS_RATIO, STRAY_PX = 10.0, 0.5
#: Smoothing may take away this many times the error that the poses are known to have.  Ray-traced films: coded pictures
#: err by up to twice of it at 3 m, and a hand moves by less than 1 cm above 3 Hz.
SMOOTHED_ERROR_RATIO = 2.5
#: Share of a frame's pose error that smoothing leaves.  A hand's motion lets a dozen frames be averaged, but part of
#: the error is common to neighbouring frames.  Ray-traced films: 0.4 to 0.6 at 1 to 2 m.
SMOOTHED_SHARE = 0.5
#: Markers smaller than a coding block share its errors, which then do not show in what a pose leaves unexplained: from
#: this side on an error is as estimated, below it grows by this power of the size.  Ray-traced films: as estimated at 1
#: to 2 m, 1.4 to 1.7 times at 3 m (13 px), 2.5 times at 4 m.
SMALL_MARKER_PX, SMALL_MARKER_POWER = 19.0, 1.5
#: Faint print errs by what a codec holds for many frames, and smoothing takes nothing of that away.  Where rounding
#: alone strays by so much (`strip_phase.rounding_rad`), all of the error is such.  Ray-traced films: a print contrast
#: of 5 %, at which poses err by twice what `SMOOTHED_SHARE` makes of them; at 20 % they do not.
ROUNDING_ONLY_RAD = 0.06

# --- How large are the errors of a fringe's phase? -------------------------------------------------------------------

#: Noise of a strip's samples over that of independent ones.  Derived: two samples a millimetre share 1.4 pixels.
STRIP_NOISE_RATIO = 1.4
#: Print scale (0.5 %) and lens pitch (0.3 %) shift every beat by up to this share of 1 / p_f.  Derived: their sum.
PITCH_TOLERANCE_SHARE = 0.008
#: Least standard deviation of a row's beat frequency.  Set by hand: an error bar from four blocks can come out small by
#: luck; this is a millicycle over 100 mm.
MIN_FREQUENCY_SD_PER_MM = 1e-5
#: A strip whose phase is so many times vaguer than the clearest one's is covered in part.  Set by hand.
MAX_VAGUENESS_RATIO = 3.0
#: A frame whose strip is this many times worse explained by fringes than usual, and by this share of their contrast, is
#: covered in part.  Set by hand: noise and codec vary by half, and a hand over a tenth of a strip leaves 0.3.
COVERED_MISFIT_RATIO, COVERED_MISFIT_CONTRASTS = 2.0, 0.2
#: A frame whose page correlates with its print by so much less than usual, and by so many standard deviations, has its
#: markers covered in part.  Set by hand: a subtitle over one marker of four takes 0.08 away.
COVERED_CORRELATION, COVERED_CORRELATION_SDS = 0.03, 5.0
#: More of the rows and frames than this must not be covered.  Set by hand: what is seen must be the larger part.
MAX_COVERED_SHARE = 0.5
#: Places within a strip: frames of vaguer phase are left out, shifts are averaged over so long (patches that change
#: faster are noise to the eye too), and blocks of less than this share of the median information are left out, as they
#: lie on a plateau of the fringe.  Set by hand; `EXPECTED["places"]` was fitted with them.
PLACE_CLEAR_RAD, PLACE_MEAN_S, PLACE_MIN_INFORMATION_SHARE = 0.3, 0.5, 0.15

# --- What strays from the law, and what may a true badge's fringes do? -----------------------------------------------

#: A bent sheet, light from one side and a pose that errs with the tilt stray in step with the camera's place; no more
#: than this share of the motion is put down to that.  Set by hand: about 3 % each.
MAX_PLACE_SHARE = 0.05
#: Codecs show faint fringes late: a block that changes little is taken from the frame before, with the badge's motion
#: and so with the fringes' old phase.  Derived: a frame at 30 a second is the most.  Ray-traced films: 0 to 15 ms, and
#: 26 ms in one at 50 degrees, which has none at a finer quantiser.
MAX_LAG_S = 1 / 30
#: A wander is told from the jitter of poses by this mean over time.  Derived: it leaves what is slower than 0.5 Hz.
WANDER_MEAN_S = 0.25
#: The shortest lie that is looked for by itself.  Set by hand: half a word; a mean over the film would thin it out.
SPELL_S = 1.0
#: A spell must hold this share of a middling one's frames.  Set by hand: fewer are a gap's edge, and tell little.
MIN_SPELL_FRAMES_SHARE = 0.6

# --- Do the fringes follow the law?  Wide limits, each of which must hold on every true film -------------------------

#: Published renderings reach 0.99; ray-traced hand-held films at 1 to 2 m 0.997 and more.  Derived: pose noise at the
#: least excitation allowed leaves 0.97.
MIN_CORRELATION = 0.95
#: A gain may be off from 1 by so much.  Derived: thickness and index of sheets as sold vary by about 10 %, the solved
#: focal length errs by up to 5 %, pitch by 1 %.
GAIN_TOLERANCE_SHARE = 0.15
#: ... and by so many of its error bars more before it is rejected.  Derived: 99.7 % of a normal distribution.
GAIN_REJECTED_SDS = 3.0
#: From this share of the gain on, an error bar is too wide to accept on.  Derived: fringes at 1.9 times the true gain
#: would be taken for true ones with a chance of 1 % (ln(1.15 / 1.9) is 2.33 times 0.215).
MAX_GAIN_SD_SHARE = 0.215
#: A residual is explained by this floor (light and codec, as `MIN_EXCITATION_RAD`), by this share of the motion (a law
#: traced for the sheet as sold), and by so many times the error of pose and phase.  Decision set: no true film uses
#: half of that.
RESIDUAL_FLOOR_RAD, RESIDUAL_MOTION_SHARE = 0.05, 0.03
EXPLAINED_SDS = 3.0
#: Far away, where markers are a few pixels, poses err by more than estimated, since coded pictures err alike in
#: neighbouring frames.  A film that could be true with errors so many times larger is left open, and not rejected: the
#: first figure for the correlation, the second for what is left without what goes with the camera's place.  Ray-traced
#: films: 2.5 at 4 m; 1.4 at 1 to 2 m.
POSSIBLE_ERROR_RATIO, POSSIBLE_RESIDUAL_RATIO = 2.5, 1.5
#: Strips of one true badge share the camera's pose, so they move together within their noise.  Decision set: 0.030 rad
#: at most on true films.  Patches on clocks of their own show 0.15 and more.
MAX_STRIP_WANDER_RAD = 0.1
#: A film is left open whose course lets fringes pass that merely drift, or come late, in more than this share of cases
#: (`motion.steady_course`).  Set by hand, as are the delays: less than 0.2 s is hardly seen even where a hand moves to
#: and fro, and a generator that lags by more than a second shows another motion.
MAX_UNSEEN_CHANCE = 0.01
DELAYS_S = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)

# --- How much likelier is the film of a true badge than of a forged one? ---------------------------------------------

#: Standard deviation of a true badge's gain.  Derived: half of `GAIN_TOLERANCE_SHARE`, which sheets as sold scatter by.
GAIN_SD_RATIO = 0.075
#: Forged gains: every ratio between these alike.  Set by hand.
FORGED_GAIN_MIN_RATIO, FORGED_GAIN_MAX_RATIO = -2.0, 3.0
#: Forged strays: every octave between these shares of the motion alike.  Set by hand.
FORGED_MIN_SHARE, FORGED_MAX_SHARE = 0.1, 3.0
#: The law is traced for the sheet as sold, flat and even; a true badge strays from it by this share.  Set by hand.
LAW_MOTION_SHARE = 0.02
#: Set by hand: more certainty than this no model deserves.
MAX_CERTAINTY_LOG10 = 20.0
#: Verdicts by the ratio: 6.3 times likelier true than forged is accepted, ten times likelier forged is rejected.
#: Derived: a film that cannot tell one kind of the six at all has a ratio of 6 at most, and is left open.
ACCEPTED_LOG10, REJECTED_LOG10 = 0.8, -1.0


@dataclass(frozen=True)
class Expected:
    """What true badges show of one figure: mean and standard deviation of its logarithm over its unit.

    The unit is made, in squares, of `error_share` of the error that is expected of a frame, `floor_rad`, and
    `LAW_MOTION_SHARE` of the motion.  strip_sd_share: of a strip's own error bar, rounding_share: of what rounding
    makes of a place; they replace the floor where they exceed it.
    """

    error_share: float
    floor_rad: float
    mean_log: float
    sd_log: float
    strip_sd_share: float = 0.0
    rounding_share: float = 0.0


#: Means and spreads: fitted on one half of the true films of the decision set by `benchmarks/decision.py`, and
#: rounded; its figures were measured anew since, and a refit prints means within 0.06 of these and spreads of 0.01
#: more at most. No spread is below 0.35, set by hand: cameras and sheets differ by more than those of one collection.
#: Shares and floors are derived.  Smoothed poses leave white errors up to 3 Hz, of which a figure below 0.5 Hz sees
#: 0.45.  Strips share the pose, so neither they nor places within them know of its error.  Pale fringes make strips
#: vague: they wander by half of their error bars and more on ray-traced films, and a twelfth of a strip over half a
#: second is as vague.  What a codec holds of faint fringes is not so averaged: places err by all of it, and strips, of
#: a few coding blocks each, by half.
EXPECTED: dict[str, Expected] = {
    "wander": Expected(0.45, 0.010, -0.85, 0.55),
    "jitter": Expected(1.0, 0.015, -0.45, 0.35),
    "spell": Expected(1.0, 0.015, -0.08, 0.35),
    "strips": Expected(0.0, 0.010, -0.15, 0.35, strip_sd_share=0.7, rounding_share=0.5),
    "places": Expected(0.0, 0.020, -0.05, 0.35, strip_sd_share=0.7, rounding_share=1.0),
}

# --- Which symbol is a cell, and does the cell move? -----------------------------------------------------------------

#: Sheets are laid within 0.3 degrees of the lines, which is asked of the maker.  Derived: a little more.
MAX_TWIST_RAD = math.radians(0.35)
#: Twists whose rows agree less well by this are as likely as the best.  Derived: offsets that are wrong by 0.2 rad
#: make so much (1 - cos 0.2).
DOUBTFUL_AGREEMENT_SHARE = 0.02
#: Noise of a cell's samples over that of independent ones: 1.4 in space, as `STRIP_NOISE_RATIO`, and coded pictures
#: repeat their noise in time.  Ray-traced films: clear symbols scatter by 2 to 4 times what independent samples would.
CELL_NOISE_RATIO = 3.0
#: A reading is never better than this.  Set by hand: lens pitch and sheet thickness vary that much over a sheet.
CELL_FLOOR_RAD = 0.05
#: The shape that was learnt is not a cell's own within this, in contrasts: blur from its neighbours, uneven sheets.
#: The difference is smooth, so a cell holds about so many independent pieces of it.  Set by hand.
SHAPE_ERROR_CONTRASTS, SHAPE_ERROR_PIECES = 0.06, 4
#: What is left of offset, tilt and beat when a cell is put on one of its places.  Set by hand.
SYMBOL_PLACE_SD_RAD = 0.15
#: A cell's level and contrast are those of the uniform rows within these, in contrasts: uneven light.  Set by hand.
CELL_LEVEL_SD_CONTRASTS, CELL_CONTRAST_SD_RATIO = 0.15, 0.25
#: No cell lies beyond these.  A cell on a film with little motion shows one plateau of the fringe; with its level free
#: the other plateau, half a turn away, would fit as well, and the many samples of a film would outvote any prior.  Set
#: by hand.
CELL_MAX_LEVEL_CONTRASTS, CELL_CONTRAST_RANGE_RATIO = 0.5, (0.4, 1.8)
#: An error bar that speaks of a rival symbol counts from here on.  Set by hand.
RIVAL_SD_RAD = 0.3
#: The cells' fringes must move with the rows': at least so far, and no less than that.  Ray-traced films: genuine ones
#: give 0.96 and more, cells that are a picture 0.  Derived: a third of the cells may be covered.
CELLS_MOVE_RATIO, CELLS_STAND_RATIO = 0.6, 0.4
#: Least mean square of the expected change, before cells are asked to move.  Set by hand.
MIN_CELL_CHANGE_CONTRASTS2 = 0.005

# --- Is it the badge that was enrolled, or a copy? -------------------------------------------------------------------

#: Paper grows by up to this share between enrolment and any later day.  Derived: a change of some 20 % of relative
#: humidity for office paper.  Held at its far edge it slides under the sheet by this share of half the grating.
PAPER_DRIFT_SHARE = 0.001
#: Pose, light and codec repeat the offset within this.  Ray-traced films: 0.04 rad on one badge by different motions.
OFFSET_REPEATS_RAD = 0.05
#: The rows' offsets, from whose run across the grating the twist is told, are good to this.  Set by hand.
ROW_OFFSET_SD_RAD = 0.03
#: A sheet in its mount turns by this between days.  Set by hand: 0.02 mm over 80 mm.
TWIST_REPEATS_RAD = 2.5e-4
#: Independent stretches of a hand's film, a second.  Set by hand: motion is smooth.
INDEPENDENT_PER_S = 2.0
#: Within so many standard deviations: original; beyond so many: a copy; between: not known.  Set by hand.
ORIGINAL_SDS, COPY_SDS = 3.5, 6.0

# --- Does the badge pass before the face? ----------------------------------------------------------------------------

#: Least score of the face detector.  Set by hand: a photograph of a face scores 1.3 to 1.5, the worst of its false
#: boxes 0.23.
MIN_FACE_SCORE = 0.5
#: Badge and face overlap where they share this much of the smaller one.  Set by hand: less is a corner that a false
#: border hides in.
MIN_OVERLAP_SHARE = 0.25
#: They must do so for this long without a break.  Set by hand.
MIN_OVERLAP_S = 1.0
#: Share of the interval's frames that must agree with the law, each within `EXPLAINED_SDS` (99.7 % of true ones do,
#: were errors of neighbouring frames not alike), and that must tell a phase at all.  Set by hand.
MIN_AGREEING_SHARE, MIN_READ_SHARE = 0.95, 0.5
