// kintsugi-match: takes pairs of frames through the tests of a loop candidate, and says what became of each.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "offboard/session/load_session.h"
#include "onboard/loops/keyframe_index.h"
#include "onboard/source/frame_source.h"
#include "shared/cli/program.h"
#include "tools/eval/groundtruth.h"
#include "tools/eval/statistics.h"
#include "tools/match/disturbance.h"
#include "tools/match/orbit.h"
#include "tools/match/pair_comparison.h"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

Json fit_json(const std::optional<PoseFit>& fit) {
  if (!fit) return nullptr;
  return {{"points", fit->points},
          {"surface_rms_m", fit->surface_rms_m},
          {"reprojection_px", fit->reprojection_px},
          {"matches", fit->matches}};
}

/// T by rows, without the last.
Json pose_json(const Pose& T) {
  Json json = Json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) json.push_back(T(row, column));
  return json;
}

Json pair_json(const PairComparison& pair) {
  Json json = {{"from", pair.loop.from},
               {"to", pair.loop.to},
               {"verdict", to_string(pair.loop.verdict)},
               {"similarity", pair.similarity},
               {"matches", pair.loop.matches},
               {"inliers", pair.loop.p_from.size()},
               {"reprojection", pair.loop.reprojection_px},
               {"overlap", pair.loop.overlap},
               {"T_from_to", pair.fit ? pose_json(pair.loop.T_from_to) : Json()},
               {"fit", fit_json(pair.fit)},
               {"truth", nullptr}};
  if (pair.truth) {
    json["truth"] = {{"overlap", pair.truth->overlap},
                     {"viewpoint_deg", pair.truth->viewpoint_deg},
                     {"error_m", pair.fit ? Json(pair.truth->error_m) : Json()},
                     {"error_deg", pair.fit ? Json(pair.truth->error_deg) : Json()},
                     {"fit", fit_json(pair.truth->fit)}};
  }
  return json;
}

class Stopwatch {
 public:
  template <typename Body>
  auto time(const char* what, const Body& body) {
    const auto start = std::chrono::steady_clock::now();
    auto result = body();
    add(what, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    return result;
  }
  void add(const char* what, double ms) { times_ms_[what].push_back(ms); }
  Json medians() const {
    Json json = Json::object();
    for (const auto& [what, times] : times_ms_) json[what] = quantile(times, 0.5);
    return json;
  }

 private:
  std::map<std::string, std::vector<double>> times_ms_;
};

/// Turns frames into keyframes with their words, one after the other.
class PlaceMaker {
 public:
  PlaceMaker(const Calibration& calibration, const std::string& feature, Stopwatch* watch)
      : preprocessor_(exec::Device::cpu(1), calibration, {}),
        maker_(calibration, feature == "surf" ? PlaceFeature::kSurf : PlaceFeature::kCorners),
        comparer_(calibration, maker_.kind().type),
        watch_(watch) {}

  KnownPlace make(const RgbdFrame& frame) {
    StampedPose pose;
    pose.sequence = frame.sequence;
    pose.timestamp_us = frame.timestamp_us;
    const FrameMaps& maps = preprocessor_.process(frame);
    const KeyframeImages images = KeyframeMaker::images_of(maps, {}, pose);
    Keyframe keyframe = watch_->time("features", [&] { return maker_.make(images); });
    return watch_->time("words", [&] { return comparer_.known(std::move(keyframe)); });
  }
  PairComparison compare(const KnownPlace& from, const KnownPlace& to, const std::optional<Pose>& T_from_to) {
    PairComparison pair = comparer_.compare(from, to, T_from_to);
    watch_->add("verification", pair.verification_ms);
    return pair;
  }
  PairComparer& comparer() { return comparer_; }

 private:
  Preprocessor preprocessor_;
  KeyframeMaker maker_;
  PairComparer comparer_;
  Stopwatch* watch_;
};

void print(Json report, const Stopwatch& watch, Json pairs) {
  report["median_ms"] = watch.medians();
  report["pairs"] = std::move(pairs);
  std::fputs((report.dump() + "\n").c_str(), stdout);
}

struct FramesCommand {
  std::string source, groundtruth, feature = "surf";
  std::vector<std::string> pairs, disturbances;
  int64_t every = 10, apart = 1;
  size_t most_pairs = 40;
  double least_overlap = 0.4, most_degrees = 20;

