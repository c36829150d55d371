"""Constants of the motion test: limits, priors, floors and tolerances of explanations.

They are grouped by the question that they answer.  The comment before each says where it comes from:

- *derived*: from optics, statistics or manufacturers' figures; the reason is given;
- *ray-traced films*: films by an outside ray tracer; `moireid lab bench natural` and `outside` make
  such films anew, and `moireid lab bench priors` refits `OWN_MOTION`, `PARTS` and the calibration of the score;
- *films of* `bench reality`, `bench small-pages`, `benchmarks/golden.py` or this project: many are of our simulator;
- *measured*, *calibrated*: on the films that the comment names;
- *source*: what others published;
- *set by hand*: by judgement alone.

Each name ends with its unit: `_SHARE` and `_RATIO` are pure numbers, `_SDS` counts standard deviations, `_LOG10` is a
decadic logarithm.  Those of measuring, identity and enrolment are in `measuring.py`, gains of sheets in
`moireid.sheets`, and figures of one method in its file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# --- Is there enough to judge? ---------------------------------------------------------------------------------------

#: Window of the published figure (Qing et al. 2026): the mean of |rho| over windows of 30 frames.
WINDOW_FRAMES = 30
#: Frames below which nothing is judged.  Derived: `LEAST_SAMPLES` independent samples take two seconds, at 30 a second.
MIN_FRAMES = 2 * WINDOW_FRAMES
#: Set by hand: a hand's sway takes two or three seconds; a segment should contain one and a half of it.
SEGMENT_S = 4.0
#: Least standard deviation of the predicted phase.  Derived: 0.25 rad is 3.5 cm of sideways sway at 1 m.  Less cannot
#: be separated by five standard deviations from the drifts of light and codec (0.01 to 0.05 rad on ray-traced films).
MIN_EXCITATION_RAD = 0.25
#: ... and as a multiple of the prediction's error.  Derived: three times gives a correlation of 0.95.
MIN_EXCITATION_TO_ERROR_RATIO = 3.0
#: The verdict must be of this share of the film, and of its rows and frames as many must be free.  Derived: what is
#: said of a film is said of the larger part of it.
MIN_COVER_SHARE = MAX_COVERED_SHARE = 0.5
#: Where the badge is seen, this share of the frames must show it.  Set by hand: a badge that is shown in every second
#: frame is no film of a badge; blur and poor light lose a tenth.
MIN_PRESENT_SHARE = 0.75

# --- Was one camera filming, and is enough of the badge to be seen? --------------------------------------------------

#: What one camera may leave of the corners over many frames, px.  Films of this project's own simulator: up to 0.027
#: where a badge turns, as registration errs alike at one turn; 0.04 to 0.2 in most that are zoomed or reframed.
MAX_LASTING_PX = 0.03
#: The most by which a picture is zoomed within a film.  Set by hand; parallaxes are wrong by that factor at most.
MOST_ZOOM = 2.0
#: A stretch whose predicted phase spreads by less than this shows a badge at rest, which is no evidence, as a print
#: could be there.  Ray-traced films: light and codec make a phase drift by up to this.
REST_RAD = 0.05
#: At most this share of the frames, and of a long film's chapters, may be left out or be inconclusive by themselves, as
#: it is unknown what they show: of up to 19 chapters none, as each may hide another forged part.  A hand that covers a
#: marker in as many frames is reported.  Set by hand.
MAX_STRAY_SHARE = MAX_DOUBTFUL_SHARE = MIN_HELD_SHARE = 0.05
#: With markers below the first figure both may still be too small: in most of 24 films of `lab bench small-pages`
#: by 1.4 at most, in two by 2.1 and 2.6.  Motion that would not be enough with errors larger by the second figure
#: proves nothing against a film; and an unlikely film is rejected only if it is so with errors larger by the third.
DOUBTED_MARKER_PX, SMALL_MARKER_DOUBT_RATIO, SMALL_MARKER_WORST_RATIO = 24.0, 1.6, 2.6

#: A strip is partly covered if its error bar is this many times that of the clearest strip.  Set by hand.
MAX_VAGUENESS_RATIO = 3.0
#: Rows are covered from this share of rows and frames on.  Derived: one row of twelve in one frame of sixteen.
MIN_ROWS_COVERED = 0.005
#: How far contrast may dip with motion (`fringes.mixed_frames`).  Derived: an exposure that lasts all frame long.
#: Below its regression by so many standard deviations: 99.7 % of a normal distribution.
MAX_MIXED_SHARE, MIXED_SDS = 1 / 12, 3.0

# --- Does the law explain the fringes? -------------------------------------------------------------------------------

#: Noise changes contrasts as much as phases (`decision.figures`): a deviation proves nothing up to so many times what
#: its strip's contrast shows.  Derived: with 40 independent samples of each, two spreads of one noise differ by more in
#: one case of 100,000 (F distribution).  18 films of a true badge whose sheet is turned by 2 to 8 degrees: rows 0.6 to
#: 1.8, places 0.3 to 1.0; the worst strips of 7 forged ones, patchy or generated: 3 and more.  A forger who knows this
#: makes contrasts tremble as much: such a film is inconclusive, and so is one of which only a part is
#: (`Invariant.broken_but_for_noise`).
NOISE_EXCUSED_RATIO = 2.0

#: Codecs show faint fringes late: a block that changes little is copied from the last frame along the badge's motion,
#: and so keeps the old phase.  Derived: the maximum is one frame at 30 a second.  Ray-traced films: 0 to 15 ms, and 26
#: ms in one at 50 degrees, which has no lag with a finer quantiser.
MAX_LAG_S = 0.05

#: Allowed deviation of the gain from 1.  Derived: thickness and index of commercial sheets vary by about 10 %, the
#: estimated focal length by up to 5 %, pitch by 1 %.
GAIN_TOLERANCE_SHARE = 0.15
#: ... plus this many of its error bars before it is rejected.  Derived: 99.7 % of a normal distribution.
GAIN_REJECTED_SDS = 3.0
#: From this share of the gain on, an error bar is too wide to accept.  Derived: fringes at 1.9 times the true gain
#: would be accepted with a probability of 1 % (ln(1.15 / 1.9) is 2.33 times 0.215).
MAX_GAIN_SD_SHARE = 0.215
#: What air may hide of a gain, in so many of its error bars, is less than the tolerance, or the gain is not accepted.
#: Derived: 95 % of a normal distribution.
AIR_SDS = 2.0
#: A badge that is known as built: its gain is accepted within the first, or within so many error bars of film
#: and enrolment together where that is more, and never beyond `GAIN_TOLERANCE_SHARE`.  Derived: focus moves the focal
#: length by up to 2 % unseen; 20 K and wet air change thickness and index of a sheet by 0.5 %, 5 um of air another 1 to
#: 2 %.  At 1 m an error bar is 0.03, so that a gain 7 % off is not accepted; of true ones 82 % lie within four thirds
#: of a bar.
BUILT_GAIN_ROOM_SHARE, BUILT_GAIN_SDS = 0.04, 4 / 3
#: Gains that can be enrolled.  Set by hand: wider than all sheets of `moireid.sheets` but the extreme ones, and finite.
ENROLLED_GAINS = (0.5, 1.6)
#: Least gain of a badge that is not known as built; nothing less is a question about the build.  Set by hand: far
#: below the half that the thinnest sheets of a pitch that can focus give.  There is no greatest gain: 0.3 mm of air
#: gives 2.2, and more of it more.
LEAST_BUILT_GAIN = 0.2
#: Focal lengths that lenses have, over the picture's long side: from an ultra-wide phone to a press photographer's.
#: Where a film does not show its own, any of them may have taken it.
LENS_RATIOS = (0.3, 8.0)
#: Films of one enrolment whose gains differ by more than this many of their standard deviations, and by more than the
#: room above, are of different sheets, or one of them is wrong.  Derived: 99.7 % of a normal distribution.
GAINS_AGREE_SDS = 3.0
#: The error counts up to this share of the motion.  Measured: without it, a film with noise of 0.2 rad may wander by a
#: fifth of its motion in 8 of 26 cases, with it in none; of honest films with much noise it costs 1 in 26.
MAX_ERROR_SHARE = 0.1
#: Set by hand: noise excuses a field at rest as if the others moved by so much at most, rad.
RESTING_MOTION_RAD = 1.0
#: A deviation this many times larger may yet be a poor film's: noise of single frames counts by one over it, and a
#: rival that leaves more than so many times the limit explains nothing.  Ray-traced films: far away, where markers are
#: a few pixels, poses err by up to 2.5 times their estimate.
POSSIBLE_RESIDUAL_RATIO = 2.0
#: What changes faster is noise of single frames.  Derived: the shortest delay that differs from the law takes 0.2 s.
LASTING_S = 0.2
#: Spacing of the fringes against distance (`fringe_spacing`): a film whose gain differs from a badge's by more
#: than the first is inconclusive.  Derived: half of the way to a table of photographs, whose gain is 0.  Error bars
#: beyond the second: 99.7 % of a normal distribution.
MAX_SPACING_ERROR_RATIO, PHOTOGRAPH_SDS = 0.5, 3.0
#: Errors along a strip that last all film long, root mean square: 0.003 px where a fringe is 19 px, as at 2 m.  Films
#: of two renderers, coded by H.264: 0.0002 to 0.0015, of which this is the root mean square.
SPACING_FLOOR_RAD = 0.001
#: Under a zoom within the film, distances are wrong by this share of it.  Films of `bench reality`: 0.11 to 0.25.
ZOOM_ERROR_SHARE = 0.2
#: A film is inconclusive if what turns with the fringes, of the third harmonic, is not by so many contrasts more than
#: what stays still (`third_harmonic`), and its page's edges are sharp enough to show more.  Derived: twice what
#: superposed photographs show, 0.003 at most; true films, of two outside renderers and ours, 0.02 to 0.29.
LEAST_OVERTONE_CONTRASTS = 0.006
#: A film is inconclusive if its waveform surely changes by more than this share of what two to four cross-faded
#: photographs make (`cross_fade`).  38 true films of this project and three outside ones show -0.02
#: at most, films of two or three such photographs 0.27 and more: three quarters of that.
MAX_CROSS_FADE_SHARE = 0.2
#: By how much a badge's own waveform may change with the place in that form.  Those true films show 2 %.
UNEVEN_SHARE = 0.02

# --- The law plus another motion: how large are deviations? ----------------------------------------------------------

#: Forged deviations: every octave between these shares of the motion is equally likely.  Set by hand.
FORGED_MIN_SHARE, FORGED_MAX_SHARE = 0.1, 3.0

#: The law is traced for a flat, even, nominal sheet; a genuine badge deviates from it by this share, as a whole only
#: from aside.  12 films of `bench half-real`, at their true poses: 2 to 3 %, and gains of 0.970 to 1.012.
LAW_MOTION_SHARE = 0.02


@dataclass(frozen=True)
class GenuineStatistics:
    """A deviation on genuine badges: mean and standard deviation of the logarithm of deviation over unit.

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

    def unit_rad(
        self, excitation_rad: float, error_rad: float, strip_sd_rad: float = 0.0, rounding_rad: float = 0.0
    ) -> float:
        """The unit of a film with that motion and those errors, rad."""
        floor = max(self.floor_rad, self.strip_sd_share * strip_sd_rad, self.rounding_share * rounding_rad)
        return math.hypot(self.error_share * error_rad, floor, self.motion_share * excitation_rad)

    def quantile(self, sds: float, unit_rad: float) -> float:
        """The deviation that is so many standard deviations beyond the mean, rad."""
        return unit_rad * math.exp(self.mean_log + sds * self.sd_log)


