// The guide's lines for ROS 2, and with MOTION those for a robot, in a controller of ros2_control, of which the part that they use stands here in few words: with
// GET_VALUE as before version 4.27, with GET_OPTIONAL as since 6.0. It ends with 0 if they write three axes and no more.
#include <cmath>
#include <cstdint>
#include <haptic_bridge.h>
#include <optional>
#include <vector>

namespace rclcpp {
struct Time {};
struct Duration {
    int64_t nanoseconds() const { return 1000000; }
};
}  // namespace rclcpp

namespace controller_interface {
struct State {
    std::optional<double> held = 0.0;
#ifdef GET_VALUE
    double get_value() const { return held.value_or(NAN); }
#else
    template <typename T = double> [[nodiscard]] std::optional<T> get_optional(unsigned = 10) const { return held; }
#endif
};
struct Command {
    double held = -1.0;
#ifdef GET_VALUE
    void set_value(double value) { held = value; }
#else
    template <typename T> [[nodiscard]] bool set_value(const T &value, unsigned = 10) {
        held = value;
        return true;
    }
#endif
};
enum class return_type { OK, ERROR };
struct ControllerInterface {
    virtual ~ControllerInterface() = default;
    virtual return_type update(const rclcpp::Time &, const rclcpp::Duration &) = 0;
    std::vector<State> state_interfaces_;
    std::vector<Command> command_interfaces_;
};
}  // namespace controller_interface

// Adds 10 N per tick to the position in m; a position that is missing gives 0, as the library does.
extern "C" int hb_tick(hb_bridge *, uint64_t time_us, const double *position_m, double *force_n) {
    for (int axis = 0; axis < 3; ++axis)
        force_n[axis] = std::isnan(position_m[0]) ? 0.0 : position_m[axis] + static_cast<double>(time_us / 100);
    return 0;
}

double sensed_n[3];
extern "C" void hb_sense(hb_bridge *, const double *force_n) {
    for (int axis = 0; axis < 3; ++axis) sensed_n[axis] = force_n[axis];
}

// Twice the force less the position; a force that is missing stops the robot, as the library does.
extern "C" int hb_tick_motion(hb_bridge *, uint64_t, const double *position_m, double *velocity_m_per_s) {
    for (int axis = 0; axis < 3; ++axis)
        velocity_m_per_s[axis] = std::isnan(sensed_n[axis]) ? 0.0 : 2.0 * sensed_n[axis] - position_m[axis];
    return 0;
}

struct Controller : controller_interface::ControllerInterface {
    uint64_t time_us_ = 0;
    hb_bridge *bridge_ = nullptr;
#ifdef MOTION
#include "motion.hpp"
#else
#include "lines.hpp"
#endif
};

#ifdef MOTION
int main() {
    for (size_t axes : {1, 2, 3}) {
        Controller controller;
        controller.state_interfaces_.resize(2 * axes);
        controller.command_interfaces_.resize(axes);
        for (size_t i = 0; i < 2 * axes; ++i) controller.state_interfaces_[i].held = static_cast<double>(i);
        if (controller.update({}, {}) != controller_interface::return_type::OK) return 1;
        for (size_t i = 0; i < axes; ++i)
            if (controller.command_interfaces_[i].held != static_cast<double>(2 * axes + i)) return 2;
        controller.state_interfaces_[axes].held.reset();
        controller.update({}, {});
        if (controller.command_interfaces_[0].held != 0.0) return 3;
    }
}
#else
int main() {
    for (size_t interfaces : {1, 3, 6}) {
        Controller controller;
        controller.state_interfaces_.resize(interfaces);
        controller.command_interfaces_.resize(interfaces);
        for (size_t i = 0; i < interfaces; ++i) controller.state_interfaces_[i].held = static_cast<double>(i);
        if (controller.update({}, {}) != controller_interface::return_type::OK) return 1;
        for (size_t i = 0; i < interfaces; ++i) {
            const double expected = i < 3 ? static_cast<double>(i) + 10.0 : -1.0;
            if (controller.command_interfaces_[i].held != expected) return 2;
        }
        controller.state_interfaces_[0].held.reset();
        controller.update({}, {});
        if (controller.command_interfaces_[0].held != 0.0) return 3;
    }
}
#endif
