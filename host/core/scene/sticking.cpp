// The forces and modes of sticking.hpp.
#include "scene/sticking.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace serpenoid {

namespace {
struct RestTuning {
    double speed = 1e-3;       // speed of a wheel that may rest, over a step's tolerance
    double tolerance = 1e-10;  // least tolerance: with a smaller one that speed is rounding
    double excess = 1e-6;      // excess of the force over its bound at the end of rest, relative
    // Share of its bound by which rounding may leave the sum of all forces on a contact that rests.
    // With 1e-12 wheels that hold each other were let go and caught again, hundreds of times at
    // once.
    double force_rounding = 1e-8;
    // Speeds over the one that may rest: backward at the end of a slide; of a wheel that rests; of
    // one that just reversed.
    double backward = 0.1, creep = 100, reversed = 1e3;
};
constexpr RestTuning kRest;
}  // namespace

Sticking::Sticking(Mechanics& mechanics, const RunRequest& request)
    : mechanics_(mechanics),
      chain_(mechanics.chain),
      along_(request.ground.along),
      length_(2 * request.robot.l),
      at_rest_(kRest.speed * std::max(mode_tolerance(request), kRest.tolerance) * request.robot.n *
               length_ * rate_unit(request)) {
    const double force_scale = request.robot.n * request.robot.m * request.robot.n * length_ *
                               rate_unit(request) * rate_unit(request);
    const WheelLaw& across = request.ground.across;
    for (int i = 0; i < chain_.n(); ++i) {
        if (along_.has_modes())
            contacts_.push_back(
                {i, Kind::along, along_.bound(), along_.breakaway_ratio(force_scale)});
        if (across.has_modes()) contacts_.push_back({i, Kind::across, across.bound(), 1});
    }
    for (int i = 0; i + 1 < chain_.n() && gear_friction(request) > 0; ++i)
        if (request.faults.empty() || request.faults[i] == Fault::none)
            contacts_.push_back({i, Kind::gear, gear_friction(request) / length_, 1});
    for (std::size_t w = 0; w < contacts_.size(); ++w) resting_.push_back(static_cast<int>(w));
}

double Sticking::speed(const Contact& w) const {
    const int i = w.link;
    if (w.kind == Kind::gear) return length_ * (chain_.omega[i + 1] - chain_.omega[i]);
    return w.kind == Kind::across ? chain_.c[i] * chain_.vy[i] - chain_.s[i] * chain_.vx[i]
                                  : chain_.c[i] * chain_.vx[i] + chain_.s[i] * chain_.vy[i];
}

// d/dt of speed(), the turning of the direction included.
double Sticking::acceleration(const Contact& w) const {
    const int i = w.link;
    const double c = chain_.c[i], s = chain_.s[i], turn = chain_.omega[i];
    if (w.kind == Kind::gear) return length_ * (chain_.alpha[i + 1] - chain_.alpha[i]);
    if (w.kind == Kind::across)
        return c * chain_.ay[i] - s * chain_.ax[i] - turn * (c * chain_.vx[i] + s * chain_.vy[i]);
    return c * chain_.ax[i] + s * chain_.ay[i] + turn * (c * chain_.vy[i] - s * chain_.vx[i]);
}

// Add a force, a part of the bound, on a link in one of its directions or on a joint's drive.
void Sticking::add_force(const Contact& w, double part) {
    const int i = w.link;
    const double f = part * w.dry;
    if (w.kind == Kind::gear) {
        mechanics_.driven[i] -= f * length_;
        return;
    }
    const bool across = w.kind == Kind::across;
    chain_.fx[i] += f * (across ? -chain_.s[i] : chain_.c[i]);
    chain_.fy[i] += f * (across ? chain_.c[i] : chain_.s[i]);
}

// The forces without those of what rests.
void Sticking::release() {
    chain_.fx = free_x_;
    chain_.fy = free_y_;
    mechanics_.driven = free_T_;
}

