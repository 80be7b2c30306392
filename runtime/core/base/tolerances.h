/* Every threshold that decides something, with what it decides and why it is as large as it is.
 *
 * Each is a pure number, times what it is of: a length is that of the mechanism (of an angle, 1 rad), a speed that length per
 * characteristic time, a time the larger of the characteristic one and the time reached, a unit that of the coordinate
 * (model/scales.h), a tolerance the rtol or atol of the run. So the same mechanism in other units decides alike. Floats have
 * limits of their own where their rounding asks for it, nearer to each other: reasons with factors are those of doubles. What
 * only the pace depends on, as the factors of step control, stands where it is used.
 */
#ifndef CCGEN_TOLERANCES_H
#define CCGEN_TOLERANCES_H

#include "base/real.h"

enum tolerance_of { OF_RELATIVE, OF_LENGTH, OF_SPEED, OF_TIME, OF_UNIT, OF_TOLERANCE };

/* X(name, value, of, "what it decides", "why it is as large"), after LAYER(layer) of the core that first asks for them. Reasons are for
 * readers of `ccgen show --tolerances` too: other thresholds stand in parentheses, behind what they are. */
/* clang-format off */
#define ALL_TOLERANCES(X, LAYER) \
    LAYER(algebra) \
    X(DEPENDENT_PIVOT, CCGEN_LIMIT(1e-11, 1e-5), OF_RELATIVE, \
      "a pivot of a symmetric matrix that is this part of its own entry is none", \
      "entries are rounded to 1e-16 and sums of some hundred of them lose up to four digits: what is left of five more may be rounding") \
    X(WELL_PIVOT, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "a pivot that has lost more goes to the null-space path", \
      "what a solution loses is the inverse of its least pivot: ten digits are kept, one more than the default rtol asks for") \
    LAYER(complementarity) \
    X(PIVOT_ROUNDING, CCGEN_LIMIT(1e-12, 1e-5), OF_RELATIVE, \
      "an entry of Lemke's tableau this small is no pivot", \
      "a tableau of about 1 after some tens of pivots is known to about 1e-13") \
    X(TIE, CCGEN_LIMIT(1e-13, 1e-6), OF_RELATIVE, \
      "ratios this near are one", \
      "they are quotients of the tableau's entries, which are known to that") \
    X(TERM_ROUNDING, (64.0 * DBL_EPSILON), OF_RELATIVE, \
      "an acceleration that is this part of its terms is zero", \
      "a sum of some tens of terms, each with the rounding of its two factors") \
    X(ALL_PUSH, CCGEN_LIMIT(1e-10, 1e-4), OF_RELATIVE, \
      "all contacts push where this part of the largest b is left", \
      "what is left after pivots as small as those that are still divided by (DEPENDENT_PIVOT), times ten") \
    X(APPROACHES, CCGEN_LIMIT(1e-13, 1e-6), OF_RELATIVE, \
      "a contact approaches from this part of the largest b on", \
      "b is a difference of accelerations, known to a few hundred units of rounding") \
    X(CONSISTENT, CCGEN_LIMIT(1e-10, 5e-5), OF_RELATIVE, \
      "what Coulomb's law may be missed by", \
      "pivots keep ten digits (WELL_PIVOT)") \
    X(MIXED, CCGEN_LIMIT(1e-4, 1e-1), OF_RELATIVE, \
      "the part of the largest terms of all rows that counts as a row's own", \
      "what the law may be missed by (CONSISTENT) times it is 1e-14 of those terms: some tens of their roundings") \
    X(LEADING_PIVOT, 1e-2, OF_RELATIVE, \
      "a pivot taken in the order of the unknowns is small, its triangles large: nothing is concluded from them", \
      "chosen: triangles a hundred times as large as their system lose four digits of it, and a few more where it is near to singular") \
    X(SEEN_AT_ONCE, CCGEN_LIMIT(1e-3, 1e-1), OF_RELATIVE, \
      "part of the largest impulse: one that pulls by more does so in all digits, and its way needs no solution of its own", \
      "chosen: such triangles leave more digits than three; what pulls less is solved with exchange of rows") \
    X(SINGULAR_MODES, CCGEN_LIMIT(1e-11, 1e-5), OF_RELATIVE, \
      "a choice of sticking and sliding with such a pivot has no impulses of its own", \
      "sums of some hundred entries lose up to four digits, and what is left of five more may be rounding (as DEPENDENT_PIVOT)") \
    X(RATE_ROUNDING, (256.0 * DBL_EPSILON), OF_RELATIVE, \
      "rates of contacts, and entries of W, this near to zero are zero", \
      "each is a sum over links and contacts, some hundred roundings") \
    X(LESS, CCGEN_LIMIT(1e-9, 1e-4), OF_RELATIVE, \
      "impulses that are less by this part are less, and not alike", \
      "ten times what Coulomb's law may be missed by (CONSISTENT)") \
    X(ALIKE, CCGEN_LIMIT(1e-8, 1e-3), OF_RELATIVE, \
      "motions this near are one", \
      "rates are impulses times W: ten times what impulses are alike at (LESS)") \
    X(FAR_LARGER, 1e6, OF_RELATIVE, \
      "times what impulses come from: of larger terms no more counts than this, or than their rounding (TERM_ROUNDING)", \
      "what the law may be missed by (CONSISTENT) is then a ten-thousandth of what impulses come from: a tenth of what is no solution (NO_EFFECT)") \
    X(DROWNED, CCGEN_LIMIT(1e-5, 1e-4), OF_RELATIVE, \
      "impulses whose rounding is this part of what they come from are none", \
      "what their terms are rounded to (TERM_ROUNDING) is then a thousandth of it: three digits are left (as NO_EFFECT)") \
    X(NEARLY_CONSISTENT, CCGEN_LIMIT(1e-8, 1e-4), OF_RELATIVE, \
      "what the best answer may miss Coulomb's law by where none meets it", \
      "rates beside far larger ones are known to no more than ten times the default rtol") \
    X(SWEPT, CCGEN_LIMIT(1e-15, 1e-6), OF_RELATIVE, \
      "sweeps over the contacts have settled", \
      "the last digit") \
    LAYER(model) \
    X(ANGLE_KNOWN, CCGEN_LIMIT(1e-6, 1.2e-3), OF_RELATIVE, \
      "rad: an angle whose last digit is larger says nothing of where links point", \
      "points at the mechanism's length are then known to a millionth of it, and in floats to a thousandth, where a turn has four digits left") \
    LAYER(constraints) \
    X(RANK_TOLERANCE, CCGEN_LIMIT(1e-10, 4e-5), OF_RELATIVE, \
      "rows this near to dependence are dependent", \
      "at the distance sigma the closure fixes places across to rounding / sigma (docs/theory, section 8): here to 2e-6 of the length, more than a tolerance lets pass") \
    X(BRIDGED, 0.05, OF_RELATIVE, \
      "nearer than that to dependence configurations along a branch of the motion are interpolated from both sides", \
      "there accelerations would be known to rounding / sigma^3, 2e-12, which is what a step by the tightest tolerances may miss") \
    X(NO_BRANCH, CCGEN_LIMIT(1e-6, 1e-2), OF_RELATIVE, \
      "last coefficients of tangents along a way on which no branch crosses dependent rows", \
      "where one does they are rounding by its distance from dependence, 1e-11 and less, or 1e-9 where another place is near; where none does they are 1e-4 and more") \
    X(KNOWN_ALONG, CCGEN_LIMIT(1e-10, 1e-3), OF_RELATIVE, \
      "last coefficients of tangents that are interpolated", \
      "a tenth of the default rtol: a motion along them misses less than its steps may") \
    X(TELLS_TANGENTS, CCGEN_LIMIT(1e-5, 6e-3), OF_RELATIVE, \
      "nearer than that to dependence velocities tell the branch, in place of rows", \
      "rows tell tangents to rounding / sigma^2: here to 2e-6, more than enough to tell branches apart") \
    X(TELLS_BRANCH, CCGEN_LIMIT(1e-6, 1e-2), OF_RELATIVE, \
      "velocities along which dependent rows come back by less of their speed tell no branch", \
      "differences of rows over the third root of rounding are known to its square, 4e-11: four digits of the branch are left") \
    X(HEADED, CCGEN_LIMIT(1e-4, 6e-2), OF_RELATIVE, \
      "of its distance from a place at which no branches cross a motion misses it by less if it goes through", \
      "motions bend by their distance on the way there, which is 1e-5 where it is asked (TELLS_TANGENTS): ten times that") \
    X(REFINED_ENOUGH, CCGEN_LIMIT(1e-12, 5e-6), OF_RELATIVE, \
      "a last correction that is less is rounding", \
      "some thousand roundings of the unreduced equations") \
    X(REFINED_BY_KERNEL, (4096.0 * DBL_EPSILON), OF_RELATIVE, \
      "the same of a correction by the kernel", \
      "some thousand roundings of the unreduced equations (as REFINED_ENOUGH)") \
    X(HOPELESS, 1e-3, OF_RELATIVE, \
      "a last correction that is more leaves nothing known", \
      "less than three digits of an acceleration are no solution") \
    X(CONTACT_PIVOT, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "held contacts with such a pivot, where some slide, go to the null-space path", \
      "what a solution loses is the inverse of its least pivot: ten digits are kept (as WELL_PIVOT)") \
    X(IMPLIED_SHARE, CCGEN_LIMIT(1e-9, 1e-4), OF_RELATIVE, \
      "a contact with this share of its own row left is carried by others", \
      "a hundred times what is no pivot (DEPENDENT_PIVOT): two digits of it are known") \
    X(PLAINLY_INDEPENDENT, CCGEN_LIMIT(1e-3, 3e-2), OF_RELATIVE, \
      "rows of contacts are independent of each other as motions are", \
      "with masses alike pivots of their response are the squares, as large as what keeps ten digits (WELL_PIVOT)") \
    X(BENDS_OTHERWISE, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "contacts whose rows are one part where their gaps bend differently: by this part of the length, or of how they bend, along a unit of a coordinate", \
      "curvatures are sums as places are, of some thousand roundings (as SHUT), squared in what a step of such a size makes of them: radii to a million lengths are round") \
    LAYER(motion) \
    X(PASSES_LAW, CCGEN_LIMIT(1e-9, 1e-4), OF_RELATIVE, \
      "part of the largest force by which others may pass Coulomb's limits where those of least norm do", \
      "what presses or slides by less is rounding to a decision (PRESSED), which would hold again what is let go for it") \
    X(SIDE_ROUNDING, (256.0 * DBL_EPSILON), OF_UNIT, \
      "a switching function of an effect changes its sign where it is more than a state off by this makes of it", \
      "states on the closure and on their grounds are known to some hundred roundings: what contacts or loops keep at zero would change its sign at every step") \
    X(NEXT_SIDE, CCGEN_LIMIT(1e-8, 1e-3), OF_TIME, \
      "a switching function of an effect that changes by its own size within it is at zero: the motion goes to where it is then", \
      "the root of rounding: steps end at zeros to rounding, which is far less than what changes in it, and bends over it are rounding") \
    X(RANK_TOLERANCE_PROJECTED, CCGEN_LIMIT(1e-5, 6e-3), OF_RELATIVE, \
      "rows this near are taken for dependent where a state is put back", \
      "a way back of miss / sigma has a second-order part, (miss / sigma)^2: from here on no more than 1e-14 where the miss is 1e-12") \
    X(LEFT_OUT, CCGEN_LIMIT(1e-12, 1e-4), OF_LENGTH, \
      "what a row that almost vanishes may miss", \
      "more than sums of rounded places do, of some thousand roundings (as SHUT)") \
    X(LEFT_OUT_LATER, 0.01, OF_RELATIVE, \
      "how much nearer to dependence a row may be where leaving it out does not do", \
      "two such steps and a half lead from where rows are dependent for putting back (RANK_TOLERANCE_PROJECTED) to where they are for motion (RANK_TOLERANCE)") \
    X(SLIDING_PIVOT, CCGEN_LIMIT(1e-12, 5e-6), OF_RELATIVE, \
      "friction of sliding contacts with such a pivot jams", \
      "forces on the null-space path are known to some thousand roundings (as REFINED_ENOUGH)") \
    X(CREEP, CCGEN_LIMIT(1e-9, 1e-3), OF_SPEED, \
      "what moves along its friction at its limit slides from here on", \
      "ten times the speed below which a contact may stick (STILL): what a decision takes for still does not slide at once") \
    X(CARRIED_CHANGE, (4.0 * DBL_EPSILON), OF_RELATIVE, \
      "sweeps that carry small differences along a step have settled where the last changes their accelerations by this part", \
      "a few units of the last digit: what is left after each sweep is a small part of what it changes") \
    LAYER(impact) \
    X(IMPACT_GAIN, CCGEN_LIMIT(1e-13, 1e-5), OF_RELATIVE, \
      "energy that an impact may add: part of the kinetic", \
      "some hundred roundings of sums over the links") \
    X(RATES_MISSED, CCGEN_LIMIT(1e-14, 1e-6), OF_RELATIVE, \
      "rates after an impact that miss more are corrected", \
      "some tens of roundings: no correction is better") \
    X(CORRECTED_IMPULSE, CCGEN_LIMIT(1e-5, 1e-2), OF_RELATIVE, \
      "a correction that is a larger part of the impulses is none", \
      "what the least pivots of W that count lose (DEPENDENT_PIVOT): eleven digits of sixteen") \
    X(NO_EFFECT, 1e-3, OF_RELATIVE, \
      "impulses that miss this part of the largest rate have no effect", \
      "less than three digits of a jump are no solution (as HOPELESS)") \
    X(ROUNDED_RATE, CCGEN_LIMIT(1e-12, 1e-4), OF_RELATIVE, \
      "rates that are this part of the fastest motion are rounding", \
      "rates are sums over the links as places are: some thousand roundings (as SHUT)") \
    LAYER(steps) \
    X(SLOPE, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "part of a piece of a step over whose change the slope of a switching function is taken", \
      "ten digits are left of a slope whose values have sixteen, and its bend over a millionth is as little") \
    X(MEETING, CCGEN_LIMIT(1e-12, 1e-5), OF_TIME, \
      "a step this long may pass where the ends of a spring meet", \
      "its force jumps there: what a step gains or loses by that is some thousand roundings (as SHUT)") \
    X(SHUT, CCGEN_LIMIT(1e-12, 1e-5), OF_LENGTH, \
      "a gap this small is closed", \
      "places are sums over the links: some thousand roundings; no more than any gap_tolerance") \
    X(REST_SPEED, CCGEN_LIMIT(1e-10, 1e-4), OF_SPEED, \
      "a closed contact that moves slower is at rest", \
      "a hundred times what a closed gap is (SHUT): speeds have lost two digits more than places") \
    X(FINEST_GAP, CCGEN_LIMIT(1e-12, 1e-5), OF_LENGTH, \
      "a gap counts as closed at rtol (gap_tolerance), and at this where rtol is less", \
      "places are sums over the links: some thousand roundings (as SHUT)") \
    X(COARSEST_GAP, CCGEN_LIMIT(1e-8, 1e-3), OF_LENGTH, \
      "and at this where rtol is more", \
      "ten times the default rtol: no contact closes visibly before it is") \
    X(ITERATED, 1e-3, OF_TOLERANCE, \
      "what iterations may leave that do not go to rounding", \
      "events are located on the end of a step as it changes with its length: that part is what it may be uneven by") \
    X(BELIEVED, 0.1, OF_RELATIVE, \
      "part of an error that counts wherever it lies", \
      "with an order of 8 steps are then a third longer at most than if all of it counted") \
    X(DRIVEN, CCGEN_LIMIT(1e-8, 1e-3), OF_UNIT, \
      "what a driven joint may be moved by where a step is put back", \
      "the root of rounding: what is quadratic in the miss is less") \
    X(LEAP, 1e-6, OF_UNIT, \
      "what a step may change beside what its velocities carry", \
      "far above what is put back, far below what is seen") \
    X(OUTRUN, 10.0, OF_RELATIVE, \
      "times what velocities carry in a step: more is wrong", \
      "velocities at both ends of a good step differ by less than that from those between") \
    X(SHORTEST, (16.0 * DBL_EPSILON), OF_RELATIVE, \
      "times the time, or a thousandth of the characteristic one: no step is shorter", \
      "sixteen units of the last digit of the time: a step still has four bits") \
    X(EARLY, 0.05, OF_RELATIVE, \
      "part of a step: events before it are looked for in a shorter one", \
      "a bounce that is a twentieth of a step is one wiggle of a dense output of order 7") \
    X(LONGEST_REBOUND, 10.0, OF_RELATIVE, \
      "times the flight before an impact: the first step tried after it", \
      "bounces shorten by the restitution: the next is not longer, and steps grow sixfold") \
    X(GETS_ON, CCGEN_LIMIT(1e-3, 4e-2), OF_UNIT, \
      "steps that turn the fastest link by more get the motion on: they are not counted among those that a window may have", \
      "the fifth root of rounding: the step that a method of order 5 takes over a smooth motion with the finest rtol") \
    X(CRAWL, CCGEN_LIMIT(1e-8, 1e-4), OF_UNIT, \
      "steps that move less may be stuck where links lie in a line", \
      "the root of rounding: what is unknown there, docs/theory 8.3") \
    X(STANDSTILL, 1e-5, OF_TIME, \
      "a twentieth of the steps of a window, if they take less in a row and none moves more than rounding beside a line, are stuck", \
      "a span of time stepping, which passes what they are stuck at, takes ten times that") \
    X(ADRIFT, CCGEN_LIMIT(1e-11, 1e-4), OF_LENGTH, \
      "a carried contact with such a gap is open", \
      "ten times what is closed (SHUT): rounding does not open a contact that others carry") \
    X(TURN, 0.125, OF_RELATIVE, \
      "rad by which links turn against each other in a piece that is looked at for events", \
      "a gap goes as a cosine: an eighth of a radian changes its curvature by less than 1 %, and is a corner of a wheel of 50") \
    X(FORCE_ROUNDING, (64.0 * DBL_EPSILON), OF_RELATIVE, \
      "forces this small beside the largest that there have been are zero", \
      "sums over contacts of some tens of terms, each with the rounding of its two factors (as TERM_ROUNDING)") \
    X(STILL, CCGEN_LIMIT(1e-10, 1e-4), OF_SPEED, \
      "a contact that slides slower may stick", \
      "speeds have lost two digits more than places (as REST_SPEED)") \
    X(FORESEEN, 10.0, OF_RELATIVE, \
      "times what samples do not foretell: a force nearer to zero is looked at more closely", \
      "what every other sample misses of the rest shrinks sixteenfold with half the distance; ten times is on the safe side") \
    X(JAGGED, 0.1, OF_RELATIVE, \
      "part of a force that samples may not foretell, and yet may be rounding", \
      "chosen: where a loop is all but flat forces have one digit or none") \
    X(FALLING, 0.45, OF_RELATIVE, \
      "a negative value with more than this part of what it is twice as far from its zero has been negative all the way", \
      "what falls from zero has a half of it, or tends to that from a quarter; what rises first and then falls has less than a quarter") \
    X(SHALLOW, 0.1, OF_RELATIVE, \
      "part of the samples: a parabola with its least above has not come near zero", \
      "a parabola through three samples of a cubic misses by less") \
    X(SHORTEST_WINDOW, (1.0 / 256.0), OF_RELATIVE, \
      "part of a step: a force not resolved in a window so short has jumped", \
      "eight halvings of a window that eight samples resolve in a smooth step") \
    X(PENETRATION, CCGEN_LIMIT(1e-12, 1e-5), OF_LENGTH, \
      "an event found deeper is put before its zero", \
      "places are sums over the links: some thousand roundings (as SHUT)") \
    X(JUMP, 1e-3, OF_RELATIVE, \
      "part of what a force was: one that is still more just before it is lost has jumped", \
      "Newton and false position leave 1e-15 of it where it is continuous") \
    X(BESIDE, 1.0, OF_TOLERANCE, \
      "what the end of a step may miss the closure by", \
      "the tolerance itself") \
    X(WILD, 1e6, OF_TOLERANCE, \
      "error of a step that no mere length explains", \
      "with an order of 8, a step six times too long has 1.7e6") \
    X(GUIDED, 0.0625, OF_TOLERANCE, \
      "what the estimate of a step by collocation along a branch may be", \
      "stages that are put onto a branch move by more than their polynomial shows: with a sixteenth, by an order of 16, steps are a sixth shorter") \
    X(MAGNIFIED, 4.0, OF_RELATIVE, \
      "times what it missed: the way back of a state far from singular ones", \
      "a projection goes as 1 / sigma; elsewhere sigma is above a quarter") \
    X(SIGMA_DROP, 0.05, OF_RELATIVE, \
      "how much nearer to dependence rows come in passing than elsewhere in the step", \
      "the looks come within a thousandth of a step of a zero; what stays above a twentieth there is a narrow place, no passage") \
    X(SIGMA_DROP_COARSE, 0.3, OF_RELATIVE, \
      "the same at a first look", \
      "of nine looks over a step and a half one is within a tenth of a step of the zero; three times that where the way bends") \
    X(LOOK_AHEAD, 1.5, OF_RELATIVE, \
      "steps so far ahead in which a singular configuration is looked for", \
      "a step that ends before it leaves the next half a step") \
    X(KEPT, 1.0, OF_TOLERANCE, \
      "what a step may miss of the energy that moves", \
      "the tolerance itself") \
    X(ENERGY_ROUNDING, (256.0 * DBL_EPSILON), OF_RELATIVE, \
      "part of the energy that a step may miss by rounding", \
      "some hundred roundings of its sum") \
    X(GROSS, 0.1, OF_RELATIVE, \
      "of the energy that moves: a step of fixed length that misses as much is wrong", \
      "no digit is right") \
    X(TANGENT, 16.0, OF_RELATIVE, \
      "times rounding / sigma^2: what the direction of the motion is known to", \
      "chosen: a quarter of what velocities are known to (ACROSS_KNOWN), for the work is less than the force times the whole speed") \
    X(OFTEN, 0.1, OF_TOLERANCE, \
      "a miss of energy that is less is not looked into", \
      "it decides about time only") \
    LAYER(hybrid) \
    X(PLACE_ROUNDING, (2.0 * DBL_EPSILON), OF_LENGTH, \
      "what a place is known to", \
      "the rounding of a sine and of its product with a length") \
    X(AT_END, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "part of the range of the multiplier of velocities that leave a line: nearer to its end both branches of the motion are equally near", \
      "a double root: the multiplier is known to rounding by its square, velocities to its root and two digits") \
    X(STRAIGHT, CCGEN_LIMIT(1e-12, 1e-5), OF_RELATIVE, \
      "times speed squared: what may be left of the closure's second derivative", \
      "sums over the links: some thousand roundings (as SHUT, for lengths per time squared)") \
    X(REST_TIME, CCGEN_LIMIT(1e-11, 1e-5), OF_TIME, \
      "bounces over so soon are over", \
      "some hundred times what a time is known to after a hundred events") \
    X(PRESSED, CCGEN_LIMIT(1e-9, 1e-4), OF_RELATIVE, \
      "an acceleration that is this part of the largest is rounding", \
      "ten times what Coulomb's law may be missed by (CONSISTENT)") \
    X(SLOW, 1e4, OF_RELATIVE, \
      "times what the largest acceleration reaches while bounces are over (REST_TIME): what moves faster is no candidate", \
      "chosen: a wide margin, for what is not asked is taken for apart") \
    X(SHARED, 1e-4, OF_RELATIVE, \
      "part of the accelerations of links that counts beside those of gaps where these are told from rounding", \
      "times what is rounding of an acceleration (PRESSED) it is 1e-13 of those: what differences of them are known to") \
    X(ONWARD, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "part of the largest acceleration by which a change decides what vanishes", \
      "a thousand times what is rounding (PRESSED): seen, and too small to change what is decided otherwise") \
    X(SMALL, 1e-3, OF_RELATIVE, \
      "of the largest force: more has not vanished", \
      "forces fall by that in a thousandth of a motion (AHEAD)") \
    X(AHEAD, 1e-3, OF_RELATIVE, \
      "of a step: so far ahead forces are smooth", \
      "a step of order 8 resolves changes over a tenth of it") \
    X(LITTLE, 1e-3, OF_TOLERANCE, \
      "what speeds may differ by whether a contact is let go now or then", \
      "a thousandth leaves the error test to what integrates") \
    X(FURTHER_AHEAD, 8.0, OF_RELATIVE, \
      "how much further each look ahead goes", \
      "three bits of the change of a force") \
    X(DECISIVE, 64.0, OF_RELATIVE, \
      "times rounding: a change of forces that shows where they go", \
      "six bits of it are then known") \
    X(EDGE, CCGEN_LIMIT(1e-12, 1e-5), OF_RELATIVE, \
      "friction within this part of its limit, or of the force that stops the largest acceleration by that contact alone, is at it", \
      "some thousand roundings of the impulses that limit it") \
    X(EDGE_GIVEN, CCGEN_LIMIT(1e-6, 1e-3), OF_RELATIVE, \
      "the same where a contact has just begun to slide, by an event that was located on that limit, or others that stick keep it", \
      "chosen: what others that begin to slide at the same instant change of the forces is more than rounding") \
    X(ORDINARY, 16.0, OF_RELATIVE, \
      "events of a contact in a window of crowds that are no crowd", \
      "bounces of half the speed before have come to 10^-5 of it by then: what accumulates has more, what strikes now and then has fewer") \
    X(EACH, 64.0, OF_RELATIVE, \
      "events of each contact that crowds, at least, in a window of crowds before any comes to rest sooner", \
      "bounces of two thirds of the speed before have come to 10^-11 of it by then") \
    X(FEW, 6.0, OF_RELATIVE, \
      "coordinates: mechanisms with more may have fewer events in a window of crowds, in proportion", \
      "as two free bodies have, or a loop of four links: below it an event costs little beside what every event does") \
    X(CROWDED_SPEED, CCGEN_LIMIT(1e-8, 1e-3), OF_SPEED, \
      "a closed contact that moves slower is at rest where events crowd; the speed doubles with their number", \
      "a hundred times what rests else (REST_SPEED): a bounce at it is no higher than 1e-16 of the length, the rounding of places") \
    X(SEEN, CCGEN_LIMIT(1e-6, 1e-2), OF_SPEED, \
      "what moves faster, off its ground or along it, does not rest for crowds of events, nor for friction that jams; of the fastest speed in the window where that is less", \
      "a contact that is stopped from it takes 1e-12 of the energy that moves, and changes the speeds of others by no more") \
    X(COLLISION, 1e3, OF_RELATIVE, \
      "times the speed of what rests: an impact without collision that changes velocities by less is none", \
      "it is found from an approach at that speed (REST_SPEED), which itself changes velocities by as much, times how much slower a contact is than what moves it") \
    X(CLOSE_TO_JAMMING, 1e-3, OF_RELATIVE, \
      "what is left of a contact's resistance beside its friction where steps get no shorter: its force has no bound", \
      "a force a thousand times that of a smooth contact, which grows as one over the time that is left") \
    X(STEPPED, CCGEN_LIMIT(1e-6, 1e-3), OF_UNIT, \
      "what a step of time stepping may differ by from its two halves", \
      "an impact within a step of a hundred-thousandth of the characteristic time moves things by ten times that: it is found to a tenth of the step") \
    X(DRIVEN_ASTRAY, CCGEN_LIMIT(1e-4, 1e-2), OF_RELATIVE, \
      "a step of time stepping beside drives that misses more of the energy does not count", \
      "chosen: steps of chains miss a millionth of it, those of loops that a drive forces through their line a hundredth and more") \
    X(COMPLIANCE, CCGEN_LIMIT(1e-10, 5e-5), OF_RELATIVE, \
      "contacts that find no rigid forces give way by this part of what their own forces move", \
      "what Coulomb's law may be missed by (CONSISTENT)") \
    X(SOFTER, 100.0, OF_RELATIVE, \
      "times the compliance before, where contacts that give way by it find no forces either", \
      "chosen: two more digits that rounding may have taken, twice (COMPLIANCE, SOFTEST)") \
    X(SOFTEST, CCGEN_LIMIT(2e-6, 1e-2), OF_RELATIVE, \
      "the most that contacts give way by, of what their own forces move", \
      "forces as large as ten times what they come from then miss the law by less than it may be in steps (SWEPT_MISS)") \
    X(GIVES_WAY, CCGEN_LIMIT(1e-4, 1e-1), OF_RELATIVE, \
      "contacts may give way by this part of what approaches", \
      "chosen: those that press each other give way by 1e-6 of it, those whose friction jams by ten thousand times it and more") \
    X(SWEPT_MISS, CCGEN_LIMIT(1e-4, 1e-3), OF_RELATIVE, \
      "impulses of a step of time stepping may miss Coulomb's law by this part of what approaches where none meets it", \
      "sweeps move impulses by what they miss: from half of this on, in all of them (20,000) by the size of the approach, and then they get on") \
    X(INSTANT, CCGEN_LIMIT(1e-10, 1e-4), OF_TIME, \
      "events within such a time crowd", \
      "ten times the time in which bounces are over (REST_TIME)") \
    X(CROWD, 200.0, OF_RELATIVE, \
      "events within an instant (INSTANT): what bounces is at rest, and after twice as many in which nothing faster than that strikes time stepping goes on", \
      "bounces of nine tenths of the speed before have come to 10^-9 of it by then") \
    X(RATTLE, 1000.0, OF_RELATIVE, \
      "events in a row between which no closed contact moves: what bounces is at rest", \
      "chosen: they take time, and are bounces of rounding; five times as many as without time (CROWD)") \
    X(IDLE, 10.0, OF_RELATIVE, \
      "events of one gap in a row that neither take time nor lead to an impact: its contact is at rest", \
      "chosen: rounding of a gap makes one or two of them") \
    X(REPEATS, 1000.0, OF_RELATIVE, \
      "impacts at one instant, after which all that is closed strikes once more, without restitution", \
      "chosen: a row of n bodies that strike one after another has about n^2 / 2 of them, forty bodies 800") \
    X(ENERGY_JUMPED, CCGEN_LIMIT(1e-6, 1e-2), OF_RELATIVE, \
      "part of the energy, in motion and of the mechanism: what events add to it is no rounding if it is more", \
      "loops all but in a line close within the root of rounding: links put back onto the closure may be lifted by some 5e-8 of a length") \
    X(UNSEEN, 16.0, OF_RELATIVE, \
      "times rounding and length: a gap that changes less between two events has not moved", \
      "sixteen units of the last digit: four bits of a change are known (as SHORTEST)") \
    LAYER(interface) \
    X(TOGETHER, CCGEN_LIMIT(1e-12, 1e-5), OF_RELATIVE, \
      "part of the time, or of the duration: events of a scene that are nearer to each other are of one instant", \
      "they are located to rounding, in states whose velocities are known to some thousand times that") \
    X(LOOPS_OPEN, CCGEN_LIMIT(1e-6, 1e-4), OF_LENGTH, \
      "loops that are open by more where an event has set parameters are not those of the mechanism", \
      "a thousand times what gaps are closed to (BEHIND over ten); starts may miss as much") \
    X(HOLDS_WITHIN, CCGEN_LIMIT(1e-6, 1e-4), OF_LENGTH, \
      "a joint takes hold where its points are nearer than this, unless its scene tells", \
      "as loops that are open (LOOPS_OPEN): what is nearer is drawn together as a start is") \
    X(NO_ACCELERATION, CCGEN_LIMIT(6e-6, 5e-3), OF_RELATIVE, \
      "nearer than that to dependence no acceleration is known", \
      "the cube root of rounding: accelerations are known to rounding / sigma^3 (docs/theory section 8)") \
    X(ACROSS_KNOWN, 64.0, OF_RELATIVE, \
      "times rounding / sigma^2: what velocities across a singular configuration are known to", \
      "sums of some tens of terms, each with its rounding (as TERM_ROUNDING; docs/theory section 8)") \
    X(BEHIND, CCGEN_LIMIT(1e-8, 1e-3), OF_LENGTH, \
      "a gap further behind its surface is no rounding", \
      "ten times the default rtol: as wide as what counts as closed at most (COARSEST_GAP)") \
    X(BESIDE_PLACE, CCGEN_LIMIT(6e-3, 5e-2), OF_RELATIVE, \
      "nearer than that to dependence what is told of a motion is interpolated from both sides", \
      "there accelerations are known to a billionth, rounding / sigma^3 (as NO_ACCELERATION)") \
    X(SMOOTH, CCGEN_LIMIT(1e-7, 1e-2), OF_RELATIVE, \
      "last coefficients of what is interpolated across dependent rows, of its largest value", \
      "a hundred times what the states that are evaluated are known to (BESIDE_PLACE); where no branch passes they are 1e-4 and more") \
    X(MEETS, CCGEN_LIMIT(1e-6, 1e-2), OF_UNIT, \
      "how far states across dependent rows may pass from the one between them", \
      "fifty times the root of rounding, which is what is known of places there; branches are apart by hundredths") \
    X(DIRECTION_MISSED, 1e-7, OF_RELATIVE, \
      "what rows that depend on others miss by, where directions are those of a motion", \
      "chosen: of a motion rounding is left, 1e-16 times the condition of the rows, which is below 1e9 where they are not singular; a coordinate alone misses by about 1") \
    X(SURELY_INDEPENDENT, 1e-5, OF_RELATIVE, \
      "rows of contacts with a larger share of the largest are independent without looking further", \
      "chosen: what is derived with them keeps eleven digits, and five lie between them and what is dependent (RANK_TOLERANCE)") \
    X(FRICTION_MISSED, 1e-8, OF_RELATIVE, \
      "friction this far from its limit is not at it, and the law of what slides is not derived", \
      "forces are known to some hundred roundings of a solution whose condition is up to 1e5 (SURELY_INDEPENDENT)")
