// The driver side of the simulated camera.
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/onboard/source/simulated_openni2.h"

#include <algorithm>
#include <cmath>
#include <cstring>

// What the driver API takes from a library that is not installed with it.
#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete (pointer)
#include "Driver/OniDriverAPI.h"

namespace kt::test {
namespace {

using oni::driver::DeviceBase;
using oni::driver::DriverBase;
using oni::driver::StreamBase;

OniVideoMode mode_of(bool is_depth) {
  const Calibration& calibration = simulated_openni2().calibration();
  const kt::Camera& camera = is_depth ? calibration.depth : calibration.colour;
  const OniPixelFormat depth =
      calibration.depth_unit_m < 5e-4 ? ONI_PIXEL_FORMAT_DEPTH_100_UM : ONI_PIXEL_FORMAT_DEPTH_1_MM;
  return {is_depth ? depth : ONI_PIXEL_FORMAT_RGB888, camera.width, camera.height, 30};
}

template <typename T>
OniStatus answer(const T& value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof(T));
  return ONI_STATUS_OK;
}

class Stream final : public StreamBase {
 public:
  explicit Stream(bool is_depth) : is_depth_(is_depth) {}

  OniStatus start() override {
    is_started_ = true;
    return ONI_STATUS_OK;
  }
  void stop() override { is_started_ = false; }
  bool is_started() const { return is_started_; }

  OniBool isPropertySupported(int property) override {
    return property == ONI_STREAM_PROPERTY_VIDEO_MODE || property == ONI_STREAM_PROPERTY_MIRRORING ||
           property == ONI_STREAM_PROPERTY_CROPPING;
  }
  OniStatus getProperty(int property, void* data, int* size) override {
    const OniVideoMode mode = mode_of(is_depth_);
    const Calibration& calibration = simulated_openni2().calibration();
    const kt::Camera& camera = is_depth_ ? calibration.depth : calibration.colour;
    switch (property) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return answer(mode, data, size);
      case ONI_STREAM_PROPERTY_CROPPING:
        return answer(OniCropping{}, data, size);
      case ONI_STREAM_PROPERTY_MIRRORING:
        return answer(is_mirrored_, data, size);
      case ONI_STREAM_PROPERTY_STRIDE:
        return answer(mode.resolutionX * (is_depth_ ? 2 : 3), data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return answer(65535, data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return answer(static_cast<float>(2 * std::atan(0.5 * camera.width / camera.fx)), data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return answer(static_cast<float>(2 * std::atan(0.5 * camera.height / camera.fy)), data, size);
      default:
        return ONI_STATUS_NOT_IMPLEMENTED;
    }
  }
  OniStatus setProperty(int property, const void* data, int size) override {
    if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) {
      const OniVideoMode own = mode_of(is_depth_);
      return std::memcmp(data, &own, sizeof(own)) == 0 ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    if (property != ONI_STREAM_PROPERTY_MIRRORING || size != sizeof(OniBool) ||
        !simulated_openni2().offers_unmirrored())
      return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(&is_mirrored_, data, sizeof(is_mirrored_));
    return ONI_STATUS_OK;
  }

  void show(const SimulatedOpenNi2::Image& image) {
    OniFrame* frame = getServices().acquireFrame();
    const OniVideoMode mode = mode_of(is_depth_);
    frame->sensorType = is_depth_ ? ONI_SENSOR_DEPTH : ONI_SENSOR_COLOR;
    frame->videoMode = mode;
    frame->width = mode.resolutionX;
    frame->height = mode.resolutionY;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->croppingEnabled = FALSE;
    frame->frameIndex = image.index;
    frame->timestamp =
        static_cast<uint64_t>(is_depth_ ? image.frame.timestamp_us : image.frame.colour_timestamp_us);
    if (is_depth_) {
      fill(frame, image.frame.depth);
    } else {
      fill(frame, image.frame.colour);
    }
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

 private:
  template <typename T>
  void fill(OniFrame* frame, const kt::Image<T>& image) const {
    frame->stride = static_cast<int>(image.width() * sizeof(T));
    frame->dataSize = frame->stride * image.height();
    auto* pixels = static_cast<T*>(frame->data);
    std::memcpy(pixels, image.data(), static_cast<size_t>(frame->dataSize));
    for (int v = 0; is_mirrored_ && v < image.height(); ++v)
      std::reverse(pixels + static_cast<ptrdiff_t>(v) * image.width(),
                   pixels + static_cast<ptrdiff_t>(v + 1) * image.width());
  }

  bool is_depth_, is_started_ = false;
  OniBool is_mirrored_ = TRUE;
};

class Device final : public DeviceBase {
 public:
  Device() {
    for (const bool is_depth : {true, false}) {
      OniSensorInfo& sensor = sensors_[is_depth ? 0 : 1];
      modes_[is_depth ? 0 : 1] = mode_of(is_depth);
      sensor = {is_depth ? ONI_SENSOR_DEPTH : ONI_SENSOR_COLOR, 1, &modes_[is_depth ? 0 : 1]};
    }
  }
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_;
    *count = 2;
    return ONI_STATUS_OK;
  }
  StreamBase* createStream(OniSensorType sensor) override {
    Stream*& stream = streams_[sensor == ONI_SENSOR_DEPTH ? 0 : 1];
    return stream = new Stream(sensor == ONI_SENSOR_DEPTH);
  }
  void destroyStream(StreamBase* stream) override {
    for (Stream*& own : streams_) own = own == stream ? nullptr : own;
    delete stream;
  }
  OniStatus tryManualTrigger() override {
    if (streams_[0] == nullptr || !streams_[0]->is_started()) return ONI_STATUS_OK;
    if (streams_[1] != nullptr && !streams_[1]->is_started()) return ONI_STATUS_OK;
    SimulatedOpenNi2::Image image;
    if (!simulated_openni2().take(&image)) return ONI_STATUS_OK;
    if (Stream* stream = streams_[image.is_depth ? 0 : 1]) stream->show(image);
    return ONI_STATUS_OK;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || simulated_openni2().offers_registration();
  }
  OniBool isPropertySupported(int property) override {
    return property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniStatus setProperty(int property, const void* data, int) override {
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    simulated_openni2().set_registered(*static_cast<const OniImageRegistrationMode*>(data) !=
                                       ONI_IMAGE_REGISTRATION_OFF);
    return ONI_STATUS_OK;
  }

 private:
  OniVideoMode modes_[2];
  OniSensorInfo sensors_[2];
  Stream* streams_[2] = {};
};

class Driver final : public DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) { the_one = this; }
  ~Driver() override { the_one = nullptr; }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    const OniStatus status = DriverBase::initialize(connected, disconnected, changed, cookie);
    if (!plugged_uri.empty()) tell(true);
    return status;
  }
  DeviceBase* deviceOpen(const char*, const char*) override { return new Device; }
  void deviceClose(DeviceBase* device) override { delete device; }
  void shutdown() override {}

