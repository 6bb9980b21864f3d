// OpenNI2 devices and .oni recordings: the one file that knows that library.
// SPDX-License-Identifier: BSD-3-Clause
#include <OpenNI.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <thread>

#include "onboard/source/camera_spec.h"
#include "onboard/source/cameras.h"
#include "shared/core/check.h"

namespace kt {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSlice{100};  // between two looks at whether the device is still there

// What the library said last, on one line.
std::string library_error() {
  std::string text = openni::OpenNI::getExtendedError();
  std::erase_if(text, [](char c) { return c == '\n' || c == '\t'; });
  return text.empty() ? "no reason given" : text;
}

void check(openni::Status status, const std::string& what) {
  if (status != openni::STATUS_OK) throw Error(what + ": " + library_error());
}

// Once, and for good: threads of drivers outlive their devices, and would lose the code they run in.
void start_library() {
  static const openni::Status status = openni::OpenNI::initialize();
  check(status, "OpenNI2 cannot start");
}

std::vector<openni::DeviceInfo> present_devices() {
  openni::Array<openni::DeviceInfo> list;
  openni::OpenNI::enumerateDevices(&list);
  std::vector<openni::DeviceInfo> devices;
  for (int i = 0; i < list.getSize(); ++i) devices.push_back(list[i]);
  return devices;
}

bool is_usable(openni::SensorType sensor, const openni::VideoMode& mode) {
  const openni::PixelFormat format = mode.getPixelFormat();
  if (sensor != openni::SENSOR_DEPTH) return format == openni::PIXEL_FORMAT_RGB888;
  return format == openni::PIXEL_FORMAT_DEPTH_1_MM || format == openni::PIXEL_FORMAT_DEPTH_100_UM;
}

std::string text_of(const openni::VideoMode& mode) {
  std::string text = std::to_string(mode.getResolutionX()) + "x" + std::to_string(mode.getResolutionY()) +
                     " at " + std::to_string(mode.getFps()) + " fps";
  if (mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM) text += ", 1 mm";
  if (mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM) text += ", 0.1 mm";
  return text;
}

std::vector<openni::VideoMode> usable_modes(openni::Device& device, openni::SensorType sensor) {
  std::vector<openni::VideoMode> modes;
  const openni::SensorInfo* info = device.getSensorInfo(sensor);
  if (info == nullptr) return modes;
  const auto& all = info->getSupportedVideoModes();
  for (int i = 0; i < all.getSize(); ++i) {
    if (is_usable(sensor, all[i])) modes.push_back(all[i]);
  }
  return modes;
}

std::string name_of(openni::SensorType sensor) { return sensor == openni::SENSOR_DEPTH ? "depth" : "colour"; }

// Whether the device is still plugged in, or the recording at its end, as the library's threads tell.
class Watch final : public openni::OpenNI::DeviceDisconnectedListener,
                    public openni::OpenNI::DeviceStateChangedListener {
 public:
  explicit Watch(std::string uri) : uri_(std::move(uri)) {
    openni::OpenNI::addDeviceDisconnectedListener(this);
    openni::OpenNI::addDeviceStateChangedListener(this);
  }
  ~Watch() override {
    openni::OpenNI::removeDeviceDisconnectedListener(this);
    openni::OpenNI::removeDeviceStateChangedListener(this);
  }
  void onDeviceDisconnected(const openni::DeviceInfo* device) override {
    if (uri_ == device->getUri()) is_gone = true;
  }
  void onDeviceStateChanged(const openni::DeviceInfo* device, openni::DeviceState state) override {
    if (uri_ != device->getUri()) return;
    if (state == openni::DEVICE_STATE_EOF) is_at_end = true;
    if (state == openni::DEVICE_STATE_ERROR) is_gone = true;
  }

  std::atomic<bool> is_gone = false, is_at_end = false;

 private:
  std::string uri_;
};

// The camera of a field of view (rad), its principal point in the middle; none where the device tells no such
// view.
std::optional<Camera> pinhole(const openni::VideoStream& stream) {
  const double across = stream.getHorizontalFieldOfView(), down = stream.getVerticalFieldOfView();
  if (!(across > 0.1 && across < 3 && down > 0.1 && down < 3)) return std::nullopt;
  Camera camera{.width = stream.getVideoMode().getResolutionX(),
                .height = stream.getVideoMode().getResolutionY()};
  camera.fx = 0.5 * camera.width / std::tan(0.5 * across);
  camera.fy = 0.5 * camera.height / std::tan(0.5 * down);
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

template <typename T>
Image<T> image_of(const openni::VideoFrameRef& frame, bool is_mirrored) {
  Image<T> image(frame.getWidth(), frame.getHeight());
  const auto* bytes = static_cast<const uint8_t*>(frame.getData());
  for (int v = 0; v < image.height(); ++v) {
    T* row = image.data() + static_cast<ptrdiff_t>(v) * image.width();
    std::memcpy(row, bytes + static_cast<ptrdiff_t>(v) * frame.getStrideInBytes(),
                static_cast<size_t>(image.width()) * sizeof(T));
    if (is_mirrored) std::reverse(row, row + image.width());
  }
  return image;
}

/// A device or a recording that is open, its streams running.
class OpenNi2Device final : public CameraDevice {
 public:
  OpenNi2Device(const std::string& uri, const CameraSpec& spec) : watch_(uri), has_registration_(false) {
    check(device_.open(uri.c_str()), "openni2:" + uri + " cannot be opened");
    const std::string model = device_.getDeviceInfo().getName();
    info_.name = "openni2:" + uri + (model.empty() ? "" : " (" + model + ")");
    info_.is_recording = device_.isFile();
    info_.has_colour = device_.hasSensor(openni::SENSOR_COLOR);
    open_stream(depth_, openni::SENSOR_DEPTH, spec, is_depth_mirrored_);
    if (info_.has_colour) open_stream(colour_, openni::SENSOR_COLOR, spec, is_colour_mirrored_);
    if (info_.is_recording) {
      play();
      has_registration_ = spec.is_on("registration", true);
    } else {
      register_and_synchronise(spec.is_on("registration", true));
    }
    info_.depth_interval_us = 1'000'000 / std::max(depth_.getVideoMode().getFps(), 1);
    info_.calibration = calibration(model);
    check(depth_.start(), info_.name + ": the depth stream does not start");
    if (info_.has_colour) {
      info_.colour_interval_us = 1'000'000 / std::max(colour_.getVideoMode().getFps(), 1);
      check(colour_.start(), info_.name + ": the colour stream does not start");
    }
  }

  ~OpenNi2Device() override {
    depth_.stop();
    if (info_.has_colour) colour_.stop();
    // Threads of a driver may be at an image still, which they give to a stream that must be there.
    if (!info_.is_recording) std::this_thread::sleep_for(kSlice);
  }

  CameraEvent read(milliseconds timeout) override {
    openni::VideoStream* streams[] = {&depth_, &colour_};
    for (milliseconds waited{0}; waited < timeout; waited += kSlice) {
      int ready = -1;
      const auto status = openni::OpenNI::waitForAnyStream(streams, info_.has_colour ? 2 : 1, &ready,
                                                           static_cast<int>(kSlice.count()));
      if (watch_.is_gone) throw Error("unplugged");
      if (status == openni::STATUS_OK) return event(*streams[ready], ready == 0);
      if (status != openni::STATUS_TIME_OUT) throw Error("reading failed: " + library_error());
      if (watch_.is_at_end) return {.kind = CameraEvent::Kind::kEnd};
    }
    return {};
  }

  const CameraInfo& info() const override { return info_; }

 private:
  void open_stream(openni::VideoStream& stream, openni::SensorType sensor, const CameraSpec& spec,
                   bool& is_mirrored) {
    check(stream.create(device_, sensor), info_.name + " has no " + name_of(sensor) + " stream");
    if (!info_.is_recording) choose_mode(stream, sensor, spec);
    if (!is_usable(sensor, stream.getVideoMode()))
      throw Error(info_.name + ": its " + name_of(sensor) +
                  " images come in a format that is none of 1 mm, 0.1 mm and RGB");
    stream.setMirroringEnabled(false);  // where it cannot, the rows are turned round here
    is_mirrored = stream.getMirroringEnabled();
  }

  // The size and rate asked for, else the usual ones, else what the device would do by itself.
  void choose_mode(openni::VideoStream& stream, openni::SensorType sensor, const CameraSpec& spec) {
    const auto asked_size = spec.size("size");
    const auto asked_rate = spec.number("fps");
    const ImageSize size = asked_size.value_or(kUsualSize);
    const int rate = asked_rate.value_or(kUsualRate_hz);
    const auto is_asked = [&](const openni::VideoMode& mode) {
      return mode.getResolutionX() == size.width && mode.getResolutionY() == size.height &&
             mode.getFps() == rate && is_usable(sensor, mode);
    };
    if (is_asked(stream.getVideoMode())) return;
    std::string offered;
    for (const openni::VideoMode& mode : usable_modes(device_, sensor)) {
      offered += "\n  " + text_of(mode);
      if (is_asked(mode))
        return check(stream.setVideoMode(mode), info_.name + ": cannot set " + text_of(mode));
    }
    if (!asked_size && !asked_rate && is_usable(sensor, stream.getVideoMode())) return;
    throw Error(info_.name + ": no " + name_of(sensor) + " images of " + std::to_string(size.width) + "x" +
                std::to_string(size.height) + " at " + std::to_string(rate) + " fps; it offers" + offered);
  }

  void play() {
    openni::PlaybackControl* playback = device_.getPlaybackControl();
    if (playback == nullptr) throw Error(info_.name + ": the recording cannot be played");
    check(playback->setSpeed(-1),
          info_.name + ": cannot be read image by image");  // each waits to be asked for
    check(playback->setRepeatEnabled(false), info_.name + ": has no end");
    if (const int frames = playback->getNumberOfFrames(depth_); frames > 0) info_.frame_count = frames;
  }

  void register_and_synchronise(bool is_wanted) {
    constexpr auto kRegistered = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    const bool is_offered = info_.has_colour && device_.isImageRegistrationModeSupported(kRegistered);
    has_registration_ =
        is_wanted && is_offered && device_.setImageRegistrationMode(kRegistered) == openni::STATUS_OK;
    if (!has_registration_ && is_offered) device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_OFF);
    if (info_.has_colour) device_.setDepthColorSyncEnabled(true);  // a device that cannot, refuses
  }

  // Registered depth is seen by the colour camera. Without registration nothing tells how the two stand.
  std::optional<Calibration> calibration(const std::string& model) const {
    if (info_.has_colour && !has_registration_) return std::nullopt;
    Calibration calibration;
    calibration.name = "openni2 " + model;
    const auto colour = info_.has_colour ? pinhole(colour_) : pinhole(depth_);
    if (!colour) return std::nullopt;
    calibration.colour = calibration.depth = *colour;
    const openni::VideoMode mode = depth_.getVideoMode();
    const double scale = static_cast<double>(mode.getResolutionX()) / colour->width;
    calibration.depth.width = mode.getResolutionX();
    calibration.depth.height = mode.getResolutionY();
    calibration.depth.fx *= scale;
    calibration.depth.fy *= scale;
    calibration.depth.cx = 0.5 * (calibration.depth.width - 1);
    calibration.depth.cy = 0.5 * (calibration.depth.height - 1);
    calibration.depth_unit_m = mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM ? 1e-4 : 1e-3;
    return calibration;
  }

  CameraEvent event(openni::VideoStream& stream, bool is_depth) {
    openni::VideoFrameRef frame;
    check(stream.readFrame(&frame), "reading failed");
    CameraEvent event{.kind = is_depth ? CameraEvent::Kind::kDepth : CameraEvent::Kind::kColour,
                      .is_depth = is_depth,
                      .stamp_us = static_cast<int64_t>(frame.getTimestamp()),
                      .counter = frame.getFrameIndex()};
    const size_t pixel_bytes = is_depth ? sizeof(uint16_t) : sizeof(Rgb8);
    if (static_cast<size_t>(frame.getDataSize()) <
            static_cast<size_t>(frame.getStrideInBytes()) * frame.getHeight() ||
        static_cast<size_t>(frame.getStrideInBytes()) < pixel_bytes * static_cast<size_t>(frame.getWidth())) {
      event.kind = CameraEvent::Kind::kDamaged;
      event.reason = "cut off by the driver";
    } else if (is_depth) {
      event.depth = image_of<uint16_t>(frame, is_depth_mirrored_);
    } else {
      event.colour = image_of<Rgb8>(frame, is_colour_mirrored_);
    }
    return event;
  }

  Watch watch_;
  openni::Device device_;
  openni::VideoStream depth_, colour_;  // behind the device: destroyed before it
  bool is_depth_mirrored_ = false, is_colour_mirrored_ = false, has_registration_;
  CameraInfo info_;
};

// Whether it may be the same device, plugged in again at another port.
bool is_like(const openni::DeviceInfo& a, const openni::DeviceInfo& b) {
  return a.getUsbVendorId() == b.getUsbVendorId() && a.getUsbProductId() == b.getUsbProductId() &&
         std::strcmp(a.getName(), b.getName()) == 0;
}

/// Finds the device that a text names, and later the same one again.
class Finder {
 public:
  explicit Finder(std::string asked) : asked_(std::move(asked)) {}

