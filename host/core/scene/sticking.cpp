// Forces and modes of the contacts of sticking.hpp.
#include "scene/sticking.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace serpenoid {

namespace {
// When contacts begin and cease to rest; tests/host/simulation/test_sticking.py compares runs with
// the law itself and with closed forms.
struct RestTuning {
    double speed = 1e-3;       // speed below which a contact may rest, over the tolerance of a step
    double tolerance = 1e-10;  // least tolerance; a smaller one gives a speed like rounding errors
    double excess = 1e-6;      // excess of the force at the end of rest, over the bound
    // Sum of all forces on a resting contact that rounding may leave, over the bound. With 1e-12,
    // wheels that hold each other changed between rest and sliding hundreds of times at one
    // instant.
    double force_rounding = 1e-8;
    // Limits of speeds, over that of a contact that may rest: backward speed at the end of sliding,
    // speed of a resting contact, speed of a contact that has just reversed.
    double backward = 0.1, creep = 100, reversed = 1e3;
};
constexpr RestTuning kRest;
}  // namespace

Sticking::Sticking(Mechanics& mechanics, const RunRequest& request)
    : mechanics_(mechanics),
      chain_(mechanics.chain),
      along_(request.ground.along),
      length_(2 * request.robot.l),
      rest_speed_(kRest.speed * std::max(mode_tolerance(request), kRest.tolerance) *
                  request.robot.n * length_ * rate_unit(request)) {
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

double Sticking::speed(const Contact& contact) const {
    const int i = contact.link;
    if (contact.kind == Kind::gear) return length_ * (chain_.omega[i + 1] - chain_.omega[i]);
    return contact.kind == Kind::across ? chain_.c[i] * chain_.vy[i] - chain_.s[i] * chain_.vx[i]
                                        : chain_.c[i] * chain_.vx[i] + chain_.s[i] * chain_.vy[i];
}

// d/dt of speed(), including the rotation of the direction.
double Sticking::acceleration(const Contact& contact) const {
    const int i = contact.link;
    const double c = chain_.c[i], s = chain_.s[i], turn = chain_.omega[i];
    if (contact.kind == Kind::gear) return length_ * (chain_.alpha[i + 1] - chain_.alpha[i]);
    if (contact.kind == Kind::across)
        return c * chain_.ay[i] - s * chain_.ax[i] - turn * (c * chain_.vx[i] + s * chain_.vy[i]);
    return c * chain_.ax[i] + s * chain_.ay[i] + turn * (c * chain_.vy[i] - s * chain_.vx[i]);
}

// Add the force of a contact, given as a share of its bound, to its link or to the joint's torque.
void Sticking::add_force(const Contact& contact, double share) {
    const int i = contact.link;
    const double f = share * contact.dry;
    if (contact.kind == Kind::gear) {
        mechanics_.driven[i] -= f * length_;
        return;
    }
    const bool across = contact.kind == Kind::across;
    chain_.fx[i] += f * (across ? -chain_.s[i] : chain_.c[i]);
    chain_.fy[i] += f * (across ? chain_.c[i] : chain_.s[i]);
}

// Restore the forces without those of resting contacts.
void Sticking::remove_rest_forces() {
    chain_.fx = free_x_;
    chain_.fy = free_y_;
    mechanics_.driven = free_T_;
}

// Add the difference of a ratchet's friction from the mean of both directions.
void Sticking::add_ratchet(const Contact& contact) {
    const int i = contact.link;
    const double extra = along_.viscous(contact.sign) - along_.viscous(0);
    const double f = along_.thrust() - extra * speed(contact);
    chain_.fx[i] += f * chain_.c[i];
    chain_.fy[i] += f * chain_.s[i];
}

// Load all forces except those of resting contacts, and compute the accelerations.
void Sticking::load_free_forces(double t, const double* y) {
    mechanics_.load(t, y);
    for (const Contact& contact : contacts_) {
        if (contact.kind == Kind::along) add_ratchet(contact);
        if (contact.sign != 0) add_force(contact, -contact.sign);
    }
    mechanics_.accelerate();
    free_x_ = chain_.fx;
    free_y_ = chain_.fy;
    free_T_ = mechanics_.driven;
}

// Compute response_ = mu W mu and scaled_acceleration_ = mu a of the given contacts, after
// load_free_forces().
void Sticking::set_response(const std::vector<int>& indices) {
    const std::size_t k = indices.size();
    response_.resize(k * k);
    scaled_acceleration_.resize(k);
    free_acceleration_.resize(k);
    for (std::size_t i = 0; i < k; ++i) free_acceleration_[i] = acceleration(contacts_[indices[i]]);
    for (std::size_t j = 0; j < k; ++j) {
        remove_rest_forces();
        add_force(contacts_[indices[j]], 1);
        mechanics_.accelerate();
        for (std::size_t i = 0; i < k; ++i) {
            const Contact& contact = contacts_[indices[i]];
            response_[i * k + j] = contact.dry * (acceleration(contact) - free_acceleration_[i]);
        }
    }
    for (std::size_t i = 0; i < k; ++i) {
        scaled_acceleration_[i] = contacts_[indices[i]].dry * free_acceleration_[i];
        for (std::size_t j = 0; j < i; ++j)
            response_[i * k + j] = response_[j * k + i] =
                0.5 * (response_[i * k + j] + response_[j * k + i]);
    }
}

// Add the rest forces given by share_, and compute the accelerations by all forces.
void Sticking::add_rest_forces(const std::vector<int>& indices) {
    remove_rest_forces();
    for (std::size_t i = 0; i < indices.size(); ++i) add_force(contacts_[indices[i]], share_[i]);
    mechanics_.accelerate();
}

// Find the forces of the resting contacts, as shares of their bounds, without regard to the bounds.
void Sticking::find_shares(double t, const double* y) {
    load_free_forces(t, y);
    if (resting_.empty()) return;
    set_response(resting_);
    box_.minimise_free(response_, scaled_acceleration_, share_);
}

void Sticking::forces(double t, const double* y) {
    find_shares(t, y);
    if (!resting_.empty()) add_rest_forces(resting_);
    mechanics_.find_joint_forces();
}

// Stop the contacts by impulses. The response to a force during 1 s is that to an impulse.
void Sticking::put_to_rest(const std::vector<int>& indices, double* y) {
    const std::size_t k = indices.size();
    std::vector<double> speeds(k);
    for (std::size_t i = 0; i < k; ++i)
        speeds[i] = contacts_[indices[i]].dry * speed(contacts_[indices[i]]);
    remove_rest_forces();
    mechanics_.accelerate();
    const std::vector<double> ax = chain_.ax, ay = chain_.ay, alpha = chain_.alpha;
    box_.minimise_free(response_, speeds, share_);
    add_rest_forces(indices);
    for (int i = 0; i < chain_.n(); ++i) {
        chain_.vx[i] += chain_.ax[i] - ax[i];
        chain_.vy[i] += chain_.ay[i] - ay[i];
        chain_.omega[i] += chain_.alpha[i] - alpha[i];
    }
    mechanics_.write_state(chain_, y);
}

void Sticking::find_modes(double t, double* y) {
    mechanics_.fill_chain(t, y);
    std::vector<int> slow;
    std::vector<double> share;
    std::vector<int> last_sign;
    for (std::size_t w = 0; w < contacts_.size(); ++w) {
        const double v = speed(contacts_[w]);
        const bool rested = contacts_[w].sign == 0 && has_modes_;
        // Under strong forces the speed exceeds rest_speed_ within the resolution of time.
        const bool reversed = has_modes_ && contacts_[w].sign * v < 0;
        const double limit = (reversed ? kRest.reversed : 1) * rest_speed_;
        if (contacts_[w].dry > 0 && (rested || std::fabs(v) <= limit)) {
            slow.push_back(static_cast<int>(w));
            share.push_back(rested ? contacts_[w].share : -contacts_[w].sign);
            last_sign.push_back(has_modes_ ? contacts_[w].sign : 0);
            contacts_[w].sign = 0;
        } else {
            contacts_[w].sign = v > 0 || (v == 0 && contacts_[w].sign >= 0) ? 1 : -1;
        }
        contacts_[w].reverse_speed = 0;
    }
    has_modes_ = true;
    resting_.clear();
    if (slow.empty()) return;
    load_free_forces(t, y);
    set_response(slow);
    put_to_rest(slow, y);
    load_free_forces(t, y);
    set_response(slow);
    box_.minimise(response_, scaled_acceleration_, share);
    for (std::size_t i = 0; i < slow.size(); ++i) {
        Contact& contact = contacts_[slow[i]];
        contact.share = share[i];
        // A contact that just stopped may need the whole bound; rounding must not let it slide on.
        const bool stopped = share[i] == -last_sign[i];
        if (std::fabs(share[i]) == 1 && !(stopped && excess(share, i) <= 1e-10)) {
            contact.sign = share[i] > 0 ? -1 : 1;
            // Impulses cannot stop more contacts than there are degrees of freedom.
            contact.reverse_speed = std::max(0.0, -contact.sign * speed(contact));
        } else {
            resting_.push_back(slow[i]);
        }
    }
}

// The force that a contact lacks to stay at rest, over its bound; call set_response() first.
double Sticking::excess(const std::vector<double>& share, std::size_t i) const {
    const std::size_t k = share.size();
    double pull = scaled_acceleration_[i];
    for (std::size_t j = 0; j < k; ++j) pull += response_[i * k + j] * share[j];
    return std::fabs(pull) / response_[i * k + i];
}

void Sticking::margins(double t, const double* y, std::vector<double>& margin) {
    resting_.empty() ? mechanics_.fill_chain(t, y) : find_shares(t, y);
    margin.assign(contacts_.size(), 0.0);
    for (std::size_t w = 0; w < contacts_.size(); ++w)
        if (contacts_[w].sign != 0)
            margin[w] = 1 + (contacts_[w].sign * speed(contacts_[w]) + contacts_[w].reverse_speed) /
                                (kRest.backward * rest_speed_);
    const std::vector<int>& resting = resting_;
    if (resting.empty()) return;
    const bool all_rest = find_bounded_shares();
    for (std::size_t i = 0; i < resting.size(); ++i) {
        Contact& contact = contacts_[resting[i]];
        contact.share = share_[i];
        margin[resting[i]] =
            1 +
            (all_rest ? 0 : contact.breakaway_ratio * (1 - std::fabs(share_[i])) / kRest.excess);
    }
}

// If the least forces exceed a bound, find others within the bounds that also keep all contacts at
// rest: this may be possible if there are more contacts than needed. Whether there are such forces.
bool Sticking::find_bounded_shares() {
    const auto beyond = [](double z) { return std::fabs(z) > 1; };
    const std::size_t k = resting_.size();
    if (std::none_of(share_.begin(), share_.begin() + static_cast<long>(k), beyond)) return false;
    std::vector<double> within = share_;
    box_.minimise(response_, scaled_acceleration_, within);
    for (std::size_t i = 0; i < k; ++i)
        if (excess(within, i) > kRest.force_rounding) return false;
    share_ = within;
    return true;
}

bool Sticking::creeps(double t, const double* y) {
    mechanics_.fill_chain(t, y);
    return std::any_of(resting_.begin(), resting_.end(), [&](int w) {
        return std::fabs(speed(contacts_[w])) > kRest.creep * rest_speed_;
    });
}

}  // namespace serpenoid
