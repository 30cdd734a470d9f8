// The torque of one joint over a cycle as a Fourier series, and its work.
//
// The torque T = Re sum t_p exp(i p tau) has odd modes only, and the joint's rate is Re r exp(i
// tau). So the integral of the power, the work, has a closed form. The integral of |power| is the
// sum of |change of the work| between the phases at which the power changes its sign; errors of
// these phases hardly matter.
#pragma once

#include <algorithm>

#include "numerics/bracketed_root.hpp"
#include "periodic/viscous/spectral_mesh.hpp"

namespace serpenoid {

class TorqueSeries {
  public:
    using Complex = std::complex<double>;

    // torque: at the nodes of the mesh.
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
        double last_work = work(changes_.back()) - std::numbers::pi * mean_;
        double sum = 0;
        for (const double change : changes_) {
            const double next_work = work(change);
            sum += std::fabs(next_work - last_work);
            last_work = next_work;
        }
        return sum / std::numbers::pi;
    }

    // Estimated error of mean_absolute() by the modes that the mesh does not resolve.
    double truncation_error() const {
        const auto last = mode_.end();
        // The tail of a geometric series is 0.6 of its last two modes.
        return 0.6 * std::abs(rate_) * std::sqrt(std::norm(last[-1]) + std::norm(last[-2]));
    }

  private:
    // How roots of a torque are searched; work depends on them in second order.
    struct RootTuning {
        double close_root;  // value near a root, as a fraction of the first mode
        int parts;          // parts of a step in which a pair of roots may be
        double root_error;  // relative to the first mode; the work's error is its square
    };
    static constexpr RootTuning kRoots{1e-4, 16, 1e-6};

    // sum_k modes[k] exp(2 i tau k), by Horner's rule; wave = exp(i tau).
    static Complex sum(const std::vector<Complex>& modes, Complex wave) {
        const Complex squared = wave * wave;
        Complex total = modes.back();
        for (std::size_t p = modes.size() - 1; p-- > 0;) total = total * squared + modes[p];
        return total;
    }
    double torque(double tau) const {
        const Complex wave = std::polar(1.0, tau);
        return (sum(mode_, wave) * wave).real();
    }
    // The integral of the power over the phase.
    double work(double tau) const {
        const Complex wave = std::polar(1.0, tau);
        return mean_ * tau + (sum(work_, wave) * wave * wave).imag();
    }

    // Find the phases at which the torque changes its sign. Between two nodes the cubic of their
    // values and slopes has at most as many roots as its Bezier points have changes of sign.
    void find_changes() {
        for (int k = 0; k < mesh_.nodes; ++k) {
            const double values[] = {value(k), value(k) + third_of_slope(k),
                                     value(k + 1) - third_of_slope(k + 1), value(k + 1)};
            int changes = 0;
            for (int i = 0; i < 3; ++i) changes += (values[i] > 0) != (values[i + 1] > 0);
            // If a root is close to a node, a second one may be close to it too.
            const double smallest = std::min(std::fabs(values[0]), std::fabs(values[3]));
            const bool close = changes > 1 || smallest < kRoots.close_root * std::abs(mode_[0]);
            if (changes > 0) search(k * mesh_.step, values[0], values[3], close ? kRoots.parts : 1);
        }
    }
    // A third of the slope at a node times the step, by centred differences of order 4.
    double third_of_slope(int k) const {
        return (value(k + 1) - value(k - 1)) * 2 / 9 - (value(k + 2) - value(k - 2)) / 36;
    }
    // Find the roots between a node and the next from the signs at `parts` phases, denser at both
    // ends.
    void search(double tau, double start, double end, int parts) {
        const auto at_phase = [this](double phase) { return torque(phase); };
        double last_phase = tau, last_torque = start;
        for (int i = 1; i <= parts; ++i) {
            const double phase =
                tau + mesh_.step * (1 - std::cos(std::numbers::pi * i / parts)) / 2;
            const double next_torque = i < parts ? torque(phase) : end;
            if ((last_torque > 0) != (next_torque > 0))
                changes_.push_back(bracketed_root(at_phase, last_phase, last_torque, phase,
                                                  next_torque,
                                                  kRoots.root_error * std::abs(mode_[0])));
            last_phase = phase;
            last_torque = next_torque;
        }
    }
    // The torque at a node. Beyond the half cycle it has the opposite sign. Zero counts as
    // positive.
    double value(int k) const {
        const int node = (k + mesh_.nodes) % mesh_.nodes;
        const double torque = torque_[node] == 0 ? 1e-300 : torque_[node];
        return node == k ? torque : -torque;
    }

    const SpectralMesh& mesh_;
    const double* torque_;
    Complex rate_;
    std::vector<Complex> mode_, work_;
    std::vector<double> changes_;  // phases at which the power changes its sign
    double mean_;
};

}  // namespace serpenoid
