#include "fragility/rocking_response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/angle.hpp"
#include "base/error.hpp"

namespace cairn::fragility {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
// A rise below this share of the toppling angle is rest: the chain of impacts that leads there is infinite.
constexpr double kRestShare = 1e-6;
constexpr int kMaxFreeEvents = 100000;

// Ground acceleration / g over one step of the record: value at its start and slope.
struct Drive {
  double horizontal, horizontal_slope, vertical, vertical_slope;
};

struct State {
  double theta = 0.0, rate = 0.0;
};

// Moment about a toe / (m g R): positive pulls theta down.
double restoring(const Toe& toe, double theta, double horizontal, double vertical) {
  const double x = toe.alpha - theta;
  return (1.0 + vertical) * std::sin(x) + toe.gain * horizontal * std::cos(x);
}

// One Dormand-Prince step with what its continuous extension needs (Hairer, Norsett & Wanner, Solving ODE I, II.5-6).
class Step {
 public:
  Step(const Toe& toe, const Drive& drive, double offset, double length, State from)
      : toe_(toe), drive_(drive), offset_(offset), h_(length), from_(from) {
    k_[0] = slope(0.0, from);
    k_[1] = slope(0.2, at({0.2}));
    k_[2] = slope(0.3, at({3.0 / 40, 9.0 / 40}));
    k_[3] = slope(0.8, at({44.0 / 45, -56.0 / 15, 32.0 / 9}));
    k_[4] = slope(8.0 / 9, at({19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729}));
    k_[5] = slope(1.0, at({9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656}));
    to_ = at({35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84});
    k_[6] = slope(1.0, to_);
  }

  // Prepares dense().
  void extend() {
    constexpr std::array<double, 7> d = {-12715105075.0 / 11282082432,  0.0,
                                         87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                         701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                         69997945.0 / 29380423};
    for (std::size_t i = 0; i < 7; ++i) {
      fourth_.theta += d[i] * k_[i].theta;
      fourth_.rate += d[i] * k_[i].rate;
    }
  }

  [[nodiscard]] State to() const { return to_; }

  // Of theta and of its rate.
  [[nodiscard]] State error() const {
    constexpr std::array<double, 7> e = {71.0 / 57600,      0.0,        -71.0 / 16695, 71.0 / 1920,
                                         -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
    State sum;
    for (std::size_t i = 0; i < 7; ++i) {
      sum.theta += e[i] * k_[i].theta;
      sum.rate += e[i] * k_[i].rate;
    }
    return {h_ * sum.theta, h_ * sum.rate};
  }

  // State at share s of the step, 0..1; after extend().
  [[nodiscard]] State dense(double s) const {
    const auto blend = [&](double y0, double y1, double k0, double k6, double last) {
      const double difference = y1 - y0, bulge = h_ * k0 - difference;
      return y0 + s * (difference + (1.0 - s) * (bulge + s * (difference - h_ * k6 - bulge + (1.0 - s) * h_ * last)));
    };
    return {blend(from_.theta, to_.theta, k_[0].theta, k_[6].theta, fourth_.theta),
            blend(from_.rate, to_.rate, k_[0].rate, k_[6].rate, fourth_.rate)};
  }

 private:
  [[nodiscard]] State slope(double share, State at) const {
    const double t = offset_ + share * h_;
    return {at.rate, -toe_.p_squared * restoring(toe_, at.theta, drive_.horizontal + drive_.horizontal_slope * t,
                                                 drive_.vertical + drive_.vertical_slope * t)};
  }
  [[nodiscard]] State at(std::initializer_list<double> weights) const {
    State sum;
    std::size_t i = 0;
    for (const double w : weights) {
      sum.theta += w * k_[i].theta;
      sum.rate += w * k_[i].rate;
      ++i;
    }
    return {from_.theta + h_ * sum.theta, from_.rate + h_ * sum.rate};
  }

  const Toe& toe_;
  const Drive& drive_;
  double offset_, h_;
  State from_, to_, fourth_;
  std::array<State, 7> k_{};
};

class Rocker {
 public:
  Rocker(const RockingProfile& profile, const RockingInput& input, const RockingOptions& options,
         std::vector<RockingSample>* history)
      : profile_(profile),
        input_(input),
        history_(history),
        topple_(toppling_angles(profile)),
        stop_(base::deg_to_rad(options.stop_angle_deg)),
        tolerance_(options.tolerance),
        max_step_(options.max_step_s > 0.0 ? options.max_step_s : kNoLimit),
        angle_scale_(std::min(topple_.up, -topple_.down)) {
    place(input.theta, input.rate);
  }