  std::string uri() {
    const std::vector<openni::DeviceInfo> devices = present_devices();
    for (const openni::DeviceInfo& device : devices) {
      if ((chosen_ ? chosen_->getUri() : asked_) == device.getUri()) return choose(device);
    }
    for (const openni::DeviceInfo& device : devices) {
      if (chosen_ ? is_like(device, *chosen_) : asked_.empty()) return choose(device);
    }
    if (chosen_) throw Error("not plugged in");
    if (asked_.empty()) {
      throw Error("openni2: no device is there; kintsugi-collect --list-cameras shows what is " +
                  std::string("(docs/cameras.md)"));
    }
    return asked_;  // recordings, and devices that a driver finds only when asked for
  }

 private:
  std::string choose(const openni::DeviceInfo& device) {
    chosen_ = device;
    return device.getUri();
  }

  std::string asked_;
  std::optional<openni::DeviceInfo> chosen_;
};

}  // namespace

CameraOpener openni2_camera(const std::string& text) {
  const CameraSpec spec = CameraSpec::parse("openni2", text, {"size", "fps", "registration"});
  if (spec.device.ends_with(".oni") && !std::filesystem::is_regular_file(spec.device))
    throw Error("openni2:" + spec.device + ": there is no such recording");
  start_library();
  return [spec, finder = std::make_shared<Finder>(spec.device)] {
    return std::make_unique<OpenNi2Device>(finder->uri(), spec);
  };
}

std::vector<FoundCamera> openni2_cameras() {
  start_library();
  std::vector<FoundCamera> cameras;
  for (const openni::DeviceInfo& info : present_devices()) {
    FoundCamera found{.spec = std::string("openni2:") + info.getUri(),
                      .name = std::string(info.getVendor()) + " " + info.getName(),
                      .modes = {}};
    openni::Device device;
    if (device.open(info.getUri()) != openni::STATUS_OK) {
      found.modes.push_back("cannot be opened: " + library_error());
    } else {
      for (const auto sensor : {openni::SENSOR_DEPTH, openni::SENSOR_COLOR}) {
        for (const auto& mode : usable_modes(device, sensor))
          found.modes.push_back(name_of(sensor) + " " + text_of(mode));
      }
    }
    cameras.push_back(std::move(found));
  }
  return cameras;
}

}  // namespace kt
