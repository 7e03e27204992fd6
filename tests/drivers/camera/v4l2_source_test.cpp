// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The V4L2 backend against a kernel that is a script: a file takes the place of the device's memory, a function that of
// ioctl. Where there is a real device, it is opened too.
#include "drivers/camera/v4l2_source.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>

namespace arpent::camera {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::uint32_t fourcc(const char* t) {
  return static_cast<std::uint32_t>(t[0] | t[1] << 8 | t[2] << 16 | t[3] << 24);
}

/// What a driver answers. Its memory is a file: buffer i lies at i * 4096.
struct Kernel {
  std::vector<std::uint32_t> formats = {fourcc("MJPG"), fourcc("GREY")};
  unsigned width = 8, height = 2, stride = 8;
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::map<std::uint32_t, int> controls;
  bool streaming = false;
  bool gone = false;
  bool has_exposure = true;
  std::deque<unsigned> queued;
  unsigned sequence = 0;
  std::int64_t stamp_us = 5'000'000;
  int frames = 0;  ///< that are ready
  double rate_hz = 0;

  int answer(unsigned long request, void* argument) {
    if (gone) return fail(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities = capabilities;
        return 0;
      case VIDIOC_ENUM_FMT:
        return enumerate(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_S_FMT:
        return set_format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_G_PARM:
        static_cast<v4l2_streamparm*>(argument)->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
        return 0;
      case VIDIOC_S_PARM: {
        const auto& time = static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe;
        rate_hz = double(time.denominator) / time.numerator;
        return 0;
      }
      case VIDIOC_S_CTRL:
        return set_control(*static_cast<v4l2_control*>(argument));
      case VIDIOC_REQBUFS:
        static_cast<v4l2_requestbuffers*>(argument)->count = 2;
        return 0;
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.length = 4096;
        buffer.m.offset = buffer.index * 4096;
        return 0;
      }
      case VIDIOC_QBUF:
        queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      default:
        return fail(ENOTTY);
    }
  }
  static int fail(int error) {
    errno = error;
    return -1;
  }
  int enumerate(v4l2_fmtdesc& description) const {
    if (description.index >= formats.size()) return fail(EINVAL);
    description.pixelformat = formats[description.index];
    return 0;
  }
  int set_format(v4l2_format& format) const {
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.bytesperline = stride;
    return 0;
  }
  int set_control(const v4l2_control& control) {
    if (control.id == V4L2_CID_EXPOSURE_ABSOLUTE && !has_exposure) return fail(EINVAL);
    controls[control.id] = control.value;
    return 0;
  }
  int dequeue(v4l2_buffer& buffer) {
    if (frames == 0 || queued.empty()) return fail(EAGAIN);
    --frames;
    buffer.index = queued.front();
    queued.pop_front();
    buffer.bytesused = stride * height;
    buffer.flags = flags;
    buffer.sequence = sequence++;
    buffer.timestamp = {stamp_us / 1'000'000, stamp_us % 1'000'000};
    return 0;
  }
};

class CameraV4l2 : public testing::Test {
 protected:
  CameraV4l2() {
    std::ofstream out(file_, std::ios::binary);
    for (int i = 0; i < 2 * 4096; ++i) out.put(static_cast<char>(i % 4096 + (i < 4096 ? 0 : 100)));
    params_.device = file_.string();
    params_.width_px = 8;
    params_.height_px = 2;
    params_.exposure = {3000, 0};
  }
  ~CameraV4l2() override { fs::remove(file_); }
  std::unique_ptr<FrameSource> open() {
    return open_v4l2(params_, host_,
                     [this](int, unsigned long request, void* a) { return kernel_.answer(request, a); });
  }
  std::string fault() {
    try {
      (void)open();
    } catch (const DeviceLost& lost) {
      return lost.what();
    }
    return "";
  }

