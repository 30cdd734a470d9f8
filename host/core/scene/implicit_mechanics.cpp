// The implicit model.
#include <algorithm>
#include <complex>
#include <numeric>
#include <vector>

#include "numerics/symmetric_factors.hpp"
#include "scene/mechanics.hpp"

namespace serpenoid {

namespace {

double mean(const std::vector<double>& values) {
    return std::reduce(values.begin(), values.end()) / values.size();
}

// Coordinates: x, y of the centre of mass, the gaps of all joints (x of each, then y of each),
// theta of link 1, the free joints' angles. Stiff springs have tiny gaps: as states of their own
// they keep all their digits. Of the centre every method keeps the momentum to rounding, as joint
// forces come in pairs.
class ImplicitMechanics final : public Mechanics {
  public:
    ImplicitMechanics(const RunRequest& request, const Ground& ground, MixedDrive joint_drive,
                      std::unique_ptr<TorqueSource> torques)
        : Mechanics(request, ground, 2 * request.robot.n, 1 + joint_drive.free_joints()),
          spring(request.spring),
          damper(request.robot.n, request.method.lags_damping),
          drive(std::move(joint_drive)),
          source(std::move(torques)),
          scratch(request.robot.n) {
        gaps.resize(request.robot.n - 1);
    }

    void write_state(const Chain& c, double* y) const override {
        const int n = robot.n;
        double* rate = y + coordinates;
        y[0] = mean(c.x);
        y[1] = mean(c.y);
        rate[0] = mean(c.vx);
        rate[1] = mean(c.vy);
        for (int i = 0; i + 1 < n; ++i) {
            const Gap g = gap(c, robot.l, i);
            y[2 + i] = g.x;
            y[n + 1 + i] = g.y;
            rate[2 + i] = g.vx;
            rate[n + 1 + i] = g.vy;
        }
        double* angle = y + lengths;
        angle[0] = c.theta[0];
        angle[coordinates] = c.omega[0];
        drive.free_angles(c.theta, angle + 1);
        drive.free_angles(c.omega, angle + coordinates + 1);
    }
    void fill_chain(double t, const double* y) override {
        const double* angle = y + lengths;
        const double* rate = angle + coordinates;
        drive.place(t, angle[0], rate[0], angle + 1, rate + 1, chain);
        fill_lengths(y);
    }
    void load(double t, const double* y) override {
        fill_chain(t, y);
        chain.apply_ground(ground, robot.m * slope.gx, robot.m * slope.gy);
        spring_forces(spring, damper, gaps, joints);
        source->torques(t, chain, driven.data());
        drive.limp(driven.data());
    }
    void accelerate() override {
        joints.T = driven;
        implicit_mixed(robot, drive.imposed(), drive.rotor(), drive.joint_accel(), scratch, chain,
                       joints);
    }
    void derivative(const double* y, double* dy) const override {
        const Chain& k = chain;
        const int n = robot.n;
        std::copy_n(y + coordinates, coordinates, dy);
        double* accel = dy + coordinates;
        accel[0] = mean(k.ax);
        accel[1] = mean(k.ay);
        const auto tangential = [&](int i) { return k.omega[i] * k.omega[i]; };
        for (int i = 0; i + 1 < n; ++i) {
            const int j = i + 1;
            accel[2 + i] = k.ax[j] - k.ax[i] +
                           robot.l * (k.alpha[j] * k.s[j] + tangential(j) * k.c[j] +
                                      k.alpha[i] * k.s[i] + tangential(i) * k.c[i]);
            accel[n + 1 + i] = k.ay[j] - k.ay[i] -
                               robot.l * (k.alpha[j] * k.c[j] - tangential(j) * k.s[j] +
                                          k.alpha[i] * k.c[i] - tangential(i) * k.s[i]);
        }
        accel[lengths] = k.alpha[0];
        drive.free_angles(k.alpha, accel + lengths + 1);
    }
    double next_jump(double t) const override { return source->next_jump(t); }
    void handle_jump(double t, const double* y) override {
        fill_chain(t, y);
        source->handle_jump(t, chain);
    }
    void latch() override { damper.latch(gaps); }
    std::unique_ptr<StepEquations> step_equations() override;

