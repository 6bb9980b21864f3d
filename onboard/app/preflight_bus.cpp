// The test of the LCM network.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>

#include "onboard/app/preflight.h"
#include "shared/wire/lcm_bus.h"

namespace kt {
namespace {

using Verdict = Finding::Verdict;

constexpr std::string_view kChannel = "KINTSUGI_CHECK";
constexpr int64_t kBufferForFrames = 4 << 20;  // docs/lcm.md: with it no frame was lost at 9 MB/s

int64_t largest_receive_buffer() {
  int64_t bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> bytes;
  return bytes;
}

bool comes_back(LcmBus& bus) {
  bool is_heard = false;
  bus.subscribe(kChannel, 1, [&](std::span<const uint8_t>) { is_heard = true; });
  const std::array<uint8_t, 8> message{};
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  while (!is_heard && std::chrono::steady_clock::now() < give_up) {
    if (!bus.publish(kChannel, message)) return false;
    if (bus.receive(std::chrono::milliseconds(200)) == LcmBus::Received::kEnd) return false;
  }
  return is_heard;
}

}  // namespace

Finding check_bus(const std::string& url, bool takes_frames) {
  LcmBus bus(url);
  if (bus.waits_for_receiver()) return {Verdict::kFine, "network", bus.url() + ": a log, no network"};
  if (!comes_back(bus)) {
    return {
        Verdict::kBroken, "network",
        bus.url() +
            ": a message sent did not come back; is there a route for multicast (ip link set lo multicast "
            "on; ip route add 224.0.0.0/4 dev lo), and does the firewall let it through?"};
  }
  Finding finding{Verdict::kFine, "network", bus.url() + ": a message sent came back"};
  const int64_t buffer = largest_receive_buffer();
  if (takes_frames && bus.url().starts_with("udpm") && buffer < kBufferForFrames) {
    finding.verdict = Verdict::kDoubtful;
    finding.text += ", but sockets get a receive buffer of " + std::to_string(buffer / 1024) +
                    " KiB at most and will lose frames: sysctl -w net.core.rmem_max=8388608";
  }
  return finding;
}

}  // namespace kt
