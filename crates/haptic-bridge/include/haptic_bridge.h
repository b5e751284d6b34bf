/* haptic-bridge: any program with a haptic thread is a device of fractional-haptics. MIT OR Apache-2.0.
 * Made by cbindgen from src/c.rs; do not edit. */

#ifndef HAPTIC_BRIDGE_H
#define HAPTIC_BRIDGE_H

#include <stddef.h>
#include <stdint.h>

/**
 * A pointer that is needed was null.
 */
#define HB_NULL -1

/**
 * The library failed inside and has let go for good: close the bridge.
 */
#define HB_ENDED -2

/**
 * The call is that of another kind of device: `hb_tick` gives a force, `hb_tick_motion` a velocity.
 */
#define HB_OTHER -3

/**
 * A device that takes a force, N, from `hb_tick`.
 */
#define HB_FORCE 0

/**
 * A device that takes a velocity, m/s, from `hb_tick_motion`: a robot with a force sensor under its handle.
 */
#define HB_VELOCITY 1

/**
 * A bridge. One thread ticks; `hb_stop`, `hb_fault`, `hb_reason` and `hb_port` may be called from others meanwhile.
 */
typedef struct hb_bridge hb_bridge;

/**
 * Abilities and limits of the device. No host can loosen these limits; it sets its own within them.
 * Set everything to zero first (`hb_device device = {0};`, in C++ `hb_device device{};`), then `size`.
 */
typedef struct hb_device {
  /**
   * `sizeof(hb_device)`, by which a library of another version is noticed.
   */
  size_t size;
  /**
   * Name in `device info` and in logs, UTF-8, 1 to 16 bytes.
   */
  const char *name;
  /**
   * Number of axes, 1 to 3.
   */
  uint32_t axes;
  /**
   * Time from one tick to the next, microseconds, 100 to 10000; 0 takes the mean of the first second, in which there is no force.
   * Calls of `hb_tick` in between hold the last force.
   */
  uint32_t sample_time_us;
  /**
   * Largest force on an axis, and of several axes the largest magnitude, N, above 0.
   */
  double force_max_n;
  /**
   * Largest rate of the force, N/s, above 0.
   */
  double force_rate_max_n_per_s;
  /**
   * Distance of one count of the sensor, m; 0 if it is not known.
   */
  double position_resolution_m;
  /**
   * Low ends of the workspace, m: outside of it there is no force. Two ends of 0 mean no workspace limit.
   */
  double workspace_low_m[3];
  /**
   * High ends of the workspace, m.
   */
  double workspace_high_m[3];
  /**
   * Longest silence of a host while the device is armed, ms, 5 to 1000; 0 leaves it to the host, which says 1000 at most.
   */
  uint32_t watchdog_ms;
  /**
   * Largest force that the force sensor shows either way, N; 0 without one. See `hb_sense`.
   */
  double sensed_force_max_n;
  /**
   * Serial number of the device, 6 to 32 letters, digits and any of "-_.:+", under which a host keeps its limits; NULL if it is not
   * known.
   */
  const char *serial_number;
  /**
   * The command that the device takes: `HB_FORCE` (0) or `HB_VELOCITY`. With the latter `sample_time_us` and `sensed_force_max_n` are
   * declared too; the force limits are of the law that is rendered, and the workspace is that of the command.
   */
  uint32_t takes;
  /**
   * Path of the robot's device file, with `[admittance]`: its virtual body, its own loop, the limits of its motion, the hands that push it.
   * NULL for a device that takes a force.
   */
  const char *robot;
} hb_device;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Opens a bridge: from now on a host can connect, as with `host-cli device info --device tcp:127.0.0.1:4250`.
 *
 * `listen` is an address of this machine with a port, such as "127.0.0.1:4250", which NULL means; with port 0 one that is
 * free is taken, see `hb_port`. The connection has no password and no encryption: another address than the loopback is for
 * a network in which everybody may push whoever holds the device.
 *
 * Returns NULL if it cannot be opened; then `error`, of `room` bytes, says why. It may be NULL.
 *
 * # Safety
 * Pointers are null or valid; texts end with a zero byte.
 */
struct hb_bridge *hb_open(const struct hb_device *what,
                          const char *listen,
                          char *error,
                          size_t room);

