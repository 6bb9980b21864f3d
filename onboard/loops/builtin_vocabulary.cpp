// Files of tools/train_vocabulary, made part of the program by the assembler.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/loops/builtin_vocabulary.h"

#include "shared/core/check.h"

#define KT_EMBED(symbol, file)                                                             \
  asm(".section .rodata\n"                                                                 \
      ".balign 16\n" #symbol "_begin:\n.incbin \"" KT_VOCABULARIES "/" file "\"\n" #symbol \
      "_end:\n"                                                                            \
      ".byte 0\n.previous\n");                                                             \
  extern "C" const uint8_t symbol##_begin[] __attribute__((visibility("hidden")));         \
  extern "C" const uint8_t symbol##_end[] __attribute__((visibility("hidden")))

KT_EMBED(kt_vocabulary_surf64, "surf64.voc");
KT_EMBED(kt_vocabulary_orb256, "orb256.voc");

namespace kt {

const Vocabulary& builtin_vocabulary(std::string_view type) {
  if (type == "surf64") {
    static const Vocabulary vocabulary =
        Vocabulary::decode({kt_vocabulary_surf64_begin, kt_vocabulary_surf64_end}, "surf64.voc");
    return vocabulary;
  }
  if (type == "orb256") {
    static const Vocabulary vocabulary =
        Vocabulary::decode({kt_vocabulary_orb256_begin, kt_vocabulary_orb256_end}, "orb256.voc");
    return vocabulary;
  }
  throw Error("no vocabulary for descriptors of type " + std::string(type));
}

const Vocabulary& vocabulary_of(std::span<const Keyframe* const> keyframes) {
  KT_CHECK(!keyframes.empty());
  const Vocabulary& vocabulary = builtin_vocabulary(keyframes.front()->descriptor_type);
  const DescriptorKind& kind = vocabulary.kind();
  for (const Keyframe* keyframe : keyframes) {
    if (keyframe->descriptor_type != kind.type)
      throw Error("keyframes with descriptors of type " + kind.type + " and " + keyframe->descriptor_type +
                  " cannot be compared: join logs of one loops.feature");
    if (keyframe->descriptor_size != kind.bytes)
      throw Error("the keyframe of frame " + std::to_string(keyframe->sequence) + " has descriptors of " +
                  std::to_string(keyframe->descriptor_size) + " bytes, those of type " + kind.type +
                  " have " + std::to_string(kind.bytes) + ": its log is of another program");
  }
  return vocabulary;
}

}  // namespace kt
