// A robot that takes a velocity, made a device of fractional-haptics: its speed loop, its dead time and a hand are simulated, in C++17
// and without any dependency. Take your own robot's SDK in place of `Robot`, and measure its bandwidth and dead time for robot.toml.
//
//   simulated_robot ADDRESS ROBOT.toml      such as 127.0.0.1:4250; the robot ends with its input
// Lines of the input: the push of the hand in N, such as 3; `nan`, from which on the force sensor fails; `silence`, without its force.
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
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <utility>

namespace {

using Vector = std::array<double, 3>;

constexpr double sample_time_s = 1e-3;
constexpr int fine = 10;
/// The speed loop: 10 Hz, damping ratio 0.8, and 4 ms until it hears of a command.
constexpr double natural_rad_per_s = 2.0 * 3.141592653589793 * 10.0;
constexpr double damping_ratio = 0.8;
constexpr std::size_t late = 4;
/// The hand, beyond the force sensor.
constexpr double hand_kg = 1.0;
constexpr double hand_n_s_per_m = 10.0;

/// Stands for the driver of a robot: the axis that is pushed.
class Robot {
public:
    double position_m() const { return position_m_; }

    /// As the sensor under the handle shows it: what the hand wants, less what it takes to move the hand.
    double force_n(double push_n) const { return push_n - hand_kg * rate_ - hand_n_s_per_m * velocity_; }

    /// The command holds until the next tick.
    void set_velocity(double velocity_m_per_s) {
        std::rotate(line_.begin(), line_.begin() + 1, line_.end());
        const double held = std::exchange(line_.back(), velocity_m_per_s);
        for (int step = 0; step < fine; ++step) {
            const double error = held - velocity_;
            const double pull = natural_rad_per_s * error - 2.0 * damping_ratio * rate_;
            rate_ += sample_time_s / fine * natural_rad_per_s * pull;
            velocity_ += sample_time_s / fine * rate_;
            position_m_ += sample_time_s / fine * velocity_;
        }
    }

private:
    std::array<double, late> line_{};
    double velocity_ = 0.0;
    double rate_ = 0.0;
    double position_m_ = 0.0;
};

/// Lines of the input, for the thread that ticks.
struct Told {
    std::atomic<bool> ended{false};
    std::atomic<bool> is_silent{false};
    std::atomic<double> push_n{0.0};
};

struct Close {
    void operator()(hb_bridge *bridge) const { hb_close(bridge); }
};

/// The thread of the robot. This one lives in the time of its ticks, so that a busy machine makes it slow and never late; for a robot
/// of metal the time is the one that hb_wait returns.
void robot_thread(hb_bridge *bridge, const Told &told, int &braked) {
    Robot robot;
    std::uint64_t time_us = 0;
    int known = 0;
    while (!told.ended) {
        hb_wait(bridge);
        time_us += 1000;
        const Vector force_n{robot.force_n(told.push_n)};
        if (!told.is_silent) {
            hb_sense(bridge, force_n.data());
        }
        const Vector position_m{robot.position_m()};
        Vector velocity_m_per_s{};
        const int fault = hb_tick_motion(bridge, time_us, position_m.data(), velocity_m_per_s.data());
        // In every case: after a fault it is the way to rest.
        robot.set_velocity(velocity_m_per_s[0]);
        if (fault != known && fault != 0) {
            braked = 0;
            std::fprintf(stderr, "fault %d: %s\n", fault, hb_reason(bridge));
        }
        if (fault != 0 && velocity_m_per_s[0] != 0.0) {
            ++braked;
        }
        known = fault;
    }
    // Nobody ticks any more.
    robot.set_velocity(0.0);
}

} // namespace

int main(int argc, char **argv) {
    hb_device device{};
    device.size = sizeof device;
    device.name = "simulated robot";
    device.axes = 1;
    device.sample_time_us = 1000;
    device.takes = HB_VELOCITY;
    device.robot = argc > 2 ? argv[2] : "robot.toml";
    device.sensed_force_max_n = 50.0;
    // Of the law that is rendered; the robot itself has no force.
    device.force_max_n = 20.0;
    device.force_rate_max_n_per_s = 10000.0;

    char error[512];
    const std::unique_ptr<hb_bridge, Close> bridge{hb_open(&device, argc > 1 ? argv[1] : nullptr, error, sizeof error)};
    if (!bridge) {
        std::fprintf(stderr, "%s\n", error);
        return 3;
    }
    std::printf("listening at port %d\n", int{hb_port(bridge.get())});
    std::fflush(stdout);

    Told told;
    int braked = 0;
    std::thread thread{robot_thread, bridge.get(), std::cref(told), std::ref(braked)};
    for (std::string line; std::getline(std::cin, line);) {
        if (line == "silence") {
            told.is_silent = true;
        } else {
            // `nan` too
            told.push_n = std::strtod(line.c_str(), nullptr);
        }
    }
    // The command comes to rest while the thread still ticks.
    hb_stop(bridge.get());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    told.ended = true;
    thread.join();
    std::printf("at rest %d ms after the last fault\n", braked);
    return 0;
}
