// Chains the keys of the stages.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/app/stage_keys.h"

#include <string>

#include "offboard/app/stage_fields.h"
#include "offboard/stages/file_identity.h"
#include "shared/core/version.h"
#include "shared/wire/log_parts.h"

namespace kt {
namespace {

// Raised where the content of stage files changes its meaning without a field that comes or goes.
constexpr int kStageFormat = 1;

template <typename... T>
Digest key_of(const T&... values) {
  StageWriter key;
  add_to_key(key, values...);
  return key.digest();
}

// "tum:" and which files; "synthetic:NAME" as it stands.
std::string identity_of_source(const std::string& spec) {
  const size_t colon = spec.find(':');
  const std::filesystem::path path = spec.substr(colon + 1);
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return spec;
  if (std::filesystem::is_directory(path, ignored))
    return spec.substr(0, colon + 1) + identity_of(path).hex();
  std::string identity = spec.substr(0, colon + 1);
  for (const std::filesystem::path& part : log_parts(path).paths) identity += identity_of(part).hex();
  return identity;
}

}  // namespace

Digest load_key(const MapOptions& options) {
  std::vector<std::string> logs;
  for (const std::filesystem::path& log : options.logs) {
    for (const std::filesystem::path& part : log_parts(log).paths) logs.push_back(identity_of(part).hex());
    logs.emplace_back();  // where a log ends
  }
  return key_of(kStageFormat, std::string(kProgramVersion), logs);
}

Digest loops_key(const Digest& load, const LoopOptions& config) { return key_of(load.value(), config); }

Digest optimise_key(const Digest& loops, const PoseGraphOptions& options) {
  return key_of(loops.value(), options);
}

Digest refine_key(const Digest& optimise, bool refines) { return key_of(optimise.value(), refines); }

Digest deform_key(const Digest& refine, bool surface_constraints) {
  return key_of(refine.value(), surface_constraints);
}

Digest fuse_key(const Digest& refine, const std::vector<std::string>& frames,
                const ReintegrationConfig& config, bool even_exposure) {
  std::vector<std::string> sources;
  for (const std::string& spec : frames) sources.push_back(identity_of_source(spec));
  return key_of(refine.value(), sources, config, even_exposure);
}

}  // namespace kt