  RockingResult run() {
    const std::size_t steps = input_.horizontal.size() - 1;
    record(0.0);
    for (std::size_t i = 0; i < steps && !result_.overturned; ++i) {
      const Drive drive = drive_of(i);
      const double start = static_cast<double>(i) * input_.dt;
      double offset = 0.0;
      while (offset < input_.dt && !result_.overturned)
        offset = resting_ ? rest_until(drive, offset, start) : move(drive, offset, start);
    }
    if (!result_.overturned) settle();
    return result_;
  }

 private:
  // The toe that carries a given rotation; on a switch, the one that the rate leads to.
  void place(double theta, double rate) {
    state_ = {theta, rate};
    const auto& switches = profile_.switches;
    if (theta == 0.0 && rate == 0.0) {
      resting_ = true;
      switch_ = profile_.rest;
      return;
    }
    const auto first_above = rate < 0.0 ? std::lower_bound(switches.begin(), switches.end(), theta)
                                        : std::upper_bound(switches.begin(), switches.end(), theta);
    toe_ = static_cast<std::size_t>(first_above - switches.begin());
    note_uplift(0.0);
    note_peak();
  }

  [[nodiscard]] Drive drive_of(std::size_t i) {
    const double h = input_.scale / kGravity;
    Drive d{h * input_.horizontal[i], h * (input_.horizontal[i + 1] - input_.horizontal[i]) / input_.dt, 0.0, 0.0};
    if (!input_.vertical.empty()) {
      const double v = std::abs(h);
      const double v0 = v * input_.vertical[i], v1 = v * input_.vertical[i + 1];
      if (v0 < -1.0 || v1 < -1.0) result_.lifted_off = true;
      d.vertical = std::max(v0, -1.0);
      d.vertical_slope = (std::max(v1, -1.0) - d.vertical) / input_.dt;
    }
    return d;
  }

  // Stays on two toes while the moment about both presses it down; returns where in the step that ends.
  // The moments are linear in the accelerations and so in time: no iteration.
  double rest_until(const Drive& drive, double offset, double start) {
    const double theta = profile_.switches[switch_];
    const Toe& below = profile_.toes[switch_];
    const Toe& above = profile_.toes[switch_ + 1];
    const auto moment = [&](const Toe& toe, double t) {
      return restoring(toe, theta, drive.horizontal + drive.horizontal_slope * t,
                       drive.vertical + drive.vertical_slope * t);
    };
    const double end = input_.dt;
    const auto leaves = [&](double now, double then, double sign) {
      if (sign * now < 0.0) return offset;
      if (sign * then >= 0.0) return kNoLimit;
      return offset + (end - offset) * now / (now - then);
    };
    const double m_up = moment(above, offset), m_down = moment(below, offset);
    const double up = leaves(m_up, moment(above, end), 1.0);
    const double down = leaves(m_down, moment(below, end), -1.0);
    if (up == kNoLimit && down == kNoLimit) return end;
    const bool goes_up = up < down || (up == down && above.p_squared * -m_up >= below.p_squared * m_down);
    resting_ = false;
    toe_ = goes_up ? switch_ + 1 : switch_;
    state_ = {theta, 0.0};
    const double when = std::min(goes_up ? up : down, end);
    note_uplift(start + when);
    record(start + when);
    return when;
  }

  double move(const Drive& drive, double offset, double start) {
    const Toe& toe = profile_.toes[toe_];
    double length = std::min({input_.dt - offset, next_length_, max_step_});
    for (;;) {
      Step step(toe, drive, offset, length, state_);
      const State error = step.error();
      // A body that falls far past its toppling angle is followed to the same share of where it is.
      const double scale = std::max(angle_scale_, std::abs(state_.theta));
      const double worst =
          std::max(std::abs(error.theta), std::abs(error.rate) / std::sqrt(toe.p_squared)) / (scale * tolerance_);
      if (worst > 1.0 && length > 1e-12 * input_.dt) {
        length *= std::max(0.2, 0.9 * std::pow(worst, -0.2));
        continue;
      }
      constexpr double kSmooth = 1e-4;  // below this the step grows as far as it may
      next_length_ = length * (worst < kSmooth ? 5.0 : std::clamp(0.9 * std::pow(worst, -0.2), 0.5, 5.0));
      step.extend();
      const double share = event_share(step);
      const bool whole = share >= 1.0;
      const double end = whole && length == input_.dt - offset ? input_.dt : offset + share * length;
      const double went = state_.rate;
      state_ = whole ? step.to() : step.dense(share);
      if (went * state_.rate < 0.0 || !whole) note_turn(step, share, went);
      note_peak();
      if (std::abs(state_.theta) > stop_) overturn(start + end);
      else if (!whole || crossed_) impact(drive, end);
      record(start + end);
      return end;
    }
  }

