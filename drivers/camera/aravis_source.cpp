// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/aravis_source.h"

#include <arv.h>
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <deque>
#include <thread>

#include "common/error.h"
#include "drivers/camera/gobject.h"
#include "drivers/camera/gray.h"
#include "drivers/camera/gvcp_probe.h"

namespace arpent::camera {
namespace {

constexpr Duration kProbePatience{300000};
/// Settings that frames under way may still have been taken with.
constexpr std::size_t kSettingsKept = 8;
/// GigE Vision's 16-bit block ids; the counter recognises extended ones by their size.
constexpr std::int64_t kGigeIdPeriod = 65535;
constexpr const char* kFormats[] = {"Mono8", "Mono16", "Mono12", "Mono10"};

std::string address_of(ArvCamera* camera) {
  ArvDevice* device = arv_camera_get_device(camera);
  if (!ARV_IS_GV_DEVICE(device)) return "";
  const Owned<GSocketAddress> socket_address(
      G_SOCKET_ADDRESS(g_object_ref(arv_gv_device_get_device_address(ARV_GV_DEVICE(device)))));
  gchar* text =
      g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(socket_address.get())));
  std::string address = text;
  g_free(text);
  return address;
}

/// The region of the wanted size in the middle of the sensor.
void set_region(ArvCamera* camera, const ImageFormat& format) {
  GFault fault;
  gint width = 0;
  gint height = 0;
  arv_camera_get_sensor_size(camera, &width, &height, fault);
  fault.require("sensor size");
  if (width < format.width_px || height < format.height_px) {
    throw DeviceLost(fmt::format("its sensor has {} x {} pixels, {} x {} are wanted", width, height, format.width_px,
                                 format.height_px));
  }
  const auto centred = [](gint space, gint step) { return space / 2 / std::max(step, 1) * std::max(step, 1); };
  const gint x_step = arv_camera_get_x_offset_increment(camera, fault);
  const gint y_step = arv_camera_get_y_offset_increment(camera, fault);
  arv_camera_set_region(camera, centred(width - format.width_px, x_step), centred(height - format.height_px, y_step),
                        format.width_px, format.height_px, fault);
  fault.require("image region");
}

void set_pixel_format(ArvCamera* camera) {
  GFault fault;
  for (const char* format : kFormats) {
    arv_camera_set_pixel_format_from_string(camera, format, fault);
    if (!fault.failed()) return;
  }
  guint count = 0;
  const char** offered = arv_camera_dup_available_pixel_formats_as_strings(camera, &count, fault);
  std::string names;
  for (guint i = 0; offered != nullptr && i < count; ++i) names += std::string(" ") + offered[i];
  g_free(offered);
  throw DeviceLost("it offers none of Mono8, Mono16, Mono12, Mono10, but" + names +
                   ": stereo needs monochrome images, no Bayer mosaic");
}

void set_trigger(ArvCamera* camera, const AravisParams& params, const ImageFormat& format) {
  GFault fault;
  arv_camera_clear_triggers(camera, fault);
  fault.require("switching triggers off");
  if (params.trigger.empty()) {
    arv_camera_set_frame_rate(camera, format.rate_hz, fault);
    fault.require("frame rate");
  } else {
    arv_camera_set_trigger(camera, params.trigger.c_str(), fault);
    fault.require("trigger " + params.trigger);
  }
}

class AravisSource : public FrameSource {
 public:
  AravisSource(const AravisDevice& device, const AravisParams& params, const ImageFormat& format,
               const ExposureSetting& exposure, const HostTime& host)
      : host_(host) {
    GFault fault;
    camera_.reset(arv_camera_new(device.name.c_str(), fault));
    fault.require("opening it");
    if (camera_ == nullptr) throw DeviceLost("it cannot be opened");
    address_ = address_of(camera());
    g_signal_connect(arv_camera_get_device(camera()), "control-lost", G_CALLBACK(&AravisSource::on_control_lost), this);
    configure(device, params, format, exposure);
    start(params);
  }

