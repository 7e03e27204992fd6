// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/v4l2_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "common/error.h"
#include "drivers/camera/gray.h"

namespace arpent::camera {
namespace {

constexpr unsigned kBuffers = 4;
constexpr int kExposureUnitUs = 100;  // of V4L2_CID_EXPOSURE_ABSOLUTE
constexpr std::int64_t kSequencePeriod = std::int64_t{1} << 32;

class Mapping {
 public:
  Mapping(int fd, const v4l2_buffer& buffer)
      : size_(buffer.length),
        data_(mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, fd, static_cast<off_t>(buffer.m.offset))) {
    if (data_ == MAP_FAILED) throw DeviceLost(std::string("mapping a buffer: ") + std::strerror(errno));
  }
  ~Mapping() {
    if (data_ != nullptr) munmap(data_, size_);
  }
  Mapping(Mapping&& other) noexcept : size_(other.size_), data_(std::exchange(other.data_, nullptr)) {}
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  Mapping& operator=(Mapping&&) = delete;
  std::span<const std::uint8_t> bytes() const { return {static_cast<const std::uint8_t*>(data_), size_}; }

 private:
  std::size_t size_;
  void* data_;
};

class V4l2Source : public FrameSource {
 public:
  V4l2Source(const V4l2Params& params, const HostTime& host, Ioctl ioctl)
      : params_(params), host_(host), ioctl_(std::move(ioctl)) {
    fd_ = open(params.device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) throw DeviceLost(fmt::format("opening {}: {}", params.device, std::strerror(errno)));
    try {
      check_capabilities();
      set_format();
      set_rate();
      if (params.control_exposure) write_exposure(params.exposure);
      map_buffers();
      int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      require(VIDIOC_STREAMON, &type, "starting the stream");
    } catch (...) {
      close(fd_);
      throw;
    }
  }

  ~V4l2Source() override {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    (void)call(VIDIOC_STREAMOFF, &type);
    mappings_.clear();
    close(fd_);
  }

  std::optional<Frame> next(Duration wait) override {
    pollfd waiting{fd_, POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(wait.count() / 1000)) <= 0) return std::nullopt;
    v4l2_buffer buffer = request_buffer(0);
    if (call(VIDIOC_DQBUF, &buffer) < 0) {
      if (errno == EAGAIN) return std::nullopt;
      throw DeviceLost(fmt::format("{}: {}", params_.device, std::strerror(errno)));
    }
    std::optional<Frame> frame = to_frame(buffer);
    require(VIDIOC_QBUF, &buffer, "giving a buffer back");
    return frame;
  }

  void set_exposure(const ExposureSetting& setting) override {
    if (params_.control_exposure) write_exposure(setting);
  }

  bool answers() override {
    v4l2_capability capability{};
    return call(VIDIOC_QUERYCAP, &capability) == 0;
  }

  std::int64_t incomplete() const override { return incomplete_; }

 private:
  int call(unsigned long request, void* argument) const {
    int result = -1;
    do {
      result = ioctl_(fd_, request, argument);
    } while (result < 0 && errno == EINTR);
    return result;
  }

  void require(unsigned long request, void* argument, const std::string& what) const {
    if (call(request, argument) < 0) {
      throw DeviceLost(fmt::format("{}: {}: {}", params_.device, what, std::strerror(errno)));
    }
  }

  static v4l2_buffer request_buffer(unsigned index) {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    return buffer;
  }

  void check_capabilities() const {
    v4l2_capability capability{};
    require(VIDIOC_QUERYCAP, &capability, "asking what it can do (is it a video device?)");
    const auto able =
        (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
    if ((able & V4L2_CAP_VIDEO_CAPTURE) == 0 || (able & V4L2_CAP_STREAMING) == 0) {
      throw DeviceLost(params_.device + ": captures no video by streaming");
    }
  }

  /// The first offered format that is grey.
  std::uint32_t choose_format() const {
    std::string offered;
    v4l2_fmtdesc description{};
    description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; call(VIDIOC_ENUM_FMT, &description) == 0; ++description.index) {
      if (v4l2_layout(description.pixelformat)) return description.pixelformat;
      offered += " " + fourcc_text(description.pixelformat);
    }
    throw DeviceLost(params_.device + ": offers none of GREY, Y10, Y12, Y16, YUYV, but" + offered);
  }

