// The torque of one joint over a cycle as a sum of modes, and its work.
//
// The torque T = Re sum t_p exp(i p tau) has odd modes only, the joint's rate is Re r exp(i tau).
// So the power's integral is known in closed form, and that of its size is the sum of its changes
// from one change of sign to the next, as absolute values. It hardly depends on where these are.
#pragma once

#include <algorithm>

#include "numerics/bracketed_root.hpp"
#include "periodic/viscous/spectral_mesh.hpp"

namespace serpenoid {

class TorqueSeries {
  public:
    using Complex = std::complex<double>;

    // From the torque at the nodes.
    TorqueSeries(const SpectralMesh& mesh, const double* torque, Complex rate)
        : mesh_(mesh), torque_(torque), rate_(rate), mode_(mesh.nodes / 2), work_(mode_.size()) {
        for (std::size_t p = 0; p < mode_.size(); ++p)
            for (int k = 0; k < mesh.nodes; ++k)
                mode_[p] += torque[k] * mesh.modes[p * mesh.nodes + k];
        mean_ = (mode_[0] * std::conj(rate)).real() / 2;
        for (std::size_t p = 0; p < mode_.size(); ++p) {
            const Complex next = p + 1 < mode_.size() ? mode_[p + 1] : 0;
            work_[p] = (mode_[p] * rate + next * std::conj(rate)) / (4.0 * (p + 1));
        }
    }

    // Mean of |T times rate|.
    double mean_absolute() {
        changes_.assign(1, std::numbers::pi / 2 - std::arg(rate_));
        changes_[0] -= std::numbers::pi * std::floor(changes_[0] / std::numbers::pi);
        find_changes();
        std::sort(changes_.begin(), changes_.end());
        double last = work(changes_.back()) - std::numbers::pi * mean_;
        double sum = 0;
        for (const double change : changes_) {
            const double value = work(change);
            sum += std::fabs(value - last);
            last = value;
        }
        return sum / std::numbers::pi;
    }

    // How much of that the modes may hide that no node resolves, by the last two.
    double hidden() const {
        constexpr double kHidden = 0.6;  // of the last two modes: modes fall off geometrically
        const auto last = mode_.end();
        return kHidden * std::abs(rate_) * std::sqrt(std::norm(last[-1]) + std::norm(last[-2]));
    }

  private:
    // The sum of such modes times exp(2 i tau k), k = 0, 1, ...
    static Complex sum(const std::vector<Complex>& modes, Complex once) {
        const Complex twice = once * once;
        Complex total = modes.back();
        for (std::size_t p = modes.size() - 1; p-- > 0;) total = total * twice + modes[p];
        return total;
    }
    double torque(double tau) const {
        const Complex once = std::polar(1.0, tau);
        return (sum(mode_, once) * once).real();
    }
    // Integral of the power.
    double work(double tau) const {
        const Complex once = std::polar(1.0, tau);
        return mean_ * tau + (sum(work_, once) * once * once).imag();
    }

    // Where the torque changes its sign. A cubic has no more roots between two nodes than its
    // Bezier points, of the nodes' values and slopes, have changes of sign.
    void find_changes() {
        constexpr double kCloseRoot = 1e-4;  // of the torque
        constexpr int kParts = 16;           // of a step, where a pair of roots may be
        for (int k = 0; k < mesh_.nodes; ++k) {
            const double values[] = {value(k), value(k) + third_of_slope(k),
                                     value(k + 1) - third_of_slope(k + 1), value(k + 1)};
            int changes = 0;
            for (int i = 0; i < 3; ++i) changes += (values[i] > 0) != (values[i + 1] > 0);
            // at a node that is next to a root another one may be beside it
            const double smallest = std::min(std::fabs(values[0]), std::fabs(values[3]));
            const bool close = changes > 1 || smallest < kCloseRoot * std::abs(mode_[0]);
            if (changes > 0) search(k * mesh_.step, values[0], values[3], close ? kParts : 1);
        }
    }
    // A third of the slope at a node, per step: centred, of fourth order.
    double third_of_slope(int k) const {
        return (value(k + 1) - value(k - 1)) * 2 / 9 - (value(k + 2) - value(k - 2)) / 36;
    }
    // Roots after a node, also close pairs, by the signs at so many places, denser at both ends.
    void search(double tau, double start, double end, int parts) {
        constexpr double kRootError = 1e-6;  // of the torque: the work misses its square
        const auto at_phase = [this](double phase) { return torque(phase); };
        double last_phase = tau, last_torque = start;
        for (int i = 1; i <= parts; ++i) {
            const double phase =
                tau + mesh_.step * (1 - std::cos(std::numbers::pi * i / parts)) / 2;
            const double next_torque = i < parts ? torque(phase) : end;
            if ((last_torque > 0) != (next_torque > 0))
                changes_.push_back(bracketed_root(at_phase, last_phase, last_torque, phase,
                                                  next_torque, kRootError * std::abs(mode_[0])));
            last_phase = phase;
            last_torque = next_torque;
        }
    }
    // The torque at a node, also beyond the half cycle: there it has changed its sign. Zero has
    // one.
    double value(int k) const {
        const int node = (k + mesh_.nodes) % mesh_.nodes;
        const double torque = torque_[node] == 0 ? 1e-300 : torque_[node];
        return node == k ? torque : -torque;
    }

    const SpectralMesh& mesh_;
    const double* torque_;
    Complex rate_;
    std::vector<Complex> mode_, work_;
    std::vector<double> changes_;  // of the power's sign
    double mean_;
};

}  // namespace serpenoid
