#include "reports/document/glossary.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {
namespace {

constexpr std::array kWords = std::to_array<GlossaryWord>({
    {"ANEES", "average NEES", "NEES averaged over many runs at the same step",
     "For a consistent filter it lies near the number of states, within a band that narrows with the number "
     "of runs. Above the band the filter is optimistic, below it pessimistic."},
    {"adjusted", "adjusted p-value|Holm", "a p-value that accounts for how many tests were made",
     "Of many tests a few fail by chance. Holm's method raises the p-values so that a consistent filter has "
     "any of them below 0.05 with a probability of at most 5 %."},
    {"anchor", "anchors|anchored", "a landmark whose position is known from the start",
     "It ties the map to the world: without one the map can move and turn as a whole and no measurement sees "
     "it. One anchor makes the line world fully observable; in the plane the turn about it remains."},
    {"bias", "biased|mean error", "a mean of errors or innovations that is not zero",
     "Averaged over runs the error should vanish at every step. A bias comes from a sensor's offset, a wrong "
     "model or a wrong alignment; making P larger hides it and does not mend it."},
    {"bound", "bounds", "a limit that the truth does not cross, or within which a consistent filter stays",
     "Beside a mean: the range where a consistent filter has it with the confidence asked for. Of errors: "
     "the posterior Cramér-Rao bound (efficiency), below which no filter without bias is."},
    {"Clopper-Pearson", "", "an interval for a probability from counts, which holds for every sample size",
     "Of so many rows so many were beyond: the risk is at most the upper limit, with 95 % confidence. Rows "
     "that are correlated in time count as fewer independent ones."},
    {"chart", "charts", "in which coordinates a covariance of a pose speaks of the orientation",
     "About axes of the body or of the world, and the position with it; planar is x, y and heading. A "
     "covariance that is read in another chart than its filter's looks wrong. --chart says it."},
    {"conformal", "conformal prediction",
     "a factor on P that covers a further run with a stated probability, whatever the law of the errors",
     "It is read off the order of the runs at hand: of 19 or more, how much each needed. It asks no Gaussian "
     "law, only that the further run is exchangeable with these."},
    {"consistent", "consistency", "the errors are as large as the covariance says",
     "The runs give no evidence against the covariance. That is no proof: fewer runs reveal only larger "
     "mistakes. Where a report says “right within 8 %”, that much is proved."},
    {"covariance", "P", "the matrix P of the filter: how large and how related it believes its errors to be",
     "Its diagonal holds the variances; the square root of one is the standard deviation σ of that state. "
     "The question of every report is whether the true errors agree with it."},
    {"coverage", "", "how often the truth lies within kσ of the estimate",
     "For a consistent filter the share is that of a χ² law with as many degrees of freedom as states; with "
     "many states it is tiny, and the NEES tells more."},
    {"credibility", "credible|noncredibility|noncredibility index|inclination",
     "by how many decibels the covariance and the true mean square of the errors differ",
     "Of Li and Zhao: noncredibility is the distance, inclination its sign, which is positive where the "
     "covariance is too small. Both are 0 for a filter that is right."},
    {"dof", "degrees of freedom", "how many independent numbers a squared sum is made of",
     "NEES has as many as the state, NIS as many as the innovation; each is the mean that a consistent "
     "filter has."},
    {"efficiency", "efficient|Cramér-Rao bound|posterior Cramér-Rao bound",
     "how near the errors are to the smallest that any filter without bias could have",
     "The posterior Cramér-Rao bound over the mean squared error: 1 is the best there is. Where the bound is "
     "loose, as in SLAM whose paths differ from run to run, nobody comes near it."},
    {"EKF", "extended Kalman filter",
     "a Kalman filter that replaces curved models by tangents at its estimate",
     "The tangents are taken at wrong places, so its covariance tends to become too small: in SLAM it claims "
     "to know the heading of the whole map."},
    {"energy score", "", "how far estimates that P makes likely lie from the truth",
     "The mean distance from the truth, less half of that between two of them; smaller is better, and it is "
     "in the unit of the state. It rewards small errors and an honest covariance, and a single row far out "
     "costs less than in the log score."},
    {"exchangeable", "exchangeability", "that the order of the runs says nothing",
     "Runs of one vehicle, one place and one setting are; a run in other weather, with another sensor or on "
     "a faster vehicle is not, and what was learnt from the first need not hold for it."},
    {"factor on P", "", "what the covariance would have to be multiplied by",
     "The true covariance over the claimed one, on average over the steps, with its interval. Above 1 the "
     "filter is optimistic. It mends the mean only: a cause is better mended at its place."},
    {"gain", "K|Kalman gain", "the weights K with which an innovation corrects the state",
     "One row for each state, one column for each number measured. A gain of zero means that a measurement "
     "no longer moves that state."},
    {"gate", "gating|validation gate", "a bound on NIS beyond which a filter uses no measurement",
     "It keeps false matches away, and right ones that are far out as well: NIS is cut off there, and its "
     "mean is too small. A filter whose P is too small throws away what would mend it."},
    {"inflation", "inflated|covariance inflation", "making the covariance larger on purpose",
     "Adds a matrix ΔP to P so that correlations may be dropped without P becoming too small. An inflated "
     "filter is pessimistic by design."},
    {"innovation", "innovations|ν", "measurement minus what the filter expected to measure",
     "In a consistent filter it has mean zero, the covariance S that the filter computes, and no correlation "
     "with earlier innovations."},
    {"least trace", "exact|minimal trace|min-trace", "the inflation that adds the smallest possible trace",
     "Of all ΔP that make the wanted decorrelation legal, the one whose diagonal sums to least; found by an "
     "exact optimiser. The simpler pairwise rule adds more."},
    {"log score", "logarithmic score", "the logarithm of the density that the filter gave to the truth",
     "A mean over steps, larger is better. It rewards small errors and an honest covariance together, so "
     "that of two filters on the same data the higher one is better. Only differences tell, as the unit "
     "enters."},
    {"mixed", "",
     "optimistic in one part of the state, or at some times, and pessimistic in another, or at others",
     "Do not trust such a filter: its average may look right. The table says which part is which."},
    {"monobot", "", "a robot on a line that measures how far landmarks are",
     "The simplest SLAM problem, linear and solvable by hand; Figures 1 to 4 of the paper show it."},
    {"NEES", "normalised estimation error squared|normalized estimation error squared",
     "squared error of the estimate, measured in units of the covariance: eᵀ P⁻¹ e",
     "For a consistent filter its mean is the number of states. Twice that means that the true variances are "
     "twice the claimed ones. It needs the truth."},
    {"NIS", "normalised innovation squared|normalized innovation squared",
     "squared innovation in units of its covariance: νᵀ S⁻¹ ν",
     "For a consistent filter its mean is the number of values measured. It needs no truth, and cannot see "
     "errors in directions that no sensor measures."},
    {"not Gaussian", "heavy tails|heavy-tailed|tails|Gaussian|Gaussian law",
     "the covariance is right, and large errors are more frequent than a Gaussian law has",
     "Typical of outliers. Mean and covariance may be used; probabilities of rare errors may not."},
    {"observable", "observability|partially observable|fully observable|partial",
     "determined by the measurements",
     "A direction of the state that no sequence of measurements reveals is not observable, such as the "
     "position of a whole map. Its variance must not shrink; rank O counts the directions that are "
     "observable."},
    {"optimistic", "overconfident", "errors are larger than the covariance says: unsafe",
     "Whoever relies on the covariance believes the state to be known better than it is. Do not trust it."},
    {"outliers", "outlier|gross outlier|gross outliers", "single errors or innovations far beyond their law",
     "Mostly wrong matches or faulty measurements. A few of them dominate a mean of NEES or NIS; judged "
     "without them (--sensitivity) the filter may be consistent."},
    {"pairwise", "", "a simple rule of inflation that treats correlations two by two",
     "Each dropped correlation is paid for by both states that it ties together. It is cheap, and inflates "
     "more than the least trace."},
    {"pessimistic", "conservative|underconfident",
     "errors are smaller than the covariance says: safe, and wasteful",
     "So it is in some part of the state, or in the innovations, and in none of them larger. Information is "
     "thrown away, or the covariance was inflated on purpose."},
    {"pose", "", "position and heading of the vehicle",
     "What a robot drives by; its NEES is always shown, since a sum over a map of many landmarks can hide "
     "it."},
    {"process noise", "Q", "what the filter assumes of the errors of its motion model",
     "Too small a Q makes a filter optimistic over time, too large a Q pessimistic."},
    {"measurement noise", "R", "what the filter assumes of the errors of its sensors",
     "Too small an R makes NIS and NEES too large, too large an R too small."},
    {"protection level", "protection levels",
     "a distance that the position error exceeds only at a stated risk",
     "k standard deviations along the widest axis of P, k of the risk by the χ² law. To show that errors "
     "beyond it are so rare takes about 3 over the risk independent rows with none of them beyond."},
    {"p-value", "p|p-values", "how probable such an outcome, or a stranger one, is for a consistent filter",
     "Below 0.05 the verdict is not consistent. It is no size of a mistake: with many runs a harmless "
     "mistake has a tiny p-value; the factor tells the size."},
    {"rank", "", "how many independent directions a matrix has",
     "rank O: directions that measurements see; rank ΔP: directions in which inflation adds noise."},
    {"Riccati", "Riccati equation", "the equation whose solution is the covariance in the long run",
     "If it has a solution, P stays bounded and tends to it."},
    {"S", "innovation covariance", "what the filter believes of the size of its innovations: H P Hᵀ + R",
     "NIS measures innovations in units of S."},
    {"stretches", "stretch", "parts of a long run that are nearly independent of each other",
     "Errors of successive steps are alike, so a run of a thousand steps is worth far fewer. It is cut into "
     "stretches many correlation times long, whose means serve as independent values."},
    {"undecided", "", "no verdict: the data speak neither for the covariance nor against it",
     "They are too few, and then the report says how many runs would do; or they cannot tell, as innovations "
     "that are not white without a truth, errors or innovations that are all zero, arrays whose axes look "
     "swapped, or too many failed runs or rejected rows. The report says which. It is no accusation and no "
     "acquittal."},
    {"whiteness", "white|portmanteau|portmanteau test|Ljung-Box",
     "no correlation of the innovation with its own past",
     "A correlated innovation means that the filter leaves information unused: a wrong Q or R, a missing "
     "state, or one measurement used twice."},
    {"cross-covariances", "cross-covariance|correlation of the whitened errors",
     "the entries of P by which errors of different states go together",
     "A filter that drops them can be right in every block and wrong in the whole. Errors whose sign is "
     "turned in one block look as if these entries were wrong."},
    {"linearisation", "linearised|linearize|linearization", "replacing a curved model by its tangent",
     "At an estimate that is far off the tangent is wrong: the filter corrects in wrong directions, and "
     "believes to know what it does not."},
    {"initial covariance", "P0|start", "the P with which a filter begins",
     "If it is wrong, the first steps are inconsistent, and later ones where nothing is measured."},
    {"correlated in time", "coloured noise|autocorrelation|lag|lags", "each value resembles the one before",
     "Filters assume noise that is not: a sensor with a filter of its own, or a disturbance that lasts, "
     "makes P too small. A state for it, or a larger R, mends it."},
    {"wrapped", "unwrapped|not wrapped|wrap", "of an angle: brought back to within half a turn",
     "A difference of 359° is one of −1°. Wrap every difference of angles, of errors and of innovations."},
    {"prior", "", "what a filter believes before it takes a measurement",
     "Sensors that are read at one time are taken one after the other, each with the P that the one before "
     "left; with the same P for all, what they have in common is counted twice."},
    {"late", "lateness|delay|latency|behind in time",
     "of a measurement: taken earlier than the filter believes",
     "Its errors point back along the way. Use the time at which it was measured, and move the estimate "
     "there. Of a truth that is behind the errors point ahead: compare estimates with the truth of their own "
     "times."},
    {"at one step", "what happens at one step|one step alone|jump",
     "errors that are right until a step, wrong there, and fade",
     "No initial covariance makes them, nor a noise of every step. Look at that step: a truth that jumps, a "
     "wrong measurement, or one so near that its linearisation does not hold over P."},
    {"error of the truth", "", "a fault of what estimates are compared with, and not of the filter",
     "Its noise is new in every row, where the errors of a filter fade. A reference of several centimetres "
     "makes a filter of as many look optimistic: add its covariance to P, or use a better one."},
    {"loses its way", "lost runs", "a few runs end far off, and the others are right",
     "The mean over runs is that of the lost ones, and no factor on P mends them: look at what happened "
     "there."},
    {"associations", "association|match|matches", "which landmark a measurement is said to be of",
     "A wrong one is an outlier, and often the beginning of a lost run."},
    {"second moments", "mean squares|shape of P|direction|directions",
     "mean squares and products of the errors, direction by direction",
     "They equal P for a filter that is right, whatever the law of the errors. A P that is too large in one "
     "direction and too small in another has the right mean NEES."},
    {"Anderson-Darling", "Kolmogorov-Smirnov|chi-square law|chi-square|χ²",
     "tests that compare all values with a law, not only their mean",
     "Kolmogorov-Smirnov looks at the body of the law, Anderson-Darling at its tails."},
    {"power", "", "how often a test finds a mistake of a certain size",
     "A verdict of consistent says no more than its power: “these runs would have revealed P too small by 25 "
     "%” means in nine of ten studies like this one, if the true covariance were 1.25 times P; too large by "
     "25 %, if P were 1.25 times the true one.",
     true},
    {"baseline", "baselines|worse", "the result of an earlier check that a new one is compared with",
     "check --baseline fails where the verdict has become worse, or a factor on P is farther from 1 than it "
     "was by more than chance.",
     true},
    {"rejected", "rejected rows|unmatched|unmatched rows", "of a row of a log: left out, and counted",
     "A P that is none, a number that is missing or not finite, or a row without a truth that is near "
     "enough. Where more than one in twenty is, the others do not speak for the filter.",
     true},
    {"stands", "together|stand", "of a sweep: inconsistent also when all configurations are judged together",
     "Of many configurations some look inconsistent by chance. Of those that stand, at most 5 % are expected "
     "to be false (Benjamini and Yekutieli).",
     true},
    {"verdict", "verdicts", "consistent, optimistic, pessimistic, mixed, not Gaussian or undecided",
     "One word over all that was judged. It is wrong of a consistent filter with a probability of at most 5 "
     "%, or what --confidence leaves.",
     true},
    {"run", "runs", "one course of the filter from its start to its end",
     "Runs are independent; the steps within one are not. More runs tell more than longer ones.", true},
    {"step", "steps|rows", "one time at which the filter gives an estimate",
     "A row of a log is a step of a run.", true},
    {"expected", "", "the mean that a consistent filter has",
     "Of NEES the number of states, of NIS the number of values measured.", true},
    {"failed", "diverged|not positive definite|not_positive_definite|threw|failures",
     "of a run: the filter broke down, or its estimate went beyond all bounds",
     "In single steps it counts up to the one before; means and factors are of the other runs. It is named "
     "with "
     "its number, with which --only-run plays it again.",
     true},
    {"trusted if within", "", "the bounds within which the mean of a consistent filter lies",
     "With the confidence asked for, over all steps together; where a step decided, its own bounds.", true},
    {"values", "value", "how many numbers a mean is made of",
     "They may be worth fewer independent ones, as errors of successive steps are alike.", true},
    {"block", "blocks|state|states|what", "some states that are judged by themselves, beside the whole",
     "Names with a point make one: imu.bx and imu.by are the block imu.", true},
    {"RMSE", "root mean square error|P claims|of position", "the root of the mean squared error",
     "Beside it stands what P claims: the root of its mean variance. It is in the unit of the state.", true},
    {"trace", "tr P|last tr P", "the sum of the variances of P",
     "How uncertain the filter is altogether, in mixed units: of one filter at two times it tells whether P "
     "grows.",
     true},
    {"error", "errors", "estimate less truth, of an angle within half a turn",
     "Of a pose, in the coordinates that its covariance speaks of (chart).", true},
    {"σ", "σ²|claimed σ|claimed|rms|standard deviation|standard deviations", "the root of a variance",
     "That of a state is claimed by the filter as the root of its entry on the diagonal of P. Of Gaussian "
     "errors 68 % lie within one, 95 % within two.",
     true},
    {"mean", "means|average", "the sum over all values by their number",
     "Over runs and steps, unless it is of one step or of each run. Of runs of different lengths each counts "
     "once.",
     true},
    {"test", "tests|says|measured", "a question to the data whose rate of false alarms is known",
     "What it measured stands beside its p-value; “adjusted” counts how many tests were made.", true},
    {"factor on S", "scale of S", "what the innovation covariance would have to be multiplied by",
     "Mean NIS over what is expected, with its interval.", true},
    {"study", "studies|scenario|configuration|configurations",
     "a scenario with its settings, played by a number of runs",
     "A sweep has one for each combination of what it varies.", true},
});

bool is_letter(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x80 || std::isalnum(byte) || c == '_';
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

/// Calls `use` with the word and each of its other spellings.
template <class Use>
void for_each_spelling(const GlossaryWord& word, Use use) {
  use(word.word);
  for (std::string_view rest = word.also; !rest.empty();) {
    const std::size_t end = std::min(rest.find('|'), rest.size());
    use(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

}  // namespace

std::span<const GlossaryWord> glossary() {
  static const auto sorted = [] {
    auto words = kWords;
    std::ranges::sort(words, {}, [](const GlossaryWord& w) { return lower(w.word); });
    return words;
  }();
  return sorted;
}

const GlossaryWord* find_glossary_word(std::string_view word) {
  const std::string wanted = lower(word);
  for (const GlossaryWord& entry : glossary()) {
    bool found = false;
    for_each_spelling(entry, [&](std::string_view spelling) { found = found || lower(spelling) == wanted; });
    if (found) return &entry;
  }
  return nullptr;
}

std::vector<const GlossaryWord*> glossary_words_in(std::string_view phrase) {
  constexpr std::size_t kShort = 3;  // shorter ones are letters, of which p is not P
  const std::string all = lower(phrase);
  const auto stands = [&](std::string_view spelling) {
    const std::string_view text = spelling.size() < kShort ? phrase : std::string_view(all);
    const std::string wanted = spelling.size() < kShort ? std::string(spelling) : lower(spelling);
    for (std::size_t i = text.find(wanted); i != std::string_view::npos; i = text.find(wanted, i + 1)) {
      const bool begins = i == 0 || !is_letter(text[i - 1]);
      const std::size_t end = i + wanted.size();
      if (begins && (end == text.size() || !is_letter(text[end]))) return true;
    }
    return false;
  };
  std::vector<const GlossaryWord*> words;
  for (const GlossaryWord& entry : glossary()) {
    bool found = false;
    for_each_spelling(entry, [&](std::string_view spelling) { found = found || stands(spelling); });
    if (found) words.push_back(&entry);
  }
  return words;
}

std::vector<std::string_view> near_glossary_words(std::string_view word) {
  constexpr std::size_t kMost = 3;
  std::vector<std::string_view> near;
  const auto add = [&](const GlossaryWord* entry) {
    if (entry == nullptr || near.size() == kMost || std::ranges::find(near, entry->word) != near.end())
      return;
    near.push_back(entry->word);
  };
  const std::string wanted = lower(word);
  std::vector<std::string> spellings;
  for (const GlossaryWord& entry : glossary()) {
    for_each_spelling(entry, [&](std::string_view spelling) { spellings.push_back(lower(spelling)); });
  }
  const std::vector<std::string_view> candidates(spellings.begin(), spellings.end());
  if (const std::string_view closest = closest_word(wanted, candidates); !closest.empty()) {
    add(find_glossary_word(closest));
  }
  constexpr std::size_t kTelling = 3;  // shorter words stand in every sentence
  if (wanted.size() < kTelling) return near;
  for (const GlossaryWord& entry : glossary()) {
    bool starts = false;
    for_each_spelling(entry, [&](std::string_view spelling) {
      starts = starts || lower(spelling).find(wanted) != std::string::npos;
    });
    if (starts) add(&entry);
  }
  for (const GlossaryWord& entry : glossary()) {
    if (lower(entry.short_form).find(wanted) != std::string::npos) add(&entry);
  }
  return near;
}

std::vector<GlossaryUse> glossary_uses(std::string_view text) {
  constexpr std::size_t kShortest = 3;  // P and K are the text of formulas
  std::vector<GlossaryUse> uses;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i > 0 && is_letter(text[i - 1])) continue;
    GlossaryUse best;
    for (const GlossaryWord& entry : glossary()) {
      const std::size_t length = entry.word.size();
      if (entry.everyday || length < kShortest || length <= best.length ||
          !text.substr(i).starts_with(entry.word))
        continue;
      if (i + length < text.size() && is_letter(text[i + length])) continue;
      best = {i, length, &entry};
    }
    if (best.word == nullptr) continue;
    uses.push_back(best);
    i += best.length - 1;
  }
  return uses;
}

}  // namespace credence::internal