  void set_format() {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = static_cast<unsigned>(params_.width_px);
    format.fmt.pix.height = static_cast<unsigned>(params_.height_px);
    format.fmt.pix.pixelformat = choose_format();
    format.fmt.pix.field = V4L2_FIELD_NONE;
    require(VIDIOC_S_FMT, &format, "setting the image format");
    const auto& pix = format.fmt.pix;
    if (static_cast<int>(pix.width) != params_.width_px || static_cast<int>(pix.height) != params_.height_px) {
      throw DeviceLost(fmt::format("{}: gives {} x {} pixels where {} x {} are wanted", params_.device, pix.width,
                                   pix.height, params_.width_px, params_.height_px));
    }
    layout_ = *v4l2_layout(pix.pixelformat);
    row_bytes_ = pix.bytesperline > 0 ? pix.bytesperline : pix.width * static_cast<unsigned>(layout_.bytes);
  }

  /// Devices without a settable rate keep their own.
  void set_rate() const {
    v4l2_streamparm parameters{};
    parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (call(VIDIOC_G_PARM, &parameters) < 0) return;
    if ((parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) return;
    parameters.parm.capture.timeperframe = {1000, static_cast<unsigned>(std::lround(1000 * params_.rate_hz))};
    require(VIDIOC_S_PARM, &parameters, "setting the rate");
  }

  void write_exposure(const ExposureSetting& setting) {
    v4l2_control manual{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL};
    (void)call(VIDIOC_S_CTRL, &manual);  // devices that are always manual do not have it
    const int units = std::max(1, static_cast<int>(std::lround(double(setting.exposure_us) / kExposureUnitUs)));
    v4l2_control exposure{V4L2_CID_EXPOSURE_ABSOLUTE, units};
    require(VIDIOC_S_CTRL, &exposure, "setting the exposure (exposure.mode: device leaves it to the camera)");
    exposure_us_ = exposure.value * kExposureUnitUs;
  }

  void map_buffers() {
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    require(VIDIOC_REQBUFS, &request, "asking for buffers");
    for (unsigned i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = request_buffer(i);
      require(VIDIOC_QUERYBUF, &buffer, "asking for a buffer");
      mappings_.emplace_back(fd_, buffer);
      require(VIDIOC_QBUF, &buffer, "handing a buffer over");
    }
  }

  Time exposure_start(const v4l2_buffer& buffer) const {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
      throw DeviceLost(params_.device + ": its frames are not stamped with the monotonic clock");
    }
    const Time stamp = host_.from_monotonic(std::chrono::seconds(buffer.timestamp.tv_sec) +
                                            std::chrono::microseconds(buffer.timestamp.tv_usec));
    const bool at_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    return at_start ? stamp : stamp - Duration(exposure_us_) - params_.transfer;
  }

  std::optional<Frame> to_frame(const v4l2_buffer& buffer) {
    if (buffer.index >= mappings_.size()) throw DeviceLost(params_.device + ": gave a buffer that does not exist");
    const auto bytes = mappings_[buffer.index].bytes();
    const std::size_t used = std::min<std::size_t>(buffer.bytesused, bytes.size());
    auto image = to_gray8(bytes.first(used), {params_.width_px, params_.height_px}, row_bytes_, layout_);
    if (!image || (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
      ++incomplete_;
      return std::nullopt;
    }
    const Time start = exposure_start(buffer);
    return Frame{*image, buffer.sequence, kSequencePeriod, 0, start, host_.now(), exposure_us_, 0};
  }

  V4l2Params params_;
  HostTime host_;
  Ioctl ioctl_;
  int fd_ = -1;
  GrayLayout layout_;
  std::size_t row_bytes_ = 0;
  int exposure_us_ = 0;
  std::vector<Mapping> mappings_;
  std::int64_t incomplete_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_v4l2(const V4l2Params& params, const HostTime& host, const Ioctl& ioctl) {
  const Ioctl kernel = [](int fd, unsigned long request, void* argument) { return ::ioctl(fd, request, argument); };
  return std::make_unique<V4l2Source>(params, host, ioctl ? ioctl : kernel);
}

std::pair<Frame, Frame> split_halves(const Frame& both) {
  ARPENT_ASSERT(both.image.cols % 2 == 0);
  const int half = both.image.cols / 2;
  std::pair<Frame, Frame> halves{both, both};
  halves.first.image = both.image.colRange(0, half).clone();
  halves.second.image = both.image.colRange(half, 2 * half).clone();
  return halves;
}

std::vector<V4l2Listing> list_v4l2(const std::string& class_folder) {
  std::vector<V4l2Listing> listing;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(class_folder, none)) {
    std::string name;
    std::getline(std::ifstream(entry.path() / "name"), name);
    listing.push_back({"/dev/" + entry.path().filename().string(), name});
  }
  std::sort(listing.begin(), listing.end(), [](const auto& a, const auto& b) { return a.device < b.device; });
  return listing;
}

}  // namespace arpent::camera
