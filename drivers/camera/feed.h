// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// One camera as the process sees it: frames to take without waiting, an exposure to ask for, and how the device is. A
// ThreadedFeed keeps a device open in a thread of its own and opens it anew, with back-off, when it is missing,
// unplugged or silent; a DirectFeed asks a source that never waits (files), so that lockstep stays deterministic.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "drivers/camera/frame_source.h"

namespace arpent::camera {

struct FeedParams {
  double retry_first_s = 0.2;
  double retry_most_s = 5;
  double silence_s = 1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("retry_first_s", self.retry_first_s, "wait before a lost device is opened again; doubles each time",
                  config::between(0.01, 60.0));
    visitor.field("retry_most_s", self.retry_most_s, "longest wait between attempts", config::between(0.01, 600.0));
    visitor.field("silence_s", self.silence_s, "a device that sends nothing for so long is asked whether it is there",
                  config::between(0.05, 600.0));
  }
};

struct FeedCondition {
  bool open = false;
  std::string fault;            ///< what is wrong now; empty if nothing is
  std::int64_t openings = 0;    ///< times that the device was opened
  std::int64_t incomplete = 0;  ///< frames lost because parts were missing
  std::int64_t dropped = 0;     ///< frames that nobody took in time
};

class Feed {
 public:
  virtual ~Feed() = default;
  /// The frames that came since the last call, in order. Never waits.
  [[nodiscard]] virtual std::vector<Frame> take() = 0;
  virtual void set_exposure(const ExposureSetting& setting) = 0;
  [[nodiscard]] virtual FeedCondition condition() const = 0;
};

class ThreadedFeed : public Feed {
 public:
  ThreadedFeed(OpenSource open, const FeedParams& params);
  /// Returns within half a second even if the device hangs: a thread that is stuck in a driver is left to itself.
  ~ThreadedFeed() override;
  [[nodiscard]] std::vector<Frame> take() override;
  void set_exposure(const ExposureSetting& setting) override;
  [[nodiscard]] FeedCondition condition() const override;

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the thread, which may outlive us
};

class DirectFeed : public Feed {
 public:
  explicit DirectFeed(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}
  [[nodiscard]] std::vector<Frame> take() override;
  void set_exposure(const ExposureSetting& setting) override { source_->set_exposure(setting); }
  [[nodiscard]] FeedCondition condition() const override { return {true, "", 1, source_->incomplete(), 0}; }

 private:
  std::unique_ptr<FrameSource> source_;
};

}  // namespace arpent::camera