  ~AravisSource() override {
    if (camera_ == nullptr) return;
    g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera()), this);
    if (!lost_ && (address_.empty() || gige_camera_answers(address_, kProbePatience))) {
      GFault fault;
      arv_camera_stop_acquisition(camera(), fault);
      return;
    }
    // Aravis says goodbye to a dead camera for seven seconds (retries of the heartbeat and of the last register write):
    // meanwhile we want to look for its return, so that is left to a thread of its own.
    std::thread([camera = std::move(camera_), stream = std::move(stream_)]() mutable {
      stream.reset();
      camera.reset();
    }).detach();
  }

  std::optional<Frame> next(Duration wait) override {
    if (lost_) throw DeviceLost("control of the camera was lost: unplugged, or taken over by another program");
    const Owned<ArvBuffer> buffer(
        arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(std::max<std::int64_t>(wait.count(), 1))));
    if (buffer == nullptr) return std::nullopt;
    std::optional<Frame> frame;
    if (arv_buffer_get_status(buffer.get()) == ARV_BUFFER_STATUS_SUCCESS) {
      frame = to_frame(buffer.get());
    } else {
      ++incomplete_;
    }
    arv_stream_push_buffer(stream_.get(), ARV_BUFFER(g_object_ref(buffer.get())));
    return frame;
  }

  void set_exposure(const ExposureSetting& setting) override {
    GFault fault;
    arv_camera_set_exposure_time(camera(), setting.exposure_us, fault);
    fault.require(fmt::format("exposure of {} us", setting.exposure_us));
    if (has_gain_) arv_camera_set_gain(camera(), setting.gain_db, fault);
    fault.require(fmt::format("gain of {:.1f} dB", setting.gain_db));
    remember_setting();
  }

  bool answers() override {
    if (lost_) return false;
    return address_.empty() || gige_camera_answers(address_, kProbePatience);
  }

  std::int64_t incomplete() const override { return incomplete_; }

 private:
  struct Written {
    Time when;
    ExposureSetting setting;
  };

  static void on_control_lost(ArvDevice* /*device*/, AravisSource* self) { self->lost_ = true; }
  ArvCamera* camera() const { return camera_.get(); }

  void configure(const AravisDevice& device, const AravisParams& params, const ImageFormat& format,
                 const ExposureSetting& exposure) {
    GFault fault;
    set_region(camera(), format);
    set_pixel_format(camera());
    set_trigger(camera(), params, format);
    if (arv_camera_is_exposure_auto_available(camera(), fault)) {
      arv_camera_set_exposure_time_auto(camera(), ARV_AUTO_OFF, fault);
      fault.require("switching automatic exposure off");
    }
    if (arv_camera_is_gain_auto_available(camera(), fault)) {
      arv_camera_set_gain_auto(camera(), ARV_AUTO_OFF, fault);
      fault.require("switching automatic gain off");
    }
    has_gain_ = arv_camera_is_gain_available(camera(), fault);
    if (params.packet_size_bytes > 0 && arv_camera_is_gv_device(camera())) {
      arv_camera_gv_set_packet_size(camera(), params.packet_size_bytes, fault);
      fault.require("packet size");
    }
    if (!device.features.empty()) {
      arv_device_set_features_from_string(arv_camera_get_device(camera()), device.features.c_str(), fault);
      fault.require("features '" + device.features + "'");
    }
    set_exposure(exposure);
  }

  void start(const AravisParams& params) {
    GFault fault;
    stream_.reset(arv_camera_create_stream(camera(), nullptr, nullptr, fault));
    fault.require("opening its stream");
    if (ARV_IS_GV_STREAM(stream_.get())) {
      g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_AUTO, nullptr);
    }
    const std::size_t payload = arv_camera_get_payload(camera(), fault);
    fault.require("payload size");
    for (int i = 0; i < params.buffers; ++i) arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
    arv_camera_start_acquisition(camera(), fault);
    fault.require("starting the acquisition");
  }

  /// What the device rounded the setting to.
  void remember_setting() {
    GFault fault;
    const double exposure_us = arv_camera_get_exposure_time(camera(), fault);
    fault.require("reading the exposure back");
    const double gain_db = has_gain_ ? arv_camera_get_gain(camera(), fault) : 0;
    fault.require("reading the gain back");
    written_.push_back({host_.now(), {static_cast<int>(std::lround(exposure_us)), gain_db}});
    if (written_.size() > kSettingsKept) written_.pop_front();
  }

  /// The setting in force when a frame's exposure began.
  ExposureSetting setting_at(Time arrival) const {
    for (auto w = written_.rbegin(); w != written_.rend(); ++w) {
      if (w->when <= arrival - Duration(w->setting.exposure_us)) return w->setting;
    }
    return written_.front().setting;
  }

  std::optional<Frame> to_frame(ArvBuffer* buffer) {
    const auto layout = genicam_layout(static_cast<std::uint32_t>(arv_buffer_get_image_pixel_format(buffer)));
    if (!layout) throw DeviceLost(layout.fault());
    std::size_t size = 0;
    const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
    const cv::Size size_px(arv_buffer_get_image_width(buffer), arv_buffer_get_image_height(buffer));
    gint x_padding = 0;
    gint y_padding = 0;
    arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
    const auto row_bytes = static_cast<std::size_t>(size_px.width * layout->bytes + x_padding);
    auto image = to_gray8({data, size}, size_px, row_bytes, *layout);
    if (!image) {
      ++incomplete_;
      return std::nullopt;
    }
    Frame frame;
    frame.image = *image;
    frame.frame_id = static_cast<std::int64_t>(arv_buffer_get_frame_id(buffer));
    frame.id_period = address_.empty() ? 0 : kGigeIdPeriod;
    frame.device_time = Time(Duration(static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer) / 1000)));
    const auto age_us = g_get_real_time() - static_cast<gint64>(arv_buffer_get_system_timestamp(buffer) / 1000);
    frame.arrival = host_.now() - Duration(age_us);
    const ExposureSetting setting = setting_at(frame.arrival);
    frame.exposure_us = setting.exposure_us;
    frame.gain_db = setting.gain_db;
    return frame;
  }

  HostTime host_;
  std::string address_;  ///< of a GigE Vision camera, otherwise empty
  bool has_gain_ = false;
  std::atomic<bool> lost_{false};
  std::int64_t incomplete_ = 0;
  std::deque<Written> written_;
  Owned<ArvCamera> camera_;
  Owned<ArvStream> stream_;  // goes before its camera
};

}  // namespace

std::unique_ptr<FrameSource> open_aravis(const AravisDevice& device, const AravisParams& params,
                                         const ImageFormat& format, const ExposureSetting& exposure,
                                         const HostTime& host) {
  if (is_ipv4(device.name) && !gige_camera_answers(device.name, kProbePatience)) {
    throw DeviceLost("no GigE Vision camera answers at " + device.name);
  }
  return std::make_unique<AravisSource>(device, params, format, exposure, host);
}

void enable_fake_camera() {
  arv_enable_interface("Fake");
}

std::vector<AravisListing> list_aravis(bool with_fake) {
  if (with_fake) enable_fake_camera();
  arv_update_device_list();
  const auto text = [](const char* value) { return std::string(value == nullptr ? "" : value); };
  std::vector<AravisListing> listing;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    if (!with_fake && text(arv_get_device_protocol(i)) == "Fake") continue;
    listing.push_back({text(arv_get_device_id(i)), text(arv_get_device_protocol(i)), text(arv_get_device_address(i))});
  }
  return listing;
}

}  // namespace arpent::camera