// Add a ratchet's friction that differs from the mean of both directions.
void Sticking::add_ratchet(const Contact& w) {
    const int i = w.link;
    const double more = along_.viscous(w.sign) - along_.viscous(0);
    const double f = along_.thrust() - more * speed(w);
    chain_.fx[i] += f * chain_.c[i];
    chain_.fy[i] += f * chain_.s[i];
}

// All forces but those of what rests, and the accelerations by them.
void Sticking::slide(double t, const double* y) {
    mechanics_.load(t, y);
    for (const Contact& w : contacts_) {
        if (w.kind == Kind::along) add_ratchet(w);
        if (w.sign != 0) add_force(w, -w.sign);
    }
    mechanics_.accelerate();
    free_x_ = chain_.fx;
    free_y_ = chain_.fy;
    free_T_ = mechanics_.driven;
}

// W by columns and rows, each times its bound, and a times the bound; slide() has been called.
void Sticking::respond(const std::vector<int>& which) {
    const std::size_t k = which.size();
    response_.resize(k * k);
    pull_.resize(k);
    free_acceleration_.resize(k);
    for (std::size_t i = 0; i < k; ++i) free_acceleration_[i] = acceleration(contacts_[which[i]]);
    for (std::size_t j = 0; j < k; ++j) {
        release();
        add_force(contacts_[which[j]], 1);
        mechanics_.accelerate();
        for (std::size_t i = 0; i < k; ++i) {
            const Contact& w = contacts_[which[i]];
            response_[i * k + j] = w.dry * (acceleration(w) - free_acceleration_[i]);
        }
    }
    for (std::size_t i = 0; i < k; ++i) {
        pull_[i] = contacts_[which[i]].dry * free_acceleration_[i];
        for (std::size_t j = 0; j < i; ++j)
            response_[i * k + j] = response_[j * k + i] =
                0.5 * (response_[i * k + j] + response_[j * k + i]);
    }
}

// Add share_ to the forces, and take the accelerations by all of them.
void Sticking::hold(const std::vector<int>& which) {
    release();
    for (std::size_t i = 0; i < which.size(); ++i) add_force(contacts_[which[i]], share_[i]);
    mechanics_.accelerate();
}

// What the forces on all that rests are, as parts of their bounds.
void Sticking::find_shares(double t, const double* y) {
    slide(t, y);
    if (resting_.empty()) return;
    respond(resting_);
    box_.minimise_free(response_, pull_, share_);
}

void Sticking::forces(double t, const double* y) {
    find_shares(t, y);
    if (!resting_.empty()) hold(resting_);
    mechanics_.find_joint_forces();
}

// Impulses that leave no speed: the response to a force for a second is that to its impulse.
void Sticking::put_to_rest(const std::vector<int>& which, double* y) {
    const std::size_t k = which.size();
    std::vector<double> moving(k);
    for (std::size_t i = 0; i < k; ++i)
        moving[i] = contacts_[which[i]].dry * speed(contacts_[which[i]]);
    release();
    mechanics_.accelerate();
    const std::vector<double> ax = chain_.ax, ay = chain_.ay, alpha = chain_.alpha;
    box_.minimise_free(response_, moving, share_);
    hold(which);
    for (int i = 0; i < chain_.n(); ++i) {
        chain_.vx[i] += chain_.ax[i] - ax[i];
        chain_.vy[i] += chain_.ay[i] - ay[i];
        chain_.omega[i] += chain_.alpha[i] - alpha[i];
    }
    mechanics_.write_state(chain_, y);
}

