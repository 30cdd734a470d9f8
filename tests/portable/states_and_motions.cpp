// Prints 30 periodic states and one period of motion from each, one line for each, all digits.
#include <cmath>
#include <cstdio>

extern "C" int serpenoid_steady(const double* ask, double rtol, int powers, double* to);
extern "C" int serpenoid_motion(const double* ask, int frames, double* to);

static void print(int answer, const double* values, int count) {
    std::printf("%d", answer);
    for (int i = 0; i < count; ++i) std::printf(" %.17g", values[i]);
    std::printf("\n");
}

int main() {
    constexpr int kFrames = 20, kMostLinks = 8, kCompared = 5;  // then come bounds of errors
    for (int k = 0; k < 30; ++k) {
        const auto between = [k](double low, double high, double stride) {
            return low + (high - low) * std::fmod(k * stride, 1.0);
        };
        const int links = 3 + k % (kMostLinks - 2);
        const double mass = between(0.02, 1, 0.618), length = between(0.04, 0.2, 0.755);
        const double ct = between(0.01, 0.1, 0.57), cn = between(0.2, 2, 0.82);
        // every other one on dry ground, some with a ratchet, some that turn
        const double ft0 = k % 2 * between(0.005, 0.03, 0.67),
                     fn0 = k % 2 * between(0.03, 0.1, 0.55);
        const double back = k % 5 == 3 ? 3 : 1, offset = k % 7 == 6 ? 0.1 : 0;
        const double ask[] = {1.0 * links,
                              mass,
                              length,
                              mass * length * length / 12,
                              ct,
                              cn,
                              ft0,
                              fn0,
                              ct * back,
                              ft0 * back,
                              between(0.3, 1.3, 0.45),
                              between(0.5, 1.5, 0.38),
                              between(1, 6, 0.22),
                              offset};
        double to[(kFrames + 1) * 6 * kMostLinks];
        const int converged = serpenoid_steady(ask, 1e-6, 1, to);
        print(converged, to, kCompared);
        const int times = serpenoid_motion(ask, kFrames, to);
        print(times, to, times * (6 * links - 1));
    }
}