#: Means and standard deviations of honest films.  `moireid lab bench priors` prints -0.94 and 0.33 for the motion of
#: its own on natural films (-1.09 and 0.37 with a share of the motion, which explains nothing more), 188 films of
#: `bench reality` -0.5 and 0.35; set by hand near the latter, with wider tails. 89 gratings of accepted films of
#: `benchmarks/golden.py`: -1.66 and 0.43, of rows -1.38 and 0.38, of places -1.19 and 0.44.  Rows and places are set
#: by hand above that, as sheets and cameras vary more than in one collection: the worst of the 89 is 0.2 standard
#: deviations above the mean.  Strips share the pose, so its error does not enter their figures, nor those of places.
#: In faint print, strips deviate by half of their error bars and more on ray-traced films, and so does a twelfth of a
#: strip over half a second.  Errors that a codec repeats are not averaged: places have all of them, and strips, of a
#: few coding blocks each, half.  Rows of the code: 105 honest films of `benchmarks/golden.py`.
OWN_MOTION = GenuineStatistics(1.0, 0.010, -0.55, 0.40, motion_share=0.0)
PARTS: dict[str, GenuineStatistics] = {
    "rows": GenuineStatistics(0.0, 0.010, -0.15, 0.35, strip_sd_share=0.7, rounding_share=0.5),
    "places": GenuineStatistics(0.0, 0.020, -0.05, 0.35, strip_sd_share=0.7, rounding_share=1.0),
    "code": GenuineStatistics(0.0, 0.120, -1.27, 0.42),
    "code_second": GenuineStatistics(0.0, 0.200, -1.39, 0.48, motion_share=0.06),
}
#: What the law leaves, and a part's deviation, may be up to the first, and proves a forgery from the second on.
#: Derived: four figures of parts (`PARTS`) are tested; if normal, one honest film in 1,000 has one of them beyond the
#: first, and one in 100,000 beyond the second.
USUAL_SDS, PROOF_SDS = 3.48, 4.56