  [[nodiscard]] double lower() const { return toe_ == 0 ? -kNoLimit : profile_.switches[toe_ - 1]; }
  [[nodiscard]] double upper() const { return toe_ == profile_.switches.size() ? kNoLimit : profile_.switches[toe_]; }

  // Share of the step at which theta first leaves the toe's range; 1 where it does not. Sets crossed_ and direction_.
  double event_share(const Step& step) {
    crossed_ = false;
    const State to = step.to();
    const double lo = lower(), hi = upper();
    // A turn inside the step may hide a crossing, or follow a start on the switch itself.
    double turn = -1.0;
    if (state_.rate * to.rate < 0.0) turn = root([&](double s) { return step.dense(s).rate; }, 0.0, 1.0);
    for (const double s : {turn, 1.0}) {
      if (s < 0.0) continue;
      const double theta = s < 1.0 ? step.dense(s).theta : to.theta;
      if (theta >= lo && theta <= hi) continue;
      const double limit = theta < lo ? lo : hi;
      crossed_ = true;
      direction_ = theta < lo ? -1 : 1;
      const double from = s == 1.0 && turn >= 0.0 ? turn : 0.0;
      const auto inside = [&](double x) { return (step.dense(x).theta - limit) * -direction_; };
      // A start on the switch with no rate that falls straight back has no share inside.
      if (from == 0.0 && !(inside(0.0) > 0.0)) return 1.0;
      return root(inside, from, s);
    }
    return 1.0;
  }

  // The zero of f in [a, b], f(a) and f(b) of unequal sign: false position with Illinois' halving.
  template <typename F>
  static double root(F f, double a, double b) {
    double fa = f(a), fb = f(b), x = b, before = a;
    int side = 0;
    for (int i = 0; i < 100 && std::abs(x - before) > 1e-15; ++i) {
      before = x;
      x = (a * fb - b * fa) / (fb - fa);
      const double fx = f(x);
      if (fx == 0.0) return x;
      if ((fx > 0.0) == (fb > 0.0)) {
        b = x;
        fb = fx;
        if (side == -1) fa *= 0.5;
        side = -1;
      } else {
        a = x;
        fa = fx;
        if (side == 1) fb *= 0.5;
        side = 1;
      }
    }
    return x;
  }

  // The pivot passes to the next toe.
  void impact(const Drive& drive, double offset) {
    ++result_.impacts;
    const bool rising = direction_ > 0;
    const std::size_t at = rising ? toe_ : toe_ - 1;
    const std::size_t from = toe_, to = rising ? toe_ + 1 : toe_ - 1;
    const Toe& toe = profile_.toes[to];
    const double h = drive.horizontal + drive.horizontal_slope * offset;
    const double v = drive.vertical + drive.vertical_slope * offset;
    state_.theta = profile_.switches[at];
    const double rate = std::max(0.0, rising ? toe.eta_from_down * state_.rate : -toe.eta_from_up * state_.rate);
    // Deceleration after the impact, along the motion.
    const double slowing = toe.p_squared * restoring(toe, state_.theta, h, v) * (rising ? 1.0 : -1.0);
    const double pressing = restoring(profile_.toes[from], state_.theta, h, v) * (rising ? -1.0 : 1.0);
    state_.rate = rising ? rate : -rate;
    toe_ = to;
    if (rate == 0.0 || (slowing > 0.0 && pressing > 0.0 && 0.5 * rate * rate < kRestShare * angle_scale_ * slowing)) {
      resting_ = true;
      switch_ = at;
      state_.rate = 0.0;
    }
  }

  // After the record: E = rate^2 / 2 + p^2 cos(alpha - theta) is kept on each toe.
  void settle() {
    if (resting_ && switch_ == profile_.rest) return;
    for (int events = 0; events < kMaxFreeEvents; ++events) {
      if (resting_ && !leave_rest()) break;
      const Toe& toe = profile_.toes[toe_];
      const auto potential = [&](double theta) { return toe.p_squared * std::cos(toe.alpha - theta); };
      const double energy = 0.5 * state_.rate * state_.rate + potential(state_.theta);
      double rising = state_.rate;
      if (rising == 0.0) rising = -restoring(toe, state_.theta, 0.0, 0.0);
      if (rising == 0.0) break;  // balanced exactly above the toe
      const double limit = rising > 0.0 ? std::min(upper(), stop_) : std::max(lower(), -stop_);
      const bool peak_ahead =
          rising > 0.0 ? state_.theta < toe.alpha && toe.alpha < limit : state_.theta > toe.alpha && toe.alpha > limit;
      const double highest = peak_ahead ? toe.p_squared : std::max(potential(limit), potential(state_.theta));
      if (energy < highest) {
        // Turns where the potential equals the energy.
        const double gap = std::acos(std::clamp(energy / toe.p_squared, -1.0, 1.0));
        state_ = {rising > 0.0 ? toe.alpha - gap : toe.alpha + gap, 0.0};
        note_peak();
        // Back through the other end of the toe's range.
        if (!pass(rising > 0.0 ? lower() : upper(), energy, rising < 0.0)) break;
        continue;
      }
      if (!pass(limit, energy, rising > 0.0)) break;
    }
    const double theta = state_.theta;
    if (!result_.overturned && (theta > topple_.up || theta < topple_.down)) overturn(end_time());
  }