  void tell(bool is_plugged) {
    std::memset(&info_, 0, sizeof(info_));
    std::strncpy(info_.uri, plugged_uri.c_str(), sizeof(info_.uri) - 1);
    std::strncpy(info_.vendor, "Kintsugi", sizeof(info_.vendor) - 1);
    std::strncpy(info_.name, "Simulated", sizeof(info_.name) - 1);
    info_.usbVendorId = 0x1d27;
    info_.usbProductId = 0x0609;
    if (is_plugged) {
      deviceConnected(&info_);
    } else {
      deviceDisconnected(&info_);
    }
  }

  static inline Driver* the_one = nullptr;
  static inline std::string plugged_uri;

 private:
  OniDeviceInfo info_{};
};

}  // namespace

void SimulatedOpenNi2::plug(const std::string& uri) {
  Driver::plugged_uri = uri;
  if (Driver::the_one != nullptr) Driver::the_one->tell(true);
}

void SimulatedOpenNi2::unplug() {
  if (Driver::the_one != nullptr) Driver::the_one->tell(false);
  Driver::plugged_uri.clear();
  const std::lock_guard lock(mutex_);
  images_.clear();
  depth_index_ = colour_index_ = 0;
}

void SimulatedOpenNi2::show(const RgbdFrame& frame) {
  const std::lock_guard lock(mutex_);
  images_.push_back({frame, true, ++depth_index_});
  images_.push_back({frame, false, ++colour_index_});
}

void SimulatedOpenNi2::show_depth(const RgbdFrame& frame) {
  const std::lock_guard lock(mutex_);
  images_.push_back({frame, true, ++depth_index_});
}

void SimulatedOpenNi2::drop_depth(int count) {
  const std::lock_guard lock(mutex_);
  depth_index_ += count;
}

bool SimulatedOpenNi2::has_shown_all() {
  const std::lock_guard lock(mutex_);
  return images_.empty();
}

bool SimulatedOpenNi2::take(Image* image) {
  const std::lock_guard lock(mutex_);
  if (images_.empty()) return false;
  *image = std::move(images_.front());
  images_.pop_front();
  return true;
}

SimulatedOpenNi2& simulated_openni2() {
  static SimulatedOpenNi2 device;
  return device;
}

}  // namespace kt::test

ONI_EXPORT_DRIVER(kt::test::Driver)