  fs::path file_ = fs::path(testing::TempDir()) /
                   (std::string("v4l2_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  Kernel kernel_;
  V4l2Params params_;
  HostTime host_{Time(1000s)};
};

TEST_F(CameraV4l2, FramesComeFromTheMappedBufferThatTheKernelNames) {
  const auto source = open();
  EXPECT_TRUE(kernel_.streaming);
  EXPECT_EQ(kernel_.rate_hz, 5);
  EXPECT_FALSE(source->next(10ms)) << "none is ready";
  kernel_.frames = 3;
  const int start[] = {0, 100, 0};
  for (int i = 0; i < 3; ++i) {
    const auto frame = source->next(10ms);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame_id, i);
    EXPECT_EQ(frame->image(0, 0), start[i]);
    EXPECT_EQ(frame->image(1, 7), start[i] + 15);
    EXPECT_EQ(frame->exposure_us, 3000);
    EXPECT_EQ(frame->device_time, host_.from_monotonic(5s));
  }
}

TEST_F(CameraV4l2, ExposureIsManualInUnitsOfATenthOfAMillisecond) {
  const auto source = open();
  EXPECT_EQ(kernel_.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(kernel_.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 30);
  source->set_exposure({4560, 0});
  EXPECT_EQ(kernel_.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 46);
  kernel_.frames = 1;
  EXPECT_EQ(source->next(10ms)->exposure_us, 4600) << "what it was rounded to";
}

TEST_F(CameraV4l2, AStampOfTheEndOfAFrameIsTakenBackToTheStartOfItsExposure) {
  kernel_.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  params_.transfer = Duration(11000);
  const auto source = open();
  kernel_.frames = 1;
  EXPECT_EQ(source->next(10ms)->device_time, host_.from_monotonic(5s - 14ms));
}

TEST_F(CameraV4l2, ADeviceThatCannotServeSaysWhy) {
  kernel_.formats = {fourcc("MJPG"), fourcc("BA81")};
  EXPECT_NE(fault().find("MJPG BA81"), std::string::npos) << fault();
  kernel_ = Kernel();
  kernel_.width = 16;
  EXPECT_NE(fault().find("16 x 2"), std::string::npos) << fault();
  kernel_ = Kernel();
  kernel_.capabilities = V4L2_CAP_VIDEO_OUTPUT;
  EXPECT_NE(fault().find("captures no video"), std::string::npos) << fault();
  kernel_ = Kernel();
  kernel_.has_exposure = false;
  EXPECT_NE(fault().find("exposure.mode"), std::string::npos) << fault();
  params_.control_exposure = false;
  EXPECT_EQ(fault(), "");
  params_.device = "/dev/no-such-video";
  EXPECT_NE(fault().find("/dev/no-such-video"), std::string::npos);
}

TEST_F(CameraV4l2, StampsOfAnotherClockAreRefused) {
  kernel_.flags = 0;
  const auto source = open();
  kernel_.frames = 1;
  EXPECT_THROW((void)source->next(10ms), DeviceLost);
}

TEST_F(CameraV4l2, DamagedAndShortFramesAreCountedAndTheirBuffersGivenBack) {
  const auto source = open();
  kernel_.flags |= V4L2_BUF_FLAG_ERROR;
  kernel_.frames = 1;
  EXPECT_FALSE(source->next(10ms));
  EXPECT_EQ(source->incomplete(), 1);
  EXPECT_EQ(kernel_.queued.size(), 2U);
}

TEST_F(CameraV4l2, APulledDeviceIsLost) {
  const auto source = open();
  kernel_.gone = true;
  EXPECT_FALSE(source->answers());
  EXPECT_THROW((void)source->next(10ms), DeviceLost);
}

TEST_F(CameraV4l2, HalvesSideBySideAreSplitInTheMiddle) {
  const auto source = open();
  kernel_.frames = 1;
  const auto [left, right] = split_halves(*source->next(10ms));
  EXPECT_EQ(left.image.size(), cv::Size(4, 2));
  EXPECT_EQ(left.image(1, 0), 8);
  EXPECT_EQ(right.image(1, 0), 12);
  EXPECT_EQ(left.frame_id, right.frame_id);
  EXPECT_TRUE(left.image.isContinuous());
}

TEST(CameraV4l2Listing, NamesTheDevicesOfTheKernel) {
  const fs::path folder = fs::path(testing::TempDir()) / "v4l2_listing";
  for (const char* device : {"video2", "video0"}) {
    fs::create_directories(folder / device);
    std::ofstream(folder / device / "name") << device << " camera\n";
  }
  const auto listing = list_v4l2(folder.string());
  ASSERT_EQ(listing.size(), 2U);
  EXPECT_EQ(listing[0].device, "/dev/video0");
  EXPECT_EQ(listing[1].name, "video2 camera");
  fs::remove_all(folder);
  EXPECT_TRUE(list_v4l2("/no/such/folder").empty());
}

TEST(CameraV4l2Hardware, TheFirstDeviceOfThisMachineGivesAFrameOrAClearFault) {
  if (!fs::exists("/dev/video0")) GTEST_SKIP() << "there is no /dev/video0";
  V4l2Params params;
  params.device = "/dev/video0";
  params.control_exposure = false;
  try {
    const auto source = open_v4l2(params, HostTime(Time(1000s)));
    std::optional<Frame> frame;
    for (int i = 0; i < 30 && !frame; ++i) frame = source->next(100ms);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->image.size(), cv::Size(640, 512));
  } catch (const DeviceLost& lost) {
    EXPECT_NE(std::string(lost.what()).find("/dev/video0"), std::string::npos);
  }
}

}  // namespace
}  // namespace arpent::camera