  // Reaches `limit` of the toe's range in free motion; false where that is the stop, or no move at all.
  bool pass(double limit, double energy, bool rising) {
    const Toe& toe = profile_.toes[toe_];
    if (std::abs(limit) >= stop_) {
      state_ = {limit, 0.0};
      note_peak();
      overturn(end_time());
      return false;
    }
    const double rate = std::sqrt(std::max(0.0, 2.0 * (energy - toe.p_squared * std::cos(toe.alpha - limit))));
    state_ = {limit, rising ? rate : -rate};
    direction_ = rising ? 1 : -1;
    note_peak();
    impact({0.0, 0.0, 0.0, 0.0}, 0.0);
    return true;
  }

  // On two toes without motion of the ground: false where it stays.
  bool leave_rest() {
    const double theta = profile_.switches[switch_];
    const double up = -profile_.toes[switch_ + 1].p_squared * restoring(profile_.toes[switch_ + 1], theta, 0.0, 0.0);
    const double down = profile_.toes[switch_].p_squared * restoring(profile_.toes[switch_], theta, 0.0, 0.0);
    if (up <= 0.0 && down <= 0.0) return false;
    resting_ = false;
    toe_ = up >= down ? switch_ + 1 : switch_;
    state_ = {theta, 0.0};
    return true;
  }

  [[nodiscard]] double end_time() const { return input_.dt * static_cast<double>(input_.horizontal.size() - 1); }

  void note_uplift(double time) {
    if (!result_.rocked) result_.first_uplift_s = time;
    result_.rocked = true;
  }
  void note_peak() { note_peak(state_.theta); }
  void note_peak(double theta) {
    const double held = std::clamp(theta, -stop_, stop_);
    result_.peak_up = std::max(result_.peak_up, held / topple_.up);
    result_.peak_down = std::max(result_.peak_down, held / topple_.down);
  }
  // The peak lies inside the step.
  void note_turn(const Step& step, double share, double rate_before) {
    if (!history_ && !(rate_before * state_.rate < 0.0)) return;
    if (rate_before * state_.rate < 0.0)
      note_peak(step.dense(root([&](double s) { return step.dense(s).rate; }, 0.0, share)).theta);
  }
  void overturn(double time) {
    result_.overturned = true;
    result_.side = state_.theta > 0.0 ? 1 : -1;
    result_.overturning_time_s = time;
  }
  void record(double time) {
    if (history_) history_->push_back({time, state_.theta, state_.rate});
  }

  const RockingProfile& profile_;
  const RockingInput& input_;
  std::vector<RockingSample>* history_;
  TopplingAngles topple_;
  double stop_, tolerance_, max_step_, angle_scale_;
  State state_;
  bool resting_ = false;
  std::size_t toe_ = 0, switch_ = 0;
  int direction_ = 0;
  bool crossed_ = false;
  double next_length_ = kNoLimit;
  RockingResult result_;
};

void require(bool ok, const char* what) {
  if (!ok) throw base::Error(base::ErrorCode::invalid_argument, what);
}

}  // namespace

void RockingOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("rocking-tolerance", tolerance, 1e-12, 1e-3, "Error of one step, relative to the toppling angle");
  visitor.real("rocking-max-step-s", max_step_s, 0.0, 1.0, "Longest step; 0 = one step of the record");
  visitor.real("rocking-stop-deg", stop_angle_deg, 30.0, 90.0, "Rotation beyond which a body has overturned");
}

RockingResult rock(const RockingProfile& profile, const RockingInput& input, const RockingOptions& options,
                   std::vector<RockingSample>* history) {
  validate(profile);
  require(input.horizontal.size() >= 2 && input.dt > 0.0 && std::isfinite(input.dt),
          "a record needs two samples and a positive step");
  require(input.vertical.empty() || input.vertical.size() == input.horizontal.size(),
          "the vertical record has another number of samples than the horizontal one");
  require(std::isfinite(input.scale) && std::isfinite(input.theta) && std::isfinite(input.rate),
          "scale and initial state must be finite");
  return Rocker(profile, input, options, history).run();
}

}  // namespace cairn::fragility