  private:
    friend class SpringEquations;
    // For a chain that has its angles, rates and directions.
    void fill_lengths(const double* y) {
        const int n = robot.n;
        const double* rate = y + coordinates;
        chain.x[0] = y[0];
        chain.y[0] = y[1];
        chain.vx[0] = rate[0];
        chain.vy[0] = rate[1];
        for (int i = 0; i + 1 < n; ++i)
            gaps[i] = {y[2 + i], y[n + 1 + i], rate[2 + i], rate[n + 1 + i]};
        chain.follow(robot.l, gaps.data());
        centre(chain.x, y[0]);
        centre(chain.y, y[1]);
        centre(chain.vx, rate[0]);
        centre(chain.vy, rate[1]);
    }
    // The links' rates of turning, by those of the coordinates; the drive's own left out.
    void turn_links(const double* rate) {
        double turn = rate[lengths];
        rate += lengths + 1;
        for (int i = 0; i < robot.n; ++i) {
            chain.omega[i] = turn;
            if (i + 1 < robot.n && !drive.imposed()[i]) turn += *rate++;
        }
    }
    // Derivatives of the joints' torques by their angles and rates, at a state that is loaded.
    void torque_slopes(double t, std::vector<double>& by_angle, std::vector<double>& by_rate) {
        const double difference = 1e-6;  // rad, rad/s
        const auto slopes = [&](std::vector<double>& values, std::vector<double>& slope) {
            const std::vector<double> saved_values = values;
            for (int i = 0; i < robot.n; ++i) values[i] += i * difference;
            slope.resize(driven.size());
            source->torques(t, chain, slope.data());
            for (std::size_t i = 0; i < slope.size(); ++i)
                slope[i] = (slope[i] - driven[i]) / difference;
            values = saved_values;
        };
        slopes(chain.theta, by_angle);
        slopes(chain.omega, by_rate);
    }
    static void centre(std::vector<double>& values, double place) {
        const double shift = place - mean(values);
        for (double& value : values) value += shift;
    }

    JointSpring spring;
    Damper damper;
    MixedDrive drive;
    std::unique_ptr<TorqueSource> source;
    std::vector<double> scratch;
};

// The equations of a step of links that are joined by springs, in the velocities of the links.
// Times the masses, their matrix is
//     s M + sum over all springs, dampers, servos and wheels of (c + k / s) g g^T.
// It is symmetric, its real part is positive definite, and each g has entries of two neighbouring
// links at most. Left out are the turning of the forces and centripetal accelerations, which are
// slow: the iteration finds them.
class SpringEquations final : public StepEquations {
  public:
    explicit SpringEquations(ImplicitMechanics& mechanics)
        : mechanics_(mechanics),
          links_(mechanics.robot.n),
          unknowns_(mechanics.coordinates == 2 * links_ + 1 ? 2 : 3),
          rates_(2 * mechanics.coordinates),
          first_(unknowns_ == 2 ? 2 * links_ + 1 : 3 * links_),
          real_(first_columns()),
          complex_(first_),
          real_force_(first_.size()),
          complex_force_(first_.size()) {}

    bool linearise(double t, const double* y, double real_s, Complex complex_s) override {
        mechanics_.load(t, y);
        cosine_ = mechanics_.chain.c;
        sine_ = mechanics_.chain.s;
        mechanics_.torque_slopes(t, by_angle_, by_rate_);
        return assemble(real_s, real_) && assemble(complex_s, complex_);
    }
    void solve(double* change) override { solve_links(real_, real_force_, change); }
    void solve(Complex* change) override { solve_links(complex_, complex_force_, change); }

  private:
    int place(int link) const { return unknowns_ * link; }
    int angle(int link) const { return unknowns_ == 2 ? 2 * links_ : 3 * link + 2; }
    const std::vector<int>& first_columns() {
        for (int row = 0; row < links_ * unknowns_; ++row)
            first_[row] = unknowns_ * std::max(row / unknowns_ - 1, 0);
        return first_;
    }

