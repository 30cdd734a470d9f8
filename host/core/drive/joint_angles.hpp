// Joints that follow the gait, joints driven by torque, and the angles of the first.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "model/chain.hpp"
#include "model/gait.hpp"
#include "numerics/pack.hpp"

namespace serpenoid {

// All joints follow the gait (Eq. 57).
class GaitDrive {
  public:
    GaitDrive(int links, const Gait& g)
        : omega_(g.omega),
          table_(links, g),
          accel_(links - 1),
          turn_((links + kPack - 1) / kPack * kPack),
          rate_(turn_),
          cos_(turn_),
          sin_(turn_) {}

    // Angles, directions and rates of all links from those of link 1; keeps phi''.
    void place(double t, double theta1, double omega1, Chain& k) {
        Pack sines, cosines;
        sincos(Pack{theta1, omega_ * t}, sines, cosines);
        const double c = cosines[0], s = sines[0];
        if (t != shape_t_) set_shape(t, sines[1], cosines[1]);
        for (int i = 0; i < k.n(); ++i) {
            k.theta[i] = theta1 + turn_[i];
            k.omega[i] = omega1 + rate_[i];
            k.c[i] = c * cos_[i] - s * sin_[i];
            k.s[i] = s * cos_[i] + c * sin_[i];
        }
    }
    const double* joint_accel() const { return accel_.data(); }

  private:
    // Stages of a step share their times: the shape is kept until another time is asked for.
    // The links' angles from link 1, their cosines and sines, and the rates of these angles.
    void set_shape(double t, double sine, double cosine) {
        shape_t_ = t;
        const GaitWave wave = table_.wave(omega_, sine, cosine);
        double turn = 0, rate = 0;
        for (int i = 0; i < table_.joints(); ++i) {
            const GaitWave::Joint joint = wave.joint(i);
            turn += joint.angle;
            rate += joint.rate;
            turn_[i + 1] = turn;
            rate_[i + 1] = rate;
            accel_[i] = joint.acceleration;
        }
        for (std::size_t i = 0; i < turn_.size(); i += kPack)
            sincos(pack_at(&turn_[i]), pack_at(&sin_[i]), pack_at(&cos_[i]));
    }

    double omega_, shape_t_ = std::numeric_limits<double>::quiet_NaN();
    GaitTable table_;
    std::vector<double> accel_, turn_, rate_, cos_, sin_;
};

// Faults of a joint.
enum class Fault : char { none, limp, locked };

// Some joints imposed, some free: by the gait or locked; limp or driven by torque.
class MixedDrive {
  public:
    MixedDrive(int links, const Gait& g, bool by_angle, const std::vector<Fault>& faults,
               const std::vector<double>& locked_rad, double armature)
        : omega_(g.omega),
          table_(links, g),
          accel_(links - 1),
          fault_(faults),
          locked_(locked_rad),
          imposed_(links - 1),
          rotor_(links - 1) {
        fault_.resize(links - 1, Fault::none);
        locked_.resize(links - 1);
        for (int i = 0; i + 1 < links; ++i) {
            imposed_[i] = fault_[i] == Fault::locked || (by_angle && fault_[i] == Fault::none);
            if (!imposed_[i]) free_.push_back(i);
            if (!imposed_[i] && fault_[i] == Fault::none) rotor_[i] = armature;
        }
    }

    int free_joints() const { return static_cast<int>(free_.size()); }
    const std::vector<char>& imposed() const { return imposed_; }
    const std::vector<double>& rotor() const { return rotor_; }  // kg m^2, of free joints
    const double* joint_accel() const { return accel_.data(); }

    // Angles and rates of all links from those of link 1 and of the free joints; keeps phi''.
    void place(double t, double theta1, double omega1, const double* angle, const double* rate,
               Chain& k) {
        const GaitWave wave = table_.wave(omega_, t);
        k.theta[0] = theta1;
        k.omega[0] = omega1;
        for (int i = 0, f = 0; i + 1 < k.n(); ++i) {
            double phi = locked_[i], speed = 0;
            accel_[i] = 0;
            if (!imposed_[i]) {
                phi = angle[f];
                speed = rate[f];
                ++f;
            } else if (fault_[i] == Fault::none) {
                const GaitWave::Joint j = wave.joint(i);
                phi = j.angle;
                speed = j.rate;
                accel_[i] = j.acceleration;
            }
            k.theta[i + 1] = k.theta[i] + phi;
            k.omega[i + 1] = k.omega[i] + speed;
        }
        k.directions();
    }

    // The free joints' part of what the links have: angles, rates or accelerations.
    void free_angles(const std::vector<double>& of_links, double* joint) const {
        for (const int i : free_) *joint++ = of_links[i + 1] - of_links[i];
    }

    void limp(double* T) const {
        for (std::size_t i = 0; i < fault_.size(); ++i)
            if (fault_[i] == Fault::limp) T[i] = 0;
    }

  private:
    double omega_;
    GaitTable table_;
    std::vector<double> accel_;
    std::vector<Fault> fault_;
    std::vector<double> locked_;
    std::vector<char> imposed_;
    std::vector<double> rotor_;
    std::vector<int> free_;
};

}  // namespace serpenoid
