// A program with a haptic thread, made a device of fractional-haptics: a simulated arm, in C++17 and
// without any dependency. Take your own device's SDK in place of `Arm`.
//
//   simulated_device [ADDRESS] [AXES]      default 127.0.0.1:4250 and 1, which every experiment takes; ends with its input
#include <haptic_bridge.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>

namespace {

using Vector = std::array<double, 3>;

constexpr double mass_kg = 0.1;
constexpr double damping_n_s_per_m = 1.0;
constexpr double hand_n_per_m = 50.0;
constexpr double rest_m = -0.002;
constexpr double stroke_m = 0.008;
constexpr double half_s = 5.0;
constexpr double sample_time_s = 1e-3;

/// Stands for the driver of a device: a mass that a hand holds outside the wall for 5 s, so that a run can
/// begin, then draws along its first axis into it and out again in another 5 s.
class Arm {
public:
    Vector position_m() const { return position_m_; }

    /// The force holds until the next tick.
    void set_force(const Vector &force_n) {
        const double into_s = std::max(std::fmod(time_s_, 2.0 * half_s) - half_s, 0.0);
        const double phase = 2.0 * std::acos(-1.0) * into_s / half_s;
        const double hand_m = rest_m + 0.5 * stroke_m * (1.0 - std::cos(phase));
        time_s_ += sample_time_s;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double aim_m = axis == 0 ? hand_m : 0.0;
            const double hand_n = hand_n_per_m * (aim_m - position_m_[axis]);
            const double all_n = force_n[axis] + hand_n - damping_n_s_per_m * velocity_m_per_s_[axis];
            velocity_m_per_s_[axis] += sample_time_s * all_n / mass_kg;
            position_m_[axis] += sample_time_s * velocity_m_per_s_[axis];
        }
    }

private:
    double time_s_ = 0.0;
    Vector position_m_{};
    Vector velocity_m_per_s_{};
};

struct Close {
    void operator()(hb_bridge *bridge) const { hb_close(bridge); }
};

/// The haptic thread. This arm lives in the time of its ticks, so that a busy machine makes it slow and never late; for a
/// device of metal the time is the one that hb_wait returns.
void haptic_thread(hb_bridge *bridge, const std::atomic<bool> &ended, double &largest_n) {
    Arm arm;
    std::uint64_t time_us = 0;
    int known = 0;
    while (!ended) {
        hb_wait(bridge);
        time_us += 1000;
        Vector force_n{};
        const int fault = hb_tick(bridge, time_us, arm.position_m().data(), force_n.data());
        // In every case: after a fault it is the way to zero.
        arm.set_force(force_n);
        largest_n = std::max(largest_n, std::abs(force_n[0]));
        if (fault != known && fault != 0) {
            std::fprintf(stderr, "fault %d: %s\n", fault, hb_reason(bridge));
        }
        known = fault;
    }
    // Nobody ticks any more: the library cannot take the force away from here on.
    arm.set_force(Vector{});
}

} // namespace

int main(int argc, char **argv) {
    hb_device device{};
    device.size = sizeof device;
    device.name = "simulated arm";
    device.axes = argc > 2 ? static_cast<std::uint32_t>(std::atoi(argv[2])) : 1;
    device.sample_time_us = 1000;
    device.force_max_n = 5.0;
    device.force_rate_max_n_per_s = 1000.0;
    for (double &low_m : device.workspace_low_m) {
        low_m = -0.1;
    }
    for (double &high_m : device.workspace_high_m) {
        high_m = 0.1;
    }

    char error[256];
    const std::unique_ptr<hb_bridge, Close> bridge{hb_open(&device, argc > 1 ? argv[1] : nullptr, error, sizeof error)};
    if (!bridge) {
        std::fprintf(stderr, "%s\n", error);
        return 3;
    }
    std::printf("listening at port %d\n", int{hb_port(bridge.get())});
    std::fflush(stdout);

    std::atomic<bool> ended{false};
    double largest_n = 0.0;
    std::thread thread{haptic_thread, bridge.get(), std::cref(ended), std::ref(largest_n)};
    while (std::getchar() != EOF) {
    }
    // The force falls while the thread still ticks.
    hb_stop(bridge.get());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    ended = true;
    thread.join();
    std::printf("largest force %.3f N\n", largest_n);
    return 0;
}
