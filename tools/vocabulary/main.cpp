// kintsugi-train-vocabulary: clusters the features of recordings into the words that places are recognised
// by.
// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>

#include "onboard/loops/keyframe_maker.h"
#include "onboard/loops/vocabulary.h"
#include "onboard/source/frame_source.h"
#include "shared/cli/program.h"
#include "shared/io/file.h"

namespace {

struct Options {
  std::vector<std::string> inputs;
  std::string output, feature = "surf";
  int every = 10;
  kt::Vocabulary::Shape shape{.matching_level = 0};  // measured: see onboard/loops/vocabularies
};

kt::PlaceFeature feature_of(const std::string& name) {
  return name == "surf" ? kt::PlaceFeature::kSurf : kt::PlaceFeature::kCorners;
}

// The descriptors of every `every`-th frame, image by image.
void add_images(const std::string& input, const Options& options, kt::DescriptorKind* kind,
                std::vector<std::vector<uint8_t>>* images) {
  const auto source = kt::open_source(input, std::nullopt);
  const auto device = kt::exec::Device::cpu(1);
  kt::Preprocessor preprocessor(device, source->calibration(), {});
  kt::KeyframeMaker maker(source->calibration(), feature_of(options.feature));
  *kind = maker.kind();
  int64_t frames = 0;
  for (kt::SourceItem item = source->next(); item.kind != kt::SourceItem::Kind::kEnd; item = source->next()) {
    if (item.kind != kt::SourceItem::Kind::kFrame || frames++ % options.every != 0) continue;
    const kt::FrameMaps& maps = preprocessor.process(item.frame);
    if (!maps.has_colour) continue;
    images->push_back(maker.make(kt::KeyframeMaker::images_of(maps, {}, {})).descriptors);
  }
}

void run(const Options& options) {
  std::vector<std::vector<uint8_t>> images;
  kt::DescriptorKind kind;
  for (const std::string& input : options.inputs) {
    const size_t before = images.size();
    add_images(input, options, &kind, &images);
    std::cout << input << ": " << images.size() - before << " images" << std::endl;
  }
  size_t descriptors = 0;
  for (const auto& image : images) descriptors += image.size() / static_cast<size_t>(kind.bytes);
  const kt::Vocabulary vocabulary = kt::Vocabulary::train(kind, images, options.shape);
  const std::vector<uint8_t> bytes = vocabulary.encoded();
  kt::write_file(options.output, kt::as_text(bytes));
  std::cout << options.output << ": " << vocabulary.word_count() << " words of " << descriptors
            << " descriptors, " << bytes.size() << " bytes" << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Clusters the features of recordings into the words that places are recognised by."};
  app.add_option("inputs", options.inputs, "recordings, as --input of kintsugi-collect takes them")
      ->required();
  app.add_option("-o,--output", options.output, "vocabulary file to write")->required();
  app.add_option("-f,--feature", options.feature, "feature whose descriptors are clustered")
      ->check(CLI::IsMember({"surf", "corners"}))
      ->capture_default_str();
  app.add_option("--every", options.every, "frames from one image to the next")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--branching", options.shape.branching, "children of a node")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  app.add_option("--depth", options.shape.depth, "levels below the root")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--matching-level", options.shape.matching_level,
                 "level whose nodes gather descriptors to be compared")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
  return kt::run_program(app, argc, argv, [&] { run(options); });
}
