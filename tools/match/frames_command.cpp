// Which frames are compared, and what is done to the later of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/match/frames_command.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>

#include "onboard/loops/keyframe_index.h"
#include "onboard/source/frame_source.h"
#include "tools/eval/groundtruth.h"
#include "tools/match/disturbance.h"
#include "tools/match/pair_report.h"

namespace kt {
namespace {

struct Disturbing {
  std::string name;
  double level = 0;
};
struct Kept {
  KnownPlace place;
  RgbdFrame frame;  // where it may be disturbed
  std::optional<Pose> truth;
};
struct Chosen {
  int64_t from = 0, to = 0;
  bool is_disturbed = false;
};

std::vector<Chosen> named_pairs(const FramesCommand& command) {
  std::vector<Chosen> result;
  for (const std::string& text : command.pairs) {
    long long a = 0, b = 0;
    char end = 0;
    if (std::sscanf(text.c_str(), "%lld,%lld%c", &a, &b, &end) != 2 || a >= b)
      throw Error("--pairs: '" + text + "' is not FROM,TO with FROM before TO");
    result.push_back({a, b, true});
  }
  return result;
}

std::vector<Disturbing> wanted(const FramesCommand& command) {
  std::vector<Disturbing> result;
  for (const std::string& text : command.disturbances) {
    const size_t colon = text.find(':');
    const std::string name = text.substr(0, colon);
    disturbance_of(name);
    std::stringstream levels(colon == std::string::npos ? "" : text.substr(colon + 1));
    for (std::string word; std::getline(levels, word, ',');) {
      double level = 0;
      if (!CLI::detail::lexical_cast(word, level) || !(level >= 0 && level <= 1000))
        throw Error("--disturb: '" + word + "' is no level");
      result.push_back({name, level});
    }
  }
  return result;
}

std::vector<Chosen> found_pairs(const FramesCommand& command, const std::map<int64_t, Kept>& kept,
                                const PinholeParams& camera) {
  std::vector<Chosen> result;
  std::vector<size_t> near;
  for (auto from = kept.begin(); from != kept.end(); ++from) {
    for (auto to = std::next(from); to != kept.end(); ++to) {
      if (!from->second.truth || !to->second.truth) continue;
      const ViewChange change =
          view_change(camera, from->second.place.place.keyframe.depth, to->second.place.place.keyframe.depth,
                      from->second.truth->inverse() * *to->second.truth);
      if (change.overlap < command.least_overlap) continue;
      if (change.viewpoint_deg <= command.most_degrees && to->first - from->first >= command.apart)
        near.push_back(result.size());
      result.push_back({from->first, to->first, false});
    }
  }
  const size_t count = std::min(command.most_pairs, near.size());
  for (size_t k = 0; k < count; ++k) result[near[k * near.size() / count]].is_disturbed = true;
  return result;
}

std::map<int64_t, Kept> read(const FramesCommand& command, FrameSource& frames,
                             const std::vector<Chosen>& named, PlaceMaker* maker, Stopwatch* watch) {
  std::map<int64_t, Kept> kept;
  KeyframeIndex index(maker->comparer().vocabulary().word_count());
  for (SourceItem item = frames.next(); item.kind != SourceItem::Kind::kEnd; item = frames.next()) {
    if (item.kind != SourceItem::Kind::kFrame || item.frame.colour.empty()) continue;
    const int64_t number = item.frame.sequence;
    const auto is_its = [&](const Chosen& pair) { return pair.from == number || pair.to == number; };
    if (named.empty() ? number % command.every != 0 : std::none_of(named.begin(), named.end(), is_its))
      continue;
    Kept& one = kept[number];
    one.place = maker->make(item.frame);
    watch->time("search", [&] { return index.search(one.place.bag, index.size(), 0.01f, 3); });
    index.add(one.place.bag);
    if (!command.disturbances.empty()) one.frame = std::move(item.frame);
  }
  for (const Chosen& pair : named) {
    for (const int64_t number : {pair.from, pair.to})
      if (!kept.contains(number))
        throw Error(command.source + " has no frame " + std::to_string(number) + " with colour");
  }
  if (command.groundtruth.empty()) return kept;
  std::vector<int64_t> stamps_us;
  for (const auto& [number, one] : kept) stamps_us.push_back(one.place.place.keyframe.timestamp_us);
  const auto truth = poses_at(read_groundtruth(command.groundtruth), stamps_us);
  size_t k = 0;
  for (auto& [number, one] : kept) one.truth = truth[k++];
  return kept;
}

}  // namespace

void FramesCommand::add_to(CLI::App& app) {
  app.add_option("source", source, "recording, as --input of kintsugi-collect takes it")->required();
  app.add_option("--groundtruth", groundtruth,
                 "as kintsugi-eval takes it; without, only --pairs can be compared");
  app.add_option("--pairs", pairs, "numbers of frames to compare: FROM,TO ...")->expected(1, 1000);
  app.add_option("--every", every, "without --pairs: every so many-th frame is compared with all such")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--least-overlap", least_overlap, "whose views truly overlap so much")
      ->capture_default_str();
  app.add_option("--feature", feature, "surf or corners")
      ->check(CLI::IsMember({"surf", "corners"}))
      ->capture_default_str();
  app.add_option(
         "--disturb", disturbances,
         "what is done to the colour image of the later frame, one at a time: KIND:LEVEL,LEVEL,... of "
         "tools/match/disturbance.h")
      ->expected(1, 10);
  app.add_option("--apart", apart, "it is done to pairs that lie at least so many frames apart")
      ->capture_default_str();
  app.add_option("--most-degrees", most_degrees,
                 "and were not taken from directions more different than this")
      ->capture_default_str();
  app.add_option("--most-pairs", most_pairs, "and of these to so many, evenly chosen")->capture_default_str();
}

void FramesCommand::run() const {
  if (groundtruth.empty() && pairs.empty())
    throw Error("give --groundtruth, or the frames to compare with --pairs");
  const std::vector<Disturbing> kinds = wanted(*this);
  const auto frames = open_source(source);
  Stopwatch watch;
  PlaceMaker maker(frames->calibration(), feature, &watch);
  std::vector<Chosen> chosen = named_pairs(*this);
  const std::map<int64_t, Kept> kept = read(*this, *frames, chosen, &maker, &watch);
  if (pairs.empty()) chosen = found_pairs(*this, kept, maker.comparer().depth_camera());
  std::stable_sort(chosen.begin(), chosen.end(), [](const auto& a, const auto& b) { return a.to < b.to; });

  Json rows = Json::array();
  const auto compare = [&](const Chosen& pair, const KnownPlace& seen, const std::string& name,
                           double level) {
    const Kept &from = kept.at(pair.from), &to = kept.at(pair.to);
    std::optional<Pose> T_from_to;
    if (from.truth && to.truth) T_from_to = from.truth->inverse() * *to.truth;
    Json row = pair_json(maker.compare(from.place, seen, T_from_to));
    row["disturbance"] = name;
    row["level"] = level;
    rows.push_back(std::move(row));
  };
  for (const Chosen& pair : chosen) compare(pair, kept.at(pair.to).place, "none", pair.is_disturbed);
  std::erase_if(chosen, [](const Chosen& pair) { return !pair.is_disturbed; });
  for (const auto& [name, level] : kinds) {
    KnownPlace seen;
    for (size_t k = 0; k < chosen.size(); ++k) {
      if (k == 0 || chosen[k].to != chosen[k - 1].to) {
        RgbdFrame frame = kept.at(chosen[k].to).frame;
        frame.colour =
            disturbed(frame.colour, disturbance_of(name), level, static_cast<uint64_t>(frame.sequence));
        seen = maker.make(frame);
      }
      compare(chosen[k], seen, name, level);
    }
  }
  print({{"source", source}, {"feature", feature}, {"frames", kept.size()}}, watch, rows);
}

}  // namespace kt