  void add_to(CLI::App& app) {
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
    app.add_option("--most-pairs", most_pairs, "and of these to so many, evenly chosen")
        ->capture_default_str();
  }

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

  std::vector<Chosen> named_pairs() const {
    std::vector<Chosen> result;
    for (const std::string& text : pairs) {
      long long a = 0, b = 0;
      char end = 0;
      if (std::sscanf(text.c_str(), "%lld,%lld%c", &a, &b, &end) != 2 || a >= b)
        throw Error("--pairs: '" + text + "' is not FROM,TO with FROM before TO");
      result.push_back({a, b, true});
    }
    return result;
  }

  std::vector<Disturbing> wanted() const {
    std::vector<Disturbing> result;
    for (const std::string& text : disturbances) {
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

  std::vector<Chosen> found_pairs(const std::map<int64_t, Kept>& kept, const PinholeParams& camera) const {
    std::vector<Chosen> result;
    std::vector<size_t> near;
    for (auto from = kept.begin(); from != kept.end(); ++from) {
      for (auto to = std::next(from); to != kept.end(); ++to) {
        if (!from->second.truth || !to->second.truth) continue;
        const ViewChange change = view_change(camera, from->second.place.place.keyframe.depth,
                                              to->second.place.place.keyframe.depth,
                                              from->second.truth->inverse() * *to->second.truth);
        if (change.overlap < least_overlap) continue;
        if (change.viewpoint_deg <= most_degrees && to->first - from->first >= apart)
          near.push_back(result.size());
        result.push_back({from->first, to->first, false});
      }
    }
    const size_t count = std::min(most_pairs, near.size());
    for (size_t k = 0; k < count; ++k) result[near[k * near.size() / count]].is_disturbed = true;
    return result;
  }

  std::map<int64_t, Kept> read(FrameSource& frames, const std::vector<Chosen>& named, PlaceMaker* maker,
                               Stopwatch* watch) const {
    std::map<int64_t, Kept> kept;
    KeyframeIndex index(maker->comparer().vocabulary().word_count());
    for (SourceItem item = frames.next(); item.kind != SourceItem::Kind::kEnd; item = frames.next()) {
      if (item.kind != SourceItem::Kind::kFrame || item.frame.colour.empty()) continue;
      const int64_t number = item.frame.sequence;
      const auto is_its = [&](const Chosen& pair) { return pair.from == number || pair.to == number; };
      if (named.empty() ? number % every != 0 : std::none_of(named.begin(), named.end(), is_its)) continue;
      Kept& one = kept[number];
      one.place = maker->make(item.frame);
      watch->time("search", [&] { return index.search(one.place.bag, index.size(), 0.01f, 3); });
      index.add(one.place.bag);
      if (!disturbances.empty()) one.frame = std::move(item.frame);
    }
    for (const Chosen& pair : named) {
      for (const int64_t number : {pair.from, pair.to})
        if (!kept.contains(number))
          throw Error(source + " has no frame " + std::to_string(number) + " with colour");
    }
    if (groundtruth.empty()) return kept;
    std::vector<int64_t> stamps_us;
    for (const auto& [number, one] : kept) stamps_us.push_back(one.place.place.keyframe.timestamp_us);
    const auto truth = poses_at(read_groundtruth(groundtruth), stamps_us);
    size_t k = 0;
    for (auto& [number, one] : kept) one.truth = truth[k++];
    return kept;
  }

  void run() const {
    if (groundtruth.empty() && pairs.empty())
      throw Error("give --groundtruth, or the frames to compare with --pairs");
    const std::vector<Disturbing> kinds = wanted();
    const auto frames = open_source(source);
    Stopwatch watch;
    PlaceMaker maker(frames->calibration(), feature, &watch);
    std::vector<Chosen> chosen = named_pairs();
    const std::map<int64_t, Kept> kept = read(*frames, chosen, &maker, &watch);
    if (pairs.empty()) chosen = found_pairs(kept, maker.comparer().depth_camera());
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
};

struct OrbitCommand {
  std::string mission, feature = "surf";
  std::vector<double> degrees = {0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60};
  int64_t every = 40;
  double ahead_m = 2;

  void add_to(CLI::App& app) {
    app.add_option("mission", mission, "synthetic mission whose world is looked at")->required();
    app.add_option("--degrees", degrees, "angles that the camera is led around")->expected(1, 100);
    app.add_option("--ahead", ahead_m, "distance of the point that it is led around (m)")
        ->capture_default_str();
    app.add_option("--every", every, "frames from one place to the next")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--feature", feature, "surf or corners")
        ->check(CLI::IsMember({"surf", "corners"}))
        ->capture_default_str();
  }

  void run() const {
    const SyntheticMission world(mission);
    Stopwatch watch;
    PlaceMaker maker(world.calibration(), feature, &watch);
    Json rows = Json::array();
    int64_t number = 0;
    for (int64_t i = 0; i < world.frame_count(); i += every) {
      const Pose T_world_from = world.groundtruth()[static_cast<size_t>(i)].T_odom_camera;
      const double side = i / every % 2 == 0 ? 1 : -1;
      const KnownPlace from = maker.make(render_at(world, T_world_from, number++));
      for (const double angle : degrees) {
        const Pose T_world_to = orbited(T_world_from, ahead_m, side * angle * std::numbers::pi / 180);
        if (!stands_free(world, T_world_to)) continue;
        const KnownPlace to = maker.make(render_at(world, T_world_to, number++));
        Json row = pair_json(maker.compare(from, to, T_world_from.inverse() * T_world_to));
        row["place"] = i;
        row["disturbance"] = "viewpoint";
        row["level"] = angle;
        rows.push_back(std::move(row));
      }
    }
    print({{"source", "synthetic:" + mission}, {"feature", feature}}, watch, rows);
  }
};

struct LogCommand {
  std::string log, groundtruth;
  bool all = false;

  void add_to(CLI::App& app) {
    app.add_option("log", log, "a mission's log")->required();
    app.add_option("--groundtruth", groundtruth, "as kintsugi-eval takes it");
    app.add_flag("--all", all, "rejected candidates too");
  }

  void run() const {
    const Session session = load_session(log);
    if (session.keyframes.empty()) throw Error(log + " holds no keyframes");
    PairComparer comparer(session.header.calibration, session.keyframes.front().descriptor_type);
    std::vector<int64_t> stamps_us;
    for (const Keyframe& keyframe : session.keyframes) stamps_us.push_back(keyframe.timestamp_us);
    std::vector<std::optional<Pose>> truth(stamps_us.size());
    if (!groundtruth.empty()) truth = poses_at(read_groundtruth(groundtruth), stamps_us);
    std::map<int64_t, std::pair<KnownPlace, std::optional<Pose>>> places;
    for (size_t k = 0; k < stamps_us.size(); ++k)
      places[session.keyframes[k].sequence] = {comparer.known(session.keyframes[k]), truth[k]};
    Json rows = Json::array();
    Stopwatch watch;
    for (const LoopClosure& loop : session.loop_closures) {
      const auto from = places.find(loop.from), to = places.find(loop.to);
      if ((!all && !loop.accepted()) || from == places.end() || to == places.end()) continue;
      std::optional<Pose> T_from_to;
      if (from->second.second && to->second.second)
        T_from_to = from->second.second->inverse() * *to->second.second;
      const PairComparison pair = comparer.compare(from->second.first, to->second.first, T_from_to);
      watch.add("verification", pair.verification_ms);
      rows.push_back(pair_json(pair));
    }
    print({{"source", log}, {"feature", comparer.vocabulary().kind().type}}, watch, rows);
  }
};

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  CLI::App app("Takes pairs of frames through the tests of a loop candidate; prints JSON.", "kintsugi-match");
  app.require_subcommand(1);
  kt::FramesCommand frames;
  kt::OrbitCommand orbit;
  kt::LogCommand log;
  CLI::App* frames_app =
      app.add_subcommand("frames", "pairs of a recording, the later frame disturbed where asked");
  CLI::App* orbit_app = app.add_subcommand("orbit", "views of a synthetic world around a point");
  CLI::App* log_app =
      app.add_subcommand("log", "the accepted candidates of a log, once more from its keyframes");
  frames.add_to(*frames_app);
  orbit.add_to(*orbit_app);
  log.add_to(*log_app);
  return kt::run_program(app, argc, argv, [&] {
    if (frames_app->parsed()) frames.run();
    if (orbit_app->parsed()) orbit.run();
    if (log_app->parsed()) log.run();
  });
}