/* clang-format on */

/* Pairs of which the first has to be the smaller: what one lets pass, the other has to catch. */
/* clang-format off */
#define ALL_ORDERS(X) \
    X(PLACE_ROUNDING, SHUT) \
    X(SHUT, ADRIFT) \
    X(PENETRATION, ADRIFT) \
    X(FINEST_GAP, COARSEST_GAP) \
    X(ADRIFT, COARSEST_GAP) \
    X(STILL, CREEP) \
    X(REST_SPEED, CROWDED_SPEED) \
    X(CROWDED_SPEED, SEEN) \
    X(EDGE, EDGE_GIVEN) \
    X(REST_TIME, INSTANT) \
    X(SHORTEST, REST_TIME) \
    X(CRAWL, GETS_ON) \
    X(CONSISTENT, PRESSED) \
    X(CONSISTENT, LESS) \
    X(LESS, ALIKE) \
    X(CONSISTENT, NEARLY_CONSISTENT) \
    X(TIE, PIVOT_ROUNDING) \
    X(DEPENDENT_PIVOT, IMPLIED_SHARE) \
    X(DEPENDENT_PIVOT, WELL_PIVOT) \
    X(RATE_ROUNDING, CONSISTENT) \
    X(RANK_TOLERANCE, RANK_TOLERANCE_PROJECTED) \
    X(RATES_MISSED, ROUNDED_RATE) \
    X(PRESSED, ONWARD) \
    X(CONSISTENT, PASSES_LAW) \
    X(KNOWN_ALONG, NO_BRANCH) \
    X(TELLS_TANGENTS, BRIDGED) \
    X(TELLS_TANGENTS, HEADED) \
    X(SIGMA_DROP, SIGMA_DROP_COARSE)
/* clang-format on */

#ifdef CCGEN_VARIABLE_TOLERANCES /* for tests that look what another size of one changes */
#define DECLARED_TOLERANCE(name, value, of, decides, because) extern __attribute__((visibility("default"))) double name;
#else
#define DECLARED_TOLERANCE(name, value, of, decides, because) static const double name = value;
#endif
#define NOT_DECLARED(layer)
ALL_TOLERANCES(DECLARED_TOLERANCE, NOT_DECLARED)
#undef DECLARED_TOLERANCE
#undef NOT_DECLARED

struct tolerance_entry {
    const char *name;
    double value;
    enum tolerance_of of;
    const char *decides, *because;
};

/* all of them, and before those of a layer its name, which decides nothing; the last has no name */
extern const struct tolerance_entry tolerance_entries[];

/* Two entries, by number */
struct tolerance_order {
    int less, more;
};

/* all pairs that are ordered; the last is -1, -1 */
extern const struct tolerance_order tolerance_orders[];

#endif
