// Passes the calls on to the kernel.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/v4l2_system.h"

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace kt {
namespace {

template <typename Call>
int again_where_interrupted(Call call) {
  int result = call();
  while (result == -1 && errno == EINTR) result = call();
  return result;
}

class LinuxV4l2 final : public V4l2System {
 public:
  int open(const std::string& path) override {
    return again_where_interrupted([&] { return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); });
  }
  int close(int fd) override { return ::close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) override {
    return again_where_interrupted([&] { return ::ioctl(fd, request, argument); });
  }
  void* map(int fd, size_t bytes, int64_t offset) override {
    void* address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    return address == MAP_FAILED ? nullptr : address;
  }
  void unmap(void* address, size_t bytes) override { ::munmap(address, bytes); }
  int poll(pollfd* files, size_t count, int timeout_ms) override {
    return again_where_interrupted([&] { return ::poll(files, count, timeout_ms); });
  }
  int64_t monotonic_us() override {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000;
  }
  std::vector<std::string> nodes() override {
    std::vector<std::string> paths;
    std::error_code error;  // no /dev: no nodes
    for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("video") && name.find_first_not_of("0123456789", 5) == std::string::npos &&
          name.size() > 5)
        paths.push_back(entry.path().string());
    }
    std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
      return std::pair(a.size(), a) < std::pair(b.size(), b);
    });
    return paths;
  }
};

}  // namespace

V4l2System& linux_v4l2() {
  static LinuxV4l2 system;
  return system;
}

}  // namespace kt