/**
 * One tick of the haptic thread: takes the position, m, gives the force until the next call, N, behind the safety chain.
 * Elements beyond the device's axes are ignored, and zero. Both may be the same array. Never waits, allocates or locks.
 *
 * `time_us` is from a clock that only goes on, microseconds, as `hb_wait` returns it or as `std::chrono::steady_clock` has it; the
 * watchdog counts by it. One that is plainly in milliseconds or seconds is fault 12. Call it once a sample time or more often: a
 * thread that is slower than was declared, by more than 5 % over 0.2 s or 2 % over 2 s, is fault 3. When the calls cease, the host
 * hears nothing more and ends its run; the force is then the program's to take away.
 *
 * Returns 0, or the code of the latched fault, as in `hb_fault`: the force falls to zero, and is zero at once where no
 * position can be used. `HB_NULL`: no bridge. `HB_ENDED`: close it.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed; the arrays are null or of three numbers; one thread at a time.
 */
int hb_tick(struct hb_bridge *bridge,
            uint64_t time_us,
            const double *position_m,
            double *force_n);

/**
 * One tick of a robot, which takes a velocity: the position that was measured, m, gives the velocity until the next call, m/s, behind
 * the chain of motion. Between the force of the hand, by `hb_sense`, and that of the law stands the virtual body of the device file.
 * All else is as with `hb_tick`.
 *
 * `hb_sense` before each call is a must. Without it, with NaN, after a fault, `hb_stop` or a silent host the velocity comes to zero by
 * the greatest deceleration of the device file, and stays there: go on calling until it has. The robot has to stop by itself when the
 * calls cease.
 *
 * Returns as `hb_tick` does. `HB_OTHER`, with zero: the device takes a force, as `hb_tick` on a device that takes a velocity.
 *
 * # Safety
 * As `hb_tick`.
 */
int hb_tick_motion(struct hb_bridge *bridge,
                   uint64_t time_us,
                   const double *position_m,
                   double *velocity_m_per_s);

/**
 * Takes the force of the hand by a force sensor, N, positive along the position, for the next `hb_tick`, which sends it to the host.
 * Call it before each `hb_tick`, in the same thread; NaN is a sensor that gave nothing. Elements beyond the device's axes are ignored.
 * State the range of the sensor in `sensed_force_max_n`. A robot that takes a velocity does not move without it. Never waits, allocates or locks.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed; the array is null or of three numbers; one thread at a time.
 */
void hb_sense(struct hb_bridge *bridge,
              const double *force_n);

/**
 * Sleeps until the next sample is due, by an absolute clock, so that a loop runs at the sample time that it declared; returns the
 * time then, microseconds, for `hb_tick`. A loop that is late goes on at once, and periods that have passed are not made up for.
 * For the haptic thread alone; a thread that a driver calls at its own rate has no need of it. 0 without a bridge.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed; one thread at a time.
 */
uint64_t hb_wait(struct hb_bridge *bridge);

/**
 * Lets the force fall to zero within the stop time from the next tick on, or a robot come to rest, and disarms the device: the host has
 * to arm it again. From any thread; NULL is nothing.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed.
 */
void hb_stop(struct hb_bridge *bridge);

/**
 * The code of the latched fault, as in logs; 0 without one, `HB_NULL` without a bridge, `HB_ENDED` if it has to be closed.
 * From any thread.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed.
 */
int hb_fault(const struct hb_bridge *bridge);

/**
 * The reason of the latched fault, one line of English; "" without one. It is valid until `hb_close`. From any thread.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed.
 */
const char *hb_reason(const struct hb_bridge *bridge);

/**
 * The port that the bridge listens at; 0 without a bridge.
 *
 * # Safety
 * `bridge` is null or from `hb_open` and not closed.
 */
uint16_t hb_port(const struct hb_bridge *bridge);

/**
 * Closes a bridge: the connection ends, and the memory is given back. NULL is nothing. It writes no force: end the haptic
 * thread first, and set the force of the device to zero.
 *
 * # Safety
 * `bridge` is null or from `hb_open`; nobody uses it any more.
 */
void hb_close(struct hb_bridge *bridge);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HAPTIC_BRIDGE_H */
