// RK4 kernels written by hand for the plainest scene of each formulation: six links (or any
// number), joint angles imposed, viscous friction, level ground, nothing recorded. What somebody
// would write who needed only that; the composed scenes are measured against them.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace handwritten {

struct Plain {
    int n;
    double m, l, I, ct, cn, alpha, beta, omega, k, c;
};

template <class Rate>
void rk4(const Rate& rate, double t, double h, std::vector<double>& y,
         std::vector<double> (&w)[5]) {
    const std::size_t n = y.size();
    auto &k1 = w[0], &k2 = w[1], &k3 = w[2], &k4 = w[3], &z = w[4];
    rate(t, y.data(), k1.data());
    for (std::size_t i = 0; i < n; ++i) z[i] = y[i] + h / 2 * k1[i];
    rate(t + h / 2, z.data(), k2.data());
    for (std::size_t i = 0; i < n; ++i) z[i] = y[i] + h / 2 * k2[i];
    rate(t + h / 2, z.data(), k3.data());
    for (std::size_t i = 0; i < n; ++i) z[i] = y[i] + h * k3[i];
    rate(t + h, z.data(), k4.data());
    for (std::size_t i = 0; i < n; ++i) y[i] += h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
}

// y = x, y, theta of link 1 and their rates; equations as in host/core/tail_acceleration.hpp.
class Explicit {
  public:
    explicit Explicit(const Plain& plain) : p(plain) {
        for (int i = 0; i + 1 < p.n; ++i)
            cos_.push_back(std::cos(i * p.beta)), sin_.push_back(std::sin(i * p.beta));
    }
    std::vector<double> start() const { return std::vector<double>(6); }
    void operator()(double t, const double* y, double* dy) const {
        const double sw = std::sin(p.omega * t), cw = std::cos(p.omega * t), ww = p.omega * p.omega;
        double theta = y[2], w = y[5], c = std::cos(theta), s = std::sin(theta);
        double rx = 0, ry = 0, vx = y[3], vy = y[4], bx = 0, by = 0, turn = 0;
        double fx = 0, fy = 0, moment = 0, Rx = 0, Ry = 0, square = 0, turns = 0;
        for (int i = 0;; ++i) {
            const double ft = -p.ct * (c * vx + s * vy), fn = -p.cn * (c * vy - s * vx);
            const double gx = ft * c - fn * s - p.m * bx, gy = ft * s + fn * c - p.m * by;
            fx += gx, fy += gy, moment += rx * gy - ry * gx;
            Rx += rx, Ry += ry, square += rx * rx + ry * ry, turns += turn;
            if (i + 1 == p.n) break;
            const double phi = p.alpha * (sw * cos_[i] + cw * sin_[i]);
            theta += phi;
            const double w1 = w + p.omega * p.alpha * (cw * cos_[i] - sw * sin_[i]);
            const double c1 = std::cos(theta), s1 = std::sin(theta), turn1 = turn - ww * phi;
            rx += p.l * (c + c1), ry += p.l * (s + s1);
            vx -= p.l * (w * s + w1 * s1), vy += p.l * (w * c + w1 * c1);
            bx -= p.l * (turn * s + w * w * c + turn1 * s1 + w1 * w1 * c1);
            by += p.l * (turn * c - w * w * s + turn1 * c1 - w1 * w1 * s1);
            c = c1, s = s1, w = w1, turn = turn1;
        }
        const double one = 1.0 / p.n, mass = p.n * p.m;
        const double J = p.n * p.I + p.m * (square - one * (Rx * Rx + Ry * Ry));
        const double a = (moment - p.I * turns + one * (Ry * fx - Rx * fy)) / J;
        dy[0] = y[3], dy[1] = y[4], dy[2] = y[5];
        dy[3] = (fx + p.m * Ry * a) / mass, dy[4] = (fy - p.m * Rx * a) / mass, dy[5] = a;
    }

  private:
    Plain p;
    std::vector<double> cos_, sin_;
};

// y = x, y, vx, vy of every link, then theta and omega of link 1; Eqs. 51-56.
class Implicit {
  public:
    explicit Implicit(const Plain& plain) : p(plain) {
        for (int i = 0; i + 1 < p.n; ++i)
            cos_.push_back(std::cos(i * p.beta)), sin_.push_back(std::sin(i * p.beta));
    }
    std::vector<double> start() const {
        std::vector<double> y(4 * p.n + 2);
        for (int i = 0; i < p.n; ++i) y[i] = 2 * p.l * i;
        return y;
    }
    void operator()(double t, const double* y, double* dy) const {
        const int n = p.n;
        const double *x = y, *yy = y + n, *vx = y + 2 * n, *vy = y + 3 * n;
        const double sw = std::sin(p.omega * t), cw = std::cos(p.omega * t), ww = p.omega * p.omega;
        double theta = y[4 * n], w = y[4 * n + 1], c = std::cos(theta), s = std::sin(theta);
        double Px = 0, Py = 0, couples = 0, turn = 0, turns = 0;
        for (int i = 0; i < n; ++i) {
            double Fx = 0, Fy = 0, c1 = 0, s1 = 0, w1 = 0, phi = 0;
            if (i + 1 < n) {
                phi = p.alpha * (sw * cos_[i] + cw * sin_[i]);
                theta += phi;
                w1 = w + p.omega * p.alpha * (cw * cos_[i] - sw * sin_[i]);
                c1 = std::cos(theta), s1 = std::sin(theta);
                Fx = p.k * (x[i + 1] - x[i] - p.l * (c + c1)) +
                     p.c * (vx[i + 1] - vx[i] + p.l * (w * s + w1 * s1));
                Fy = p.k * (yy[i + 1] - yy[i] - p.l * (s + s1)) +
                     p.c * (vy[i + 1] - vy[i] - p.l * (w * c + w1 * c1));
            }
            const double ft = -p.ct * (c * vx[i] + s * vy[i]);
            const double fn = -p.cn * (c * vy[i] - s * vx[i]);
            dy[i] = vx[i], dy[n + i] = vy[i];
            dy[2 * n + i] = (ft * c - fn * s + Fx - Px) / p.m;
            dy[3 * n + i] = (ft * s + fn * c + Fy - Py) / p.m;
            couples += p.l * (c * (Fy + Py) - s * (Fx + Px));
            turns += turn, turn -= ww * phi;
            Px = Fx, Py = Fy, c = c1, s = s1, w = w1;
        }
        dy[4 * n] = y[4 * n + 1];
        dy[4 * n + 1] = (couples - p.I * turns) / (n * p.I);
    }

  private:
    Plain p;
    std::vector<double> cos_, sin_;
};

}  // namespace handwritten
