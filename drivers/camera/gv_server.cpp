// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/gv_server.h"

#include <arv.h>

#include "common/error.h"
#include "drivers/camera/gobject.h"

namespace arpent::camera {

struct GvServer::State {
  Render render;
  Owned<ArvGvFakeCamera> camera;  // its thread ends with it, before `render` goes

  static void fill(ArvBuffer* buffer, void* user, guint32 exposure_us, guint32 gain, ArvPixelFormat format) {
    const auto* self = static_cast<const State*>(user);
    std::size_t unused = 0;  // reported as 0 in here: the memory holds width x height bytes
    auto* data = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &unused)));
    cv::Mat1b image(arv_buffer_get_image_height(buffer), arv_buffer_get_image_width(buffer), data);
    const Request request{Time(Duration(static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer) / 1000))),
                          static_cast<std::int64_t>(arv_buffer_get_frame_id(buffer)), static_cast<int>(exposure_us),
                          static_cast<int>(gain), image.size()};
    const cv::Mat1b rendered = format == ARV_PIXEL_FORMAT_MONO_8 ? self->render(request) : cv::Mat1b();
    if (rendered.size() == image.size()) {
      rendered.copyTo(image);
    } else {
      image.setTo(0);
    }
  }
};

GvServer::GvServer(const std::string& address, const std::string& serial, Render render)
    : state_(std::make_unique<State>()) {
  state_->render = std::move(render);
  state_->camera.reset(arv_gv_fake_camera_new(address.c_str(), serial.c_str()));
  if (state_->camera == nullptr || !arv_gv_fake_camera_is_running(state_->camera.get())) {
    throw InputError("no camera can be served on " + address + ": is it an address of this machine (`ip addr add " +
                     address + "/32 dev lo`) and port 3956 free?");
  }
  arv_fake_camera_set_fill_pattern(arv_gv_fake_camera_get_fake_camera(state_->camera.get()), &State::fill,
                                   state_.get());
}

GvServer::~GvServer() = default;

}  // namespace arpent::camera
