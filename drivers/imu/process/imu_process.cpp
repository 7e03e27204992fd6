// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/process/imu_process.h"

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/geometry.h"
#include "drivers/imu/wire.h"

namespace arpent {
namespace {

Eigen::Matrix3d mounting(const std::vector<double>& q) {
  const auto pose = make_pose(Eigen::Vector3d::Zero(), {q[0], q[1], q[2], q[3]});
  if (!pose) throw InputError("imu_process: mount_quaternion_wxyz must be a unit quaternion");
  return pose->linear();
}

}  // namespace

struct ImuProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  HostTime host;
  Eigen::Matrix3d R_body_imu;
  imu::ReadingCounter counter;
  std::unique_ptr<imu::IioImu> device;
  Time next_attempt;
  Time heard;
  std::int64_t last_number = -1;
  std::string fault = "not open yet";

  State(const Config& process_config, Bus& process_bus, Clock& process_clock)
      : config(process_config),
        bus(process_bus),
        clock(process_clock),
        host(process_clock.now()),
        R_body_imu(mounting(process_config.mount_quaternion_wxyz)),
        counter(process_config.iio.rate_hz),
        next_attempt(process_clock.now()) {}

  void poll() {
    const Time now = clock.now();
    try {
      if (device == nullptr && now >= next_attempt) open(now);
      if (device == nullptr) return;
      for (const imu::Reading& reading : device->read()) {
        heard = now;
        use(reading);
      }
      if (now - heard > from_seconds(config.silence_s)) throw imu::ImuLost("it sends nothing");
    } catch (const imu::ImuLost& lost) {
      device.reset();
      next_attempt = now + from_seconds(config.retry_s);
      fault = lost.what();
      remind();
    }
  }

  void open(Time now) {
    device = std::make_unique<imu::IioImu>(config.iio, host);
    counter.set_rate(device->rate_hz());
    heard = now;
    fault.clear();
    bus.health().count(channels::kImu, "opened");
  }

  void use(const imu::Reading& raw) {
    const auto number = counter.number(raw.stamp);
    if (!number) {
      bus.health().count(channels::kImu, "not_later");
      return;
    }
    if (*number > last_number + 1) bus.health().count(channels::kImu, "lost", *number - last_number - 1);
    last_number = *number;
    const imu::Reading reading{raw.stamp, R_body_imu * raw.angular_velocity_radps, R_body_imu * raw.acceleration_mps2};
    publish(bus, channels::kImu, imu::to_wire(reading, *number));
  }

  void remind() {
    if (!fault.empty()) bus.health().error("inertial unit: " + fault);
  }
};

ImuProcess::ImuProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  clock.every(Duration(config.poll_us), [this] { state_->poll(); });
  clock.every(std::chrono::seconds(1), [this] { state_->remind(); });
}

ImuProcess::~ImuProcess() = default;

void ImuProcess::finish() {
  state_->next_attempt = Time::max();
  state_->device.reset();
}

}  // namespace arpent