void Sticking::find(double t, double* y) {
    mechanics_.fill_chain(t, y);
    std::vector<int> slow;
    std::vector<double> share;
    std::vector<int> went;  // which way before
    for (std::size_t w = 0; w < contacts_.size(); ++w) {
        const double v = speed(contacts_[w]);
        const bool rested = contacts_[w].sign == 0 && has_modes_;
        // time has a resolution: under strong forces the speed passes at_rest within it
        const bool turned = has_modes_ && contacts_[w].sign * v < 0;
        const double slowly = (turned ? kRest.reversed : 1) * at_rest_;
        if (contacts_[w].dry > 0 && (rested || std::fabs(v) <= slowly)) {
            slow.push_back(static_cast<int>(w));
            share.push_back(rested ? contacts_[w].share : -contacts_[w].sign);
            went.push_back(has_modes_ ? contacts_[w].sign : 0);
            contacts_[w].sign = 0;
        } else {
            contacts_[w].sign = v > 0 || (v == 0 && contacts_[w].sign >= 0) ? 1 : -1;
        }
        contacts_[w].wrong = 0;
    }
    has_modes_ = true;
    resting_.clear();
    if (slow.empty()) return;
    slide(t, y);
    respond(slow);
    put_to_rest(slow, y);
    slide(t, y);
    respond(slow);
    box_.minimise(response_, pull_, share);
    for (std::size_t i = 0; i < slow.size(); ++i) {
        Contact& w = contacts_[slow[i]];
        w.share = share[i];
        const bool stopped = share[i] == -went[i];  // errors would let it go on for a moment
        if (std::fabs(share[i]) == 1 && !(stopped && excess(share, i) <= 1e-10)) {
            w.sign = share[i] > 0 ? -1 : 1;
            // impulses cannot take the speed of more contacts than there are freedoms
            w.wrong = std::max(0.0, -w.sign * speed(w));
        } else {
            resting_.push_back(slow[i]);
        }
    }
}

// By how much of its bound the force on a contact would have to be larger for the contact to rest;
// respond() has been called.
double Sticking::excess(const std::vector<double>& share, std::size_t i) const {
    const std::size_t k = share.size();
    double pull = pull_[i];
    for (std::size_t j = 0; j < k; ++j) pull += response_[i * k + j] * share[j];
    return std::fabs(pull) / response_[i * k + i];
}

void Sticking::margins(double t, const double* y, std::vector<double>& margin) {
    resting_.empty() ? mechanics_.fill_chain(t, y) : find_shares(t, y);
    margin.assign(contacts_.size(), 0.0);
    for (std::size_t w = 0; w < contacts_.size(); ++w)
        if (contacts_[w].sign != 0)
            margin[w] = 1 + (contacts_[w].sign * speed(contacts_[w]) + contacts_[w].wrong) /
                                (kRest.backward * at_rest_);
    const std::vector<int>& resting = resting_;
    if (resting.empty()) return;
    const bool all_hold = others_hold();
    for (std::size_t i = 0; i < resting.size(); ++i) {
        Contact& w = contacts_[resting[i]];
        w.share = share_[i];
        margin[resting[i]] =
            1 + (all_hold ? 0 : w.breakaway_ratio * (1 - std::fabs(share_[i])) / kRest.excess);
    }
}

// Whether forces within the bounds hold all that rests, though the smallest ones do not: where more
// hold than are needed, others take what one of them cannot.
bool Sticking::others_hold() {
    const auto beyond = [](double z) { return std::fabs(z) > 1; };
    const std::size_t k = resting_.size();
    if (std::none_of(share_.begin(), share_.begin() + static_cast<long>(k), beyond)) return false;
    std::vector<double> within = share_;
    box_.minimise(response_, pull_, within);
    for (std::size_t i = 0; i < k; ++i)
        if (excess(within, i) > kRest.force_rounding) return false;
    share_ = within;
    return true;
}

bool Sticking::creeps(double t, const double* y) {
    mechanics_.fill_chain(t, y);
    return std::any_of(resting_.begin(), resting_.end(), [&](int w) {
        return std::fabs(speed(contacts_[w])) > kRest.creep * at_rest_;
    });
}

}  // namespace serpenoid