# --- How many independent samples are in a film? ---------------------------------------------------------------------

#: Independent samples per second of a hand-held film.  89 true gratings of `benchmarks/golden.py`: what the law leaves
#: of them holds 4.8 to 30, by its autocorrelation; less than half of the least, as it takes up the slowest errors of
#: pose.
INDEPENDENT_PER_S = 2.0

# --- The law's nuisances, and rivals ---------------------------------------------------------------------------------

#: Stretches shorter than this are no evidence.  Derived: the shortest forged part that is searched, and a little more.
LEAST_SEEN_S = 0.4
#: Blocks of one film that explanations are compared on, at most.  Derived: up to a minute at 10 blocks a second, of
#: which the shortest delay that differs from the law takes two.
MOST_BLOCKS = 600
#: Below this a frame's error bar makes it no weightier, rad.  Ray-traced films: light and codec vary by as much.
LEAST_SCALE_RAD = 0.01
#: What an honest camera, badge and codec may add to the law (`explanations.honest`).  Lag: one frame and a half at 30 a
#: second; a time stamp may be early by a third of a frame.  Shape: half as much again as the law's.  Zoom: focus moves
#: the focal length by 1 to 2 %.  Axis: a logged phone's stabiliser moves it by 3 px of 1450, times 7.3 rad of phase.
MAX_LEAD_S = 0.01
MAX_SHAPE_SHARE, MAX_ZOOM_DRIFT_SHARE, MAX_AXIS_DRIFT_RAD = 0.03, 0.02, 0.015
#: Error of a block that no explanation models, rad.  89 true gratings of `benchmarks/golden.py`: the law leaves 0.001
#: to 0.024, root mean square 0.0067, and 0.0050 without the largest twentieth.
UNMODELLED_RAD = 0.006
#: A residual holds at least so many independent samples.  Set by hand: a shorter film is not judged.
LEAST_SAMPLES = 4.0
#: Priors of rivals: ratio to the best-fitting one, and the time over which a motion of its own is smooth.  Set by hand.
FORGED_GAINS, OWN_MOTION_S = (-2.0, 3.0), (0.5, 3.0)
#: Delays that are fitted, s: an honest codec's lag ends at `MAX_LAG_S`, and a generator that lags by more than 2 s
#: shows another motion.
DELAYS_S = (0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0)
#: Most forgeries of a rival that are drawn at a time, and in all.  Derived: with the second, shares of a rival of one
#: parameter up to 1.8 in 100 are surely below 2 in 100, and from 2.2 in 100 on surely above; of a motion of its own up
#: to 1.5, and from 2.6 on.
DRAWS, MOST_DRAWS = 400, 5000
#: How often a bound of a share may be wrong.  Derived: half as often as forgeries may look alike.
SHARE_UNSURE = 0.01
#: Phases that are drawn at a time.  Derived: an array of 400 kB, whose memory is used again and not asked for anew.
DRAWN_VALUES = 50_000
#: When a rival wins (read by `decision/comparison.py`, `decision/findings.py`, `session/chapters.py`):
#: A film is not accepted if a rival fits it better by more than this power of ten, or may look as law-like as it does
#: in more than 1 of so many cases (`explanations.strength`).  Set by hand: a factor of ten; 50 held on all films tried.
MAX_RIVAL_LOG10, LEAST_STRENGTH = 1.0, 50
#: Greatest strength that may be asked for.  Derived: with `MOST_DRAWS` and none alike, 1 in 542 is known.
MOST_STRENGTH = 500
#: What a picture that was zoomed, reframed or mixed may leave of the motion, as a share.  Derived: a zoom by up to two
#: that goes with the motion leaves a correlation of 0.95 (Cauchy and Schwarz), which is a residual of a third.
CAMERA_MOTION_SHARE = 0.33
#: Calibration of scores (`decision.figures`), by `moireid lab bench priors`; the cap is the logarithm of the number of
#: films in that set.
CALIBRATION_SLOPE, CALIBRATION_OFFSET_LOG10, CALIBRATION_CAP_LOG10 = 0.28, -2.35, 2.5
#: A forgery gets this share of the film's own residual, in blocks of so many seconds, and looks like the film if its
#: residual is at most so many times as large.  Set by hand: a forger's film has less error than one that was filmed.
RESAMPLED_SHARE, RESAMPLED_S, ALIKE_RATIO = 0.7, 0.5, 1.15
#: Windows in which the fringes may leave the law, s, and the law's least motion in a window, rad.  Set by hand.
SPELLS_S, MIN_SPELL_MOTION_RAD = (0.3, 0.5, 0.8, 1.5, 3.0), 0.2
#: The gain of the fringes there, and by how many powers of ten less likely that is beforehand.  Set by hand: a poor
#: pose looks like half or twice the motion far more often than like none.
SPELL_GAINS = {0.0: 0.8, -1.0: 0.8, 0.5: 2.2, 2.0: 2.2}
#: Degrees of freedom of the slips' distribution, and the least slip of a block, rad.  Set by hand: outliers of poses.
SPELL_FREEDOM, LEAST_SLIP_RAD = 6.0, 0.004