    template <class Scalar>
    bool assemble(Scalar s, SymmetricFactors<Scalar>& matrix) {
        struct Entry {
            int unknown;
            double value;
        };
        const Robot& r = mechanics_.robot;
        const JointSpring& spring = mechanics_.spring;
        matrix.clear();
        const auto add = [&](Scalar part, std::initializer_list<Entry> g) {
            for (const Entry& a : g)
                for (const Entry& b : g)
                    if (a.unknown >= b.unknown)
                        matrix.entry(a.unknown, b.unknown) += part * (a.value * b.value);
        };
        for (int i = 0; i < links_; ++i) {
            const int x = place(i), y = x + 1;
            add(r.m * s, {{x, 1}});
            add(r.m * s, {{y, 1}});
            add(r.I * s, {{angle(i), 1}});
            add(mechanics_.ground.along.c, {{x, cosine_[i]}, {y, sine_[i]}});
            add(mechanics_.ground.across.c, {{x, -sine_[i]}, {y, cosine_[i]}});
        }
        for (int i = 0; i + 1 < links_; ++i) {
            const int j = i + 1, x = place(i), y = x + 1, next_x = place(j), next_y = next_x + 1;
            const int turn = angle(i), next_turn = angle(j);
            const Scalar joint = spring.c + spring.k / s;
            add(joint, {{x, -1}, {next_x, 1}, {turn, r.l * sine_[i]}, {next_turn, r.l * sine_[j]}});
            add(joint,
                {{y, -1}, {next_y, 1}, {turn, -r.l * cosine_[i]}, {next_turn, -r.l * cosine_[j]}});
            add(by_rate_[i] + by_angle_[i] / s, {{turn, -1}, {next_turn, 1}});
        }
        return matrix.factor();
    }

    template <class Scalar>
    void solve_links(const SymmetricFactors<Scalar>& matrix, std::vector<Scalar>& force,
                     Scalar* change) {
        constexpr int parts = sizeof(Scalar) / sizeof(double);  // real, imaginary
        double* numbers = reinterpret_cast<double*>(change);
        double* forces = reinterpret_cast<double*>(force.data());
        const Robot& r = mechanics_.robot;
        Chain& k = mechanics_.chain;
        k.c = cosine_;
        k.s = sine_;
        const int count = mechanics_.coordinates;
        std::fill(force.begin(), force.end(), Scalar{});
        for (int part = 0; part < parts; ++part) {
            for (int i = 0; i < count; ++i) rates_[count + i] = numbers[parts * i + part];
            mechanics_.turn_links(&rates_[count]);
            mechanics_.fill_lengths(rates_.data());
            for (int i = 0; i < links_; ++i) {
                forces[parts * place(i) + part] = r.m * k.vx[i];
                forces[parts * (place(i) + 1) + part] = r.m * k.vy[i];
                forces[parts * angle(i) + part] += r.I * k.omega[i];
            }
        }
        matrix.solve(force);
        for (int part = 0; part < parts; ++part) {
            for (int i = 0; i < links_; ++i) {
                k.vx[i] = forces[parts * place(i) + part];
                k.vy[i] = forces[parts * (place(i) + 1) + part];
                k.omega[i] = forces[parts * angle(i) + part];
            }
            mechanics_.write_state(k, rates_.data());
            for (int i = 0; i < count; ++i) numbers[parts * i + part] = rates_[count + i];
        }
    }

    ImplicitMechanics& mechanics_;
    int links_, unknowns_;  // unknowns_: of a link; without its angle where one angle turns all
    std::vector<double> rates_;  // behind the places, of which nothing is asked
    std::vector<int> first_;
    std::vector<double> cosine_, sine_, by_angle_, by_rate_;
    SymmetricFactors<double> real_;
    SymmetricFactors<Complex> complex_;
    std::vector<double> real_force_;
    std::vector<Complex> complex_force_;
};

std::unique_ptr<StepEquations> ImplicitMechanics::step_equations() {
    return std::make_unique<SpringEquations>(*this);
}

}  // namespace

std::unique_ptr<Mechanics> make_implicit(const RunRequest& request, const Ground& ground,
                                         double gear_friction) {
    return std::make_unique<ImplicitMechanics>(request, ground, mixed_drive(request),
                                               make_torques(request, gear_friction));
}

}  // namespace serpenoid
